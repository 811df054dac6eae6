"""Validation of sequences. In goes a target, out comes a report: names first, then every file in processes
of its own, then all frames together."""

import json
import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from . import checks  # noqa: F401  (registers them)
from .analysis import Job, analyse, confirm, without_pixels
from .checks.constancy import scene_frames
from .disk import need_regular
from .findings import CHECKS, Finding, Severity, findings_in, ordered
from .options import Options
from .parallel import in_processes
from .sequence import Listing, SequenceError, list_sequence, list_sequences
from .summary import FrameSummary, Rendered, Suspicion

Progress = Callable[[int, int], None]
"""Callback with the numbers of finished and of all frames."""


@dataclass(frozen=True)
class Checked:
    """One sequence with its findings, worst first."""

    listing: Listing
    frames: list[FrameSummary]
    findings: list[Finding]

    @property
    def rerender(self) -> list[int]:
        """Frames that are missing or have to be rendered again."""
        return sorted({f.frame for f in self.findings if f.frame is not None and CHECKS[f.check].rerender})

    def count(self, severity: Severity) -> int:
        """Findings of a severity."""
        return sum(finding.severity is severity for finding in self.findings)


@dataclass(frozen=True)
class Report:
    """Findings of all sequences, the longest sequence first."""

    sequences: list[Checked]
    options: Options

    @property
    def frames(self) -> list[FrameSummary]:
        """Frames of all sequences."""
        return [frame for checked in self.sequences for frame in checked.frames]

    @property
    def findings(self) -> list[Finding]:
        """Findings of all sequences, worst first."""
        return ordered([finding for checked in self.sequences for finding in checked.findings])

    @property
    def rerender(self) -> list[int]:
        """Frames that are missing or have to be rendered again, in all sequences."""
        return sorted({number for checked in self.sequences for number in checked.rerender})

    def count(self, severity: Severity) -> int:
        """Findings of a severity."""
        return sum(checked.count(severity) for checked in self.sequences)

    def fails(self, at: Severity) -> bool:
        """True if any finding is at least this severe."""
        return self.count(Severity.ERROR) > 0 or (at is Severity.WARNING and self.count(Severity.WARNING) > 0)


def validate(
    target: str | Path, options: Options = Options(), progress: Progress = lambda done, of: None
) -> Report:
    """Checks every frame of `target`: a folder with one sequence or several, a pattern such as
    `out/x.####.exr`, or one file.

    Raises `SequenceError` if there is nothing to check, and `MemoryError`.
    """
    seconds = render_seconds(options.stats) if options.stats else {}
    listings = list_sequences(target, options.frames)
    of, done = sum(len(listing.asked) for listing in listings), 0
    sequences = []
    for listing in listings:
        asked = len(listing.asked)
        checked = _check(listing, options, seconds, lambda now: progress(done + now, of), listing is listings[0])
        sequences.append(checked)
        done += asked
    return Report(sequences, options)


def _check(
    listing: Listing, options: Options, seconds: dict[int, float], progress: Callable[[int], None], is_first: bool
) -> Checked:
    jobs = _jobs(listing, options)
    processes = min(os.cpu_count() or 1 if options.processes is None else options.processes, len(jobs))
    frames: list[FrameSummary] = []
    for summary in in_processes(analyse, jobs, processes, lambda job: without_pixels(job, "the decoder crashed")):
        summary.render_seconds = seconds.get(summary.number)
        frames.append(summary)
        progress(len(frames))
    if options.frames is None and not listing.is_still:
        # Other frames cannot be rendered again.
        if (found := scene_frames(frames)) is not None:
            listing.confine(*found)
            asked = {file.number for file in listing.asked}
            frames = [frame for frame in frames if frame.number in asked]
        if is_first:
            listing.expect(seconds)
    _look_again(frames, options, processes)
    findings = [finding for frame in frames for finding in frame.findings]
    for subject in (listing, Rendered(frames, options, listing.is_still)):
        findings += findings_in(subject, options.skip_checks)
    if listing.is_still:
        # A file without a number has no frame.
        findings = [replace(finding, frame=None, path=str(listing.files[0].path)) for finding in findings]
    return Checked(listing, frames, ordered(findings))


def _jobs(listing: Listing, options: Options) -> list[Job]:
    references: dict[int, str] = {}
    if options.reference is not None:
        references = {file.number: str(file.path) for file in list_sequence(options.reference).frames}
    width = 0
    if options.thumbnails:
        width = 96 if len(listing.asked) <= 200 else 48
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
        for file in listing.asked
    ]


def _look_again(frames: list[FrameSummary], options: Options, processes: int) -> None:
    """Compares suspected fireflies and lost blocks with neighbouring frames."""
    by_number = {frame.number: frame for frame in frames if frame.decoded}
    suspects = []
    for frame in frames:
        if "firefly" in options.skip_checks:
            frame.suspicion.fireflies = []
        if "black-block" in options.skip_checks:
            frame.suspicion.blocks = []
        if frame.suspicion:
            suspects.append(frame)
    arguments = [
        (frame.suspicion, [by_number[n].path for n in (frame.number - 1, frame.number + 1) if n in by_number])
        for frame in suspects
    ]
    if not suspects:
        return
    results = in_processes(
        _confirm_one, arguments, min(processes, len(suspects)), lambda argument: argument[0]
    )
    for frame, found in zip(suspects, results):
        frame.fireflies, frame.black_blocks = found.fireflies, found.blocks


def _confirm_one(argument: tuple[Suspicion, list[str]]) -> Suspicion:
    return confirm(*argument)


def render_seconds(path: Path) -> dict[int, float]:
    """Render time of each frame, from the file of `sunfleck render --stats`."""
    try:
        need_regular(path)
        seconds = {}
        for line in path.read_text(encoding="utf-8").splitlines():
            entry = json.loads(line)
            if "render_seconds" in entry:
                seconds[int(entry["frame"])] = float(entry["render_seconds"])
        return seconds
    except OSError as error:
        raise SequenceError(f"cannot read {path}: {error.strerror}", is_usage=False) from error
    except (ValueError, KeyError, TypeError, OverflowError, RecursionError) as error:
        raise SequenceError(f"{path} is not what `sunfleck render --stats` writes: {error}") from error
