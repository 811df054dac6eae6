"""A sequence to a report: names, then every file in processes of its own, then all frames together."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from . import checks  # noqa: F401  (registers them)
from .analysis import Job, analyse, confirm_fireflies, without_pixels
from .findings import CHECKS, Finding, Scope, Severity, checks_of, ordered
from .options import Options
from .parallel import in_processes
from .sequence import Listing, SequenceError, list_sequence
from .summary import FrameSummary, Rendered

Progress = Callable[[int, int], None]
"""Told how many frames are done, of how many."""


@dataclass(frozen=True)
class Report:
    """What was found, the worst first."""

    listing: Listing
    frames: list[FrameSummary]
    findings: list[Finding]
    options: Options

    def count(self, severity: Severity) -> int:
        """Findings of a severity."""
        return sum(finding.severity is severity for finding in self.findings)

    @property
    def rerender(self) -> list[int]:
        """Frames that are missing or have to be rendered again."""
        return sorted({f.frame for f in self.findings if f.frame is not None and CHECKS[f.check].rerender})

    def fails(self, at: Severity) -> bool:
        """True if there is a finding at least as bad."""
        return self.count(Severity.ERROR) > 0 or (at is Severity.WARNING and self.count(Severity.WARNING) > 0)


def validate(target: str | Path, options: Options = Options(), progress: Progress = lambda done, of: None) -> Report:
    """Checks every frame of `target`, a folder or a pattern such as `out/x.####.exr`.

    A script that calls this needs the usual `if __name__ == "__main__":`, since frames are decoded in processes. Raises
    `SequenceError` if there is nothing to check.
    """
    listing = list_sequence(target, options.frames)
    seconds = _render_seconds(options.stats) if options.stats else {}
    jobs = _jobs(listing, options)
    processes = min(os.cpu_count() or 1 if options.processes is None else options.processes, len(jobs))
    frames: list[FrameSummary] = []
    for summary in in_processes(analyse, jobs, processes, _crashed):
        summary.render_seconds = seconds.get(summary.number)
        frames.append(summary)
        progress(len(frames), len(jobs))
    if "firefly" not in options.skip_checks:
        _confirm(frames, processes)
    findings = [finding for frame in frames for finding in frame.findings]
    for scope, subject in ((Scope.LISTING, listing), (Scope.SEQUENCE, Rendered(frames, options))):
        for check in checks_of(scope):
            if check.id not in options.skip_checks:
                findings += check.run(subject)
    return Report(listing, frames, ordered(findings), options)


def _jobs(listing: Listing, options: Options) -> list[Job]:
    references: dict[int, str] = {}
    if options.reference is not None:
        references = {file.number: str(file.path) for file in list_sequence(options.reference).frames}
    width = 0
    if options.thumbnails:
        width = 96 if len(listing.frames) <= 200 else 48
    return [
        Job(
            number=file.number,
            path=str(file.path),
            compares=options.reference is not None,
            reference=references.get(file.number),
            wants_flip=options.max_flip is not None,
            thumbnail_width=width,
            skip_checks=options.skip_checks,
        )
        for file in listing.frames
    ]


def _crashed(job: Job) -> FrameSummary:
    return without_pixels(job, "the decoder crashed")


def _confirm(frames: list[FrameSummary], processes: int) -> None:
    """Looks the frames before and after up for what seems to be a firefly."""
    by_number = {frame.number: frame for frame in frames if frame.decoded}
    suspects = [frame for frame in frames if frame.firefly_candidates]
    arguments = [
        (frame.firefly_candidates, [by_number[n].path for n in (frame.number - 1, frame.number + 1) if n in by_number])
        for frame in suspects
    ]
    if not suspects:
        return
    results = in_processes(_confirm_one, arguments, min(processes, len(suspects)), lambda argument: argument[0])
    for frame, found in zip(suspects, results):
        frame.fireflies = found


def _confirm_one(argument):
    return confirm_fireflies(*argument)


def _render_seconds(path: Path) -> dict[int, float]:
    """Render time of each frame, from what `sunfleck render --stats` wrote."""
    try:
        seconds = {}
        for line in path.read_text(encoding="utf-8").splitlines():
            entry = json.loads(line)
            if "render_seconds" in entry:
                seconds[int(entry["frame"])] = float(entry["render_seconds"])
        return seconds
    except OSError as error:
        raise SequenceError(f"cannot read {path}: {error.strerror}", is_usage=False) from error
    except (ValueError, KeyError, TypeError) as error:
        raise SequenceError(f"{path} is not what `sunfleck render --stats` writes: {error}") from error
