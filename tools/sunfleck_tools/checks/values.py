"""Checks of single values, with the place of the first bad one."""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np

from ..findings import Found, Scope, Severity, check
from ..frame import Frame

LARGEST_HALF = 65504.0
HALF_ONE_BITS, HALF_MAX_BITS, HALF_MINUS_ZERO_BITS = 0x3C00, 0x7BFF, 0x8000
SIGNED = re.compile(r"(^|\.)(normal|position|motion|vector|velocity|uv)\.", re.IGNORECASE)
"""Layers whose values may be negative."""
ALPHA_ROUNDING = 2.0**-10
"""One step of half precision above 1: averages of ones may round to it."""


def first_bad(frame: Frame, name: str, bad: np.ndarray, what: str) -> Iterator[Found]:
    """One finding for a channel: how many values are bad, where the first is, and what it is."""
    count = int(np.count_nonzero(bad))
    if count:
        at = int(np.argmax(bad))
        x, y = frame.place(at)
        value = float(frame.channels[name].flat[at])
        values = "1 value is" if count == 1 else f"{count} values are"
        yield Found(f"{name}: {values} {what}, the first at ({x}, {y}): {value:g}", channel=name, pixel=(x, y))


def suspects(frame: Frame) -> Iterator[tuple[str, np.ndarray]]:
    """Channels that hold something not finite."""
    for name, stored in frame.channels.items():
        if (bits := frame.half_bits(name)) is not None:
            suspect = bits[0] > HALF_MAX_BITS
        else:
            # The sum is not finite if a value is not, and sums are quick.
            with np.errstate(all="ignore"):
                suspect = stored.dtype.kind == "f" and not np.isfinite(stored.sum(dtype=np.float64))
        if suspect:
            yield name, frame.float(name)


@check("nan", Severity.ERROR, Scope.FRAME, "a value is not a number", rerender=True)
def nan(frame: Frame) -> Iterator[Found]:
    """Bad mathematics; spreads with every filter."""
    for name, values in suspects(frame):
        yield from first_bad(frame, name, np.isnan(values), "NaN")


@check("infinity", Severity.ERROR, Scope.FRAME, "a value is infinite", rerender=True)
def infinity(frame: Frame) -> Iterator[Found]:
    """Also what overflows half precision in programs that do not clamp."""
    for name, values in suspects(frame):
        yield from first_bad(frame, name, np.isinf(values), "infinite")


@check("half-overflow", Severity.WARNING, Scope.FRAME, "a value of half precision is the largest that there is")
def half_overflow(frame: Frame) -> Iterator[Found]:
    """The renderer clamps there: the true value was larger."""
    for name, stored in frame.channels.items():
        if (bits := frame.half_bits(name)) is not None and bits[0] >= HALF_MAX_BITS:
            at_limit = stored.view(np.uint16) & 0x7FFF == HALF_MAX_BITS
            yield from first_bad(frame, name, at_limit, f"at the limit of half precision, {LARGEST_HALF:g}")


@check("negative", Severity.ERROR, Scope.FRAME, "light, transmittance or albedo is negative")
def negative(frame: Frame) -> Iterator[Found]:
    """Filters with negative lobes, and subtraction in the wrong order."""
    for name, stored in frame.channels.items():
        if name == "A" or stored.dtype.kind != "f" or SIGNED.search(name):
            continue
        if (bits := frame.half_bits(name)) is None or bits[1] > HALF_MINUS_ZERO_BITS:
            with np.errstate(invalid="ignore"):
                yield from first_bad(frame, name, stored < 0, "negative")


@check("alpha-range", Severity.ERROR, Scope.FRAME, "alpha is not between 0 and 1")
def alpha_range(frame: Frame) -> Iterator[Found]:
    """Haloes, once composited."""
    if "A" in frame.channels and ((bits := frame.half_bits("A")) is None or bits[1] > HALF_ONE_BITS):
        alpha = frame.float("A")
        with np.errstate(invalid="ignore"):
            yield from first_bad(frame, "A", (alpha < 0) | (alpha > 1 + ALPHA_ROUNDING), "not between 0 and 1")
