"""A path to a stage that holds together, with its clock and its units.

Invariant: a stage that is handed out has every file that it refers to, and no arc of it comes round.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np
from pxr import Tf, Usd, UsdGeom, UsdUtils

from ...errors import SceneError

MOST_FRAMES = 100_000
MOST_NAMED = 10
"""Of errors of one kind."""


@dataclass(frozen=True)
class Source:
    """An opened stage. Codes are time codes, frames what they are numbered as."""

    path: Path
    stage: Usd.Stage
    fps: Fraction
    codes: np.ndarray
    by_blender: bool
    by_us: bool
    for_blender: bool

    def seconds(self, codes: np.ndarray) -> np.ndarray:
        """The time of time codes."""
        return np.asarray(codes, float) / self.stage.GetTimeCodesPerSecond()

    @property
    def first(self) -> float:
        """The code at which everything stands that does not move."""
        return float(self.codes[0])

    @property
    def frames(self) -> tuple[int, int]:
        """First and last frame."""
        rate = float(self.fps) / self.stage.GetTimeCodesPerSecond()
        return round(self.codes[0] * rate), round(self.codes[-1] * rate)

    @property
    def metres(self) -> float:
        """Of a unit of the stage."""
        return UsdGeom.GetStageMetersPerUnit(self.stage)


@contextmanager
def usd_said(path: Path) -> Iterator[None]:
    """Has USD's errors about a file raised as `SceneError`, and nothing printed: what matters is said once, by us."""
    silenced = UsdUtils.CoalescingDiagnosticDelegate()
    try:
        yield
    except Tf.ErrorException as error:
        raise SceneError(f"{path}: is no stage that can be read: {_said(error)}") from None
    except (TypeError, ValueError, OverflowError) as error:
        # Attributes of schemas may have any type; what numpy and Python make of those is one fault.
        raise SceneError(f"{path}: holds a value that does not fit its place: {error}") from None
    except MemoryError:
        raise SceneError(f"{path}: needs more memory than there is") from None
    finally:
        silenced.TakeUncoalescedDiagnostics()


def open_stage(path: Path) -> Source:
    """Opens a stage; raises `SceneError` with everything that is missing or goes round in circles."""
    if not path.is_file():
        raise SceneError(f"{path}: cannot be read: there is no such file")
    stage = Usd.Stage.Open(str(path))
    errors = [str(error).strip() for error in stage.GetCompositionErrors()]
    if errors:
        raise SceneError(f"{path}: does not hold together:\n" + listed(errors))
    metres = UsdGeom.GetStageMetersPerUnit(stage)
    if not (math.isfinite(metres) and metres > 0):
        raise SceneError(f"{path}: a unit of {metres} metres is no unit")
    fps, codes = _clock(path, stage)
    said = stage.GetRootLayer().documentation
    ours = stage.GetRootLayer().customLayerData.get("sunfleck")
    is_for = ours.get("for") if isinstance(ours, dict) else None
    return Source(path, stage, fps, codes, said.startswith("Blender v"), bool(ours), is_for == "blender")


def _said(error: Exception) -> str:
    """Without the places in USD's own sources."""
    try:
        lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    except UnicodeDecodeError:
        lines = []
    return lines[0].rpartition(": '")[2].rstrip("'") if lines else "it is damaged"


def listed(errors: list[str]) -> str:
    """The first few, a line each."""
    shown = [f"  {' '.join(error.split())}" for error in errors[:MOST_NAMED]]
    return "\n".join(shown + ([f"  and {len(errors) - MOST_NAMED} more"] if len(errors) > MOST_NAMED else []))


def _clock(path: Path, stage: Usd.Stage) -> tuple[Fraction, np.ndarray]:
    """Frame rate, and the codes of whole frames."""
    per_second = stage.GetTimeCodesPerSecond()
    rate = stage.GetFramesPerSecond() if stage.GetRootLayer().HasFramesPerSecond() else per_second
    if not all(math.isfinite(each) and 1e-3 < each < 1e6 for each in (per_second, rate)):
        raise SceneError(f"{path}: {rate} frames and {per_second} time codes a second are no rates")
    start, end = stage.GetStartTimeCode(), stage.GetEndTimeCode()
    if not stage.HasAuthoredTimeCodeRange():
        start = end = 1.0
    codes_per_frame = per_second / rate
    first, last = math.ceil(start / codes_per_frame - 1e-6), math.floor(end / codes_per_frame + 1e-6)
    if not (math.isfinite(start) and math.isfinite(end)) or not 0 <= last - first < MOST_FRAMES:
        raise SceneError(f"{path}: time codes {start} to {end} are no range of 1 to {MOST_FRAMES} frames")
    # glTF has no times before 0.
    frames = np.arange(max(first, 0), max(last, 0) + 1)
    return Fraction(rate).limit_denominator(1001), frames * codes_per_frame
