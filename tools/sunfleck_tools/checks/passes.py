"""Checks of the invariants of passes, each where the file has them."""

from collections.abc import Iterator

import numpy as np

from ..findings import Found, Severity, check
from ..frame import Frame
from ..layers import Kind, holds_ids, is_cryptomatte, is_motion, kind
from .values import first_bad

FARTHEST = 1.0001e10
"""Maximum depth, as `Z` of the background is 1e10."""
HALF_ROUNDING = 2.0**-9
"""Relative tolerance: two values, each rounded to half precision, and a sum in single precision."""
HALF_SMALLEST = 2.0**-23
"""Absolute tolerance: a step of halves next to zero."""
LARGEST_TRANSMITTANCE = 1 + 2.0**-10
"""One step of half precision above 1: averages of ones may round to it."""
LONGEST_NORMAL = 1.001
LARGEST_HALF_ID = 2048.0
"""Largest integer up to which all are exact in half precision."""
LARGEST_MOTION = 100.0
"""Picture widths beyond which the motion of an isolated pixel is damage."""
LONE_MOTION = 1.0
"""Minimum motion, in picture widths, of the fastest neighbour of an undamaged pixel. Near objects are many
pixels wide. When a fast turning camera has points in its own plane, motion is unbounded, but falls with
the inverse distance: to a quarter of a picture's width, in picture widths, one pixel away."""


@check("beauty-sum", Severity.ERROR, "shafts are brighter than the beauty that they are part of")
def beauty_sum(frame: Frame) -> Iterator[Found]:
    """beauty = background * transmittance + blended surfaces + shafts, and no term is negative."""
    for letter in "RGB":
        if frame.is_exact and letter in frame.channels and f"shafts.{letter}" in frame.channels:
            if _nowhere_above(frame, f"shafts.{letter}", letter):
                continue
            beauty, shafts = frame.float(letter), frame.float(f"shafts.{letter}")
            with np.errstate(invalid="ignore"):
                bad = shafts * (1 - HALF_ROUNDING) > beauty + HALF_SMALLEST
            yield from first_bad(frame, f"shafts.{letter}", bad, f"brighter than {letter}")


def _nowhere_above(frame: Frame, name: str, other: str) -> bool:
    """True if no value of one channel exceeds the other's. False may also mean that a quick test is not
    possible."""
    one, two = frame.channels[name], frame.channels[other]
    if one.dtype != np.float16 or two.dtype != np.float16:
        return False
    # Non-negative halves are ordered like their bits.
    plain = all(low >= 0 for low, _ in map(frame.extremes, (name, other)))
    return plain and not (one.view(np.uint16) > two.view(np.uint16)).any()


@check("transmittance-range", Severity.ERROR, "transmittance is more than 1")
def transmittance_range(frame: Frame) -> Iterator[Found]:
    """Fog and filters only remove light; other renderers may use the name for light."""
    if not frame.is_exact:
        return
    for name in frame.channels:
        if name.startswith("transmittance.") and not frame.extremes(name)[1] <= LARGEST_TRANSMITTANCE:
            with np.errstate(invalid="ignore"):
                yield from first_bad(frame, name, frame.float(name) > LARGEST_TRANSMITTANCE, "more than 1")


@check("depth", Severity.ERROR, "depth is zero, negative, or beyond where rays end")
def depth(frame: Frame) -> Iterator[Found]:
    """No surface is at or behind the camera. Other renderers have other units, directions and backgrounds."""
    if "Z" not in frame.channels or not frame.is_own:
        return
    nearest, farthest = frame.extremes("Z")
    if not (nearest > 0 and farthest <= FARTHEST):
        z = frame.float("Z")
        with np.errstate(invalid="ignore"):
            yield from first_bad(frame, "Z", (z <= 0) | ((z > FARTHEST) & np.isfinite(z)), "no depth")


@check("normal-length", Severity.ERROR, "a normal is longer than 1")
def normal_length(frame: Frame) -> Iterator[Found]:
    """Averages of unit vectors may be shorter, never longer. Other renderers may encode them differently."""
    if not frame.is_exact:
        return
    names = [f"Normal.{axis}" for axis in "XYZ"]
    if all(name in frame.channels for name in names):
        with np.errstate(all="ignore"):
            squared, part = np.square(frame.float(names[0])), np.empty_like(frame.float(names[0]))
            for name in names[1:]:
                squared += np.square(frame.float(name), out=part)
            if not squared.max() <= LONGEST_NORMAL**2:
                yield from first_bad(
                    frame, names[0], squared > LONGEST_NORMAL**2, "part of a normal longer than 1"
                )


@check("leaf-id", Severity.ERROR, "a leaf's number is no whole number")
def leaf_id(frame: Frame) -> Iterator[Found]:
    """An average of two ids would be a third leaf."""
    for name in frame.channels:
        if name.startswith("leaf_id.") and frame.channels[name].dtype.kind == "f":
            values = frame.float(name)
            with np.errstate(invalid="ignore"):
                broken = values != np.rint(values)
                if broken.any():
                    yield from first_bad(frame, name, broken & np.isfinite(values), "not whole")


@check("motion", Severity.ERROR, "motion is not finite, or a pixel alone moves as far as a hundred pictures")
def motion(frame: Frame) -> Iterator[Found]:
    """Vectors in pixels a frame. Other renderers have other units, and other values without motion."""
    if not frame.is_own:
        return
    for name in frame.channels:
        width = frame.header_of(name).size[0]
        limit = LARGEST_MOTION * width
        if is_motion(name) and kind(name) is Kind.DATA and not max(map(abs, frame.extremes(name))) <= limit:
            with np.errstate(invalid="ignore"):
                amount = np.abs(frame.float(name))
                lone = ~(amount <= limit) & ~(_fastest_neighbour(amount) >= LONE_MOTION * width)
                yield from first_bad(frame, name, ~np.isfinite(amount) | lone, "no motion")


def _fastest_neighbour(amount: np.ndarray) -> np.ndarray:
    """Largest finite value among the eight neighbours of each pixel."""
    padded = np.pad(np.where(np.isfinite(amount), amount, 0), 1)
    rows, columns = amount.shape
    around = np.zeros_like(amount)
    for y in range(3):
        for x in range(3):
            if (y, x) != (1, 1):
                np.maximum(around, padded[y : y + rows, x : x + columns], out=around)
    return around


@check("half-id", Severity.ERROR, "names of things are stored in half precision, which cuts them")
def half_id(frame: Frame) -> Iterator[Found]:
    """Cryptomatte's ids have 32 bits, so halves cannot hold them. Plain integers are exact up to 2048."""
    for name, stored in frame.channels.items():
        if holds_ids(name) and stored.dtype == np.float16:
            largest = max(map(abs, frame.extremes(name)))
            if is_cryptomatte(name) or not largest <= LARGEST_HALF_ID:
                yield Found(f"{name} holds ids in half precision: they are not those that were meant", channel=name)
