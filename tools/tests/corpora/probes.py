"""What is tried on a file of each kind, step after step.

Invariant: a file is judged by the first of its worst steps; where all go well, by losses and the
picture. Steps that need one another end with the first that does not go well, and those of frames,
which do not, are all tried.
"""

import json
import os
import sys
import tempfile
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from sunfleck_tools.analysis import read_picture
from sunfleck_tools.commands import FINDINGS

from .files import CorpusFile
from .limited import Ended, Limits, run_limited
from .outcomes import Outcome, loss_ids, outcome_of, sentence_of

PACKAGES = Path(__file__).parents[2]
SMALL = ("--size", "160x90", "--samples", "1")
BLACK_MEAN = 1e-4
"""Mean radiance of a picture in which the exposure of common cameras shows nothing: a shade
of 8 bits is 3e-4."""
CAUSES_OF_BLACK = frozenset(
    {
        "dark-frame",
        "no-light",
        "nothing-to-draw",
        "mesh-without-triangles",
        "primitive-without-positions",
        "points-and-lines",
    }
)
"""Losses that say why there is nothing to be seen."""


@dataclass(frozen=True)
class Programs:
    """What is run, and how far."""

    sunfleck: str = "sunfleck"
    tools: tuple[str, ...] = (sys.executable, "-m", "sunfleck_tools")
    limits: Limits = field(default_factory=Limits)

    def run(self, program: str | Sequence[str], *arguments: object) -> Ended:
        """One of them, under the limits, with this package on the path of Python."""
        command = [program] if isinstance(program, str) else [*program]
        path = os.pathsep.join(filter(None, (str(PACKAGES), os.environ.get("PYTHONPATH"))))
        return run_limited([*command, *arguments], self.limits, {**os.environ, "PYTHONPATH": path})


@dataclass(frozen=True)
class Verdict:
    """What became of a file; `step` is the command that was decisive, `refused_by` are
    all that refused it."""

    file: CorpusFile
    outcome: Outcome
    step: str
    sentence: str = ""
    losses: tuple[str, ...] = ()
    cpu_s: float = 0.0
    peak_bytes: int = 0
    mean: float | None = None
    refused_by: tuple[str, ...] = ()


class _Stopped(Exception):
    """A step did not go well."""


@dataclass
class _Trial:
    """The steps of one file so far."""

    file: CorpusFile
    programs: Programs
    scratch: Path
    ended: list[Ended] = field(default_factory=list)
    outcome: Outcome = Outcome.DONE
    step: str = ""
    sentence: str = ""
    refused_by: list[str] = field(default_factory=list)

    def sunfleck(self, *arguments: object, findings: int | None = None) -> Ended:
        """Runs a command of the renderer; raises `_Stopped` where the file gets no further."""
        return self._run(str(arguments[0]), self.programs.run(self.programs.sunfleck, *arguments), findings)

    def tools(self, *arguments: object, findings: int | None = None) -> Ended:
        """The same with a command of the tools."""
        return self._run(str(arguments[0]), self.programs.run(self.programs.tools, *arguments), findings)

    def _run(self, step: str, ended: Ended, findings: int | None) -> Ended:
        self.ended.append(ended)
        outcome = outcome_of(ended, self.programs.limits, findings)
        if outcome is Outcome.REFUSED:
            self.refused_by.append(step)
        if outcome.is_worse_than(self.outcome):
            # The folder has another name each time.
            self.outcome, self.step = outcome, step
            self.sentence = sentence_of(ended).replace(f"{self.scratch}{os.sep}", "")
        if outcome not in (Outcome.DONE, Outcome.WITH_LOSSES):
            raise _Stopped
        return ended

    def verdict(self, mean: float | None = None) -> Verdict:
        """By the step that did not go well, and by the picture's mean."""
        losses = tuple(dict.fromkeys(id for ended in self.ended for id in loss_ids(ended)))
        outcome = self.outcome
        if mean is not None and not mean >= BLACK_MEAN:
            outcome = Outcome.BLACK if CAUSES_OF_BLACK.isdisjoint(losses) else Outcome.BLACK_WITH_CAUSE
        is_cut_short = outcome is Outcome.REFUSED or (outcome.is_fault and outcome is not Outcome.BLACK)
        return Verdict(
            self.file, outcome, self.step, self.sentence if is_cut_short else "", losses,
            max(ended.cpu_s for ended in self.ended), max(ended.peak_bytes for ended in self.ended), mean, tuple(self.refused_by),
        )  # fmt: skip


def verdict_on(file: CorpusFile, programs: Programs) -> Verdict:
    """Tries the file, in a folder that is gone afterwards."""
    with tempfile.TemporaryDirectory(prefix="corpora-") as folder:
        trial = _Trial(file, programs, Path(folder))
        try:
            mean = STEPS[file.kind](trial)
        except _Stopped:
            mean = None
        return trial.verdict(mean)


def _render(trial: _Trial, path: Path) -> float:
    """The mean of the first frame's picture."""
    inspected = trial.sunfleck("inspect", path, "--json")
    first = _first_frame(inspected.out)
    frame = trial.scratch / "frame.####.exr"
    trial.sunfleck(
        "render",
        path,
        *SMALL,
        "--frames",
        "all" if first is None else first,
        "--out",
        frame,
        "--progress",
        "none",
    )
    return mean_radiance(next(trial.scratch.glob("frame.*.exr")))


def _first_frame(inspected: str) -> int | None:
    try:
        return int(json.loads(inspected)["frame_start"])
    except (ValueError, KeyError, TypeError):
        return None


def _import_and_render(trial: _Trial) -> float:
    glb = trial.scratch / "stage.glb"
    trial.tools("import-usd", trial.file.path, glb)
    return _render(trial, glb)


def _read_frame(trial: _Trial) -> None:
    """Every command that takes frames, with this one as a sequence of its own."""
    folder = trial.scratch / "frames"
    folder.mkdir()
    frame = folder / "frame.0001.exr"
    frame.symlink_to(trial.file.path.resolve())
    for try_it in (
        lambda: trial.tools("validate", folder, "--processes", 1, findings=FINDINGS),
        lambda: trial.sunfleck("diff", frame, frame),
        lambda: trial.sunfleck("preview", folder, "--out", trial.scratch / "sheet.png"),
    ):
        with suppress(_Stopped):
            try_it()


STEPS: dict[str, Callable[[_Trial], float | None]] = {
    "gltf": lambda trial: _render(trial, trial.file.path),
    "obj": lambda trial: _render(trial, trial.file.path),
    "usd": _import_and_render,
    "exr": _read_frame,
}


def mean_radiance(path: Path) -> float:
    """Over pixels and colours, NaN if the frame cannot be read."""
    frame, _ = read_picture(path)
    return float("nan") if frame is None else float(np.mean(frame.group()))
