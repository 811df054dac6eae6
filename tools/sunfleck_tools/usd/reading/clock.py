"""Frame rate and frames of a stage. Invariant: an approximate broadcast rate becomes the exact fraction."""

import math
from fractions import Fraction
from pathlib import Path

import numpy as np
from pxr import Usd

from ...errors import SceneError
from .losses import Losses

MOST_FRAMES = 100_000
USUAL_RATE = 24.0
"""Default time codes a second of a layer (SdfLayer)."""
NEAR_TELEVISION = 0.005
"""Tolerance of broadcast rates: 23.98 and 23.976 both mean 24000/1001."""


def exact_rate(rate: float) -> Fraction:
    """Fraction for a decimal rate: n, n * 1000/1001, or the nearest of small denominator."""
    whole = math.ceil(rate - 1e-9)
    television = Fraction(whole * 1000, 1001)
    if rate != whole and abs(rate - television) < NEAR_TELEVISION:
        return television
    return Fraction(rate).limit_denominator(1001)


def put_rates_right(stage: Usd.Stage, lost: Losses) -> None:
    """Removes invalid time codes per second from layers, in memory alone. With a rate of 0, samples of a
    sublayer would lie at no time, and USD would not end its search."""
    for layer in stage.GetUsedLayers():
        if layer.HasTimeCodesPerSecond():
            rate = layer.timeCodesPerSecond
            if _rate(rate, "time codes", lost) != rate:
                layer.SetPermissionToEdit(True)
                layer.ClearTimeCodesPerSecond()


def read_clock(
    path: Path, stage: Usd.Stage, asked: tuple[int, int] | None, lost: Losses
) -> tuple[Fraction, Fraction, np.ndarray]:
    """Frames a second, time codes a second, and the codes of whole frames; `asked` overrides the stage's own
    range.

    Invalid rates and ranges are reported and replaced. Raises `SceneError` if the requested range is
    invalid.
    """
    per_second = _rate(stage.GetTimeCodesPerSecond(), "time codes", lost)
    has_own = stage.GetRootLayer().HasFramesPerSecond()
    rate = _rate(stage.GetFramesPerSecond(), "frames", lost) if has_own else per_second
    fps, codes_per_second = exact_rate(rate), exact_rate(per_second)
    codes_per_frame = float(codes_per_second / fps)
    start, end = (
        _range(stage, codes_per_frame, lost) if asked is None else (each * codes_per_frame for each in asked)
    )
    if not _is_range(start, end, codes_per_frame):
        raise SceneError(f"{path}: time codes {start} to {end} are no range of 1 to {MOST_FRAMES} frames")
    first, last = _frames(start, end, codes_per_frame)
    # glTF has no times before 0.
    frames = np.arange(max(first, 0), max(last, 0) + 1)
    return fps, codes_per_second, frames * codes_per_frame


def _rate(rate: float, what: str, lost: Losses) -> float:
    """The rate, or USD's default for an invalid one."""
    if math.isfinite(rate) and 1e-3 < rate < 1e6:
        return rate
    lost.add("usd-clock", "/", f"{rate:g} {what} a second are no rate; {USUAL_RATE:g} are taken")
    return USUAL_RATE


def _frames(start: float, end: float, codes_per_frame: float) -> tuple[int, int]:
    """First and last whole frame."""
    return math.ceil(start / codes_per_frame - 1e-6), math.floor(end / codes_per_frame + 1e-6)


def _is_range(start: float, end: float, codes_per_frame: float) -> bool:
    if not (math.isfinite(start) and math.isfinite(end)):
        return False
    first, last = _frames(start, end, codes_per_frame)
    return 0 <= last - first < MOST_FRAMES


def _range(stage: Usd.Stage, codes_per_frame: float, lost: Losses) -> tuple[float, float]:
    """First and last time code of the stage; if they are invalid, that is reported, and the samples' range
    is used."""
    has_own = stage.HasAuthoredTimeCodeRange()
    start, end = (stage.GetStartTimeCode(), stage.GetEndTimeCode()) if has_own else _of_samples(stage)
    if _is_range(start, end, codes_per_frame):
        return start, end
    said = f"time codes {start:g} to {end:g} are no range of 1 to {MOST_FRAMES} frames"
    sampled = _of_samples(stage)
    if _is_range(*sampled, codes_per_frame):
        what = f"{said}; {sampled[0]:g} to {sampled[1]:g}, which its samples have, are taken"
        lost.add("usd-clock", "/", what)
        return sampled
    first = 0.0
    if math.isfinite(sampled[0]):
        first = max(math.ceil(sampled[0] / codes_per_frame - 1e-6), 0) * codes_per_frame
    lost.add("usd-clock", "/", f"{said}; {first:g} alone is taken")
    return first, first


def _of_samples(stage: Usd.Stage) -> tuple[float, float]:
    """First and last time code of all samples, else one frame."""
    ends: list[float] = []
    for root in [stage.GetPseudoRoot(), *stage.GetPrototypes()]:
        for prim in Usd.PrimRange.AllPrims(root):
            for attribute in prim.GetAuthoredAttributes():
                ends += _ends(attribute)
    return (min(ends), max(ends)) if ends else (1.0, 1.0)


def _ends(attribute: Usd.Attribute) -> list[float]:
    """First and last time of an attribute's samples."""
    if not attribute.ValueMightBeTimeVarying():
        return []
    if attribute.HasSpline():
        knots = attribute.GetSpline().GetKnots().GetTimeSpan()
        return [knots.min, knots.max]
    samples = attribute.GetTimeSamples()
    return [samples[0], samples[-1]] if samples else []
