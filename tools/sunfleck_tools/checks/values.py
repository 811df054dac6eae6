"""Checks of single values; each finding has the place of the first bad one."""

from collections.abc import Iterator

import numpy as np

from ..exr.lossy import rounding
from ..findings import Found, Severity, check
from ..frame import Frame
from ..layers import Kind, kind, split

LARGEST_HALF = 65504.0
NEGATIVE_ROUNDING = 2.0**-16
"""Rounding below 0 of other renderers' filters and denoisers."""
ALPHA_ROUNDING = 2.0**-10
"""One step of half precision above 1: averages of ones may round to it."""


def first_bad(frame: Frame, name: str, bad: np.ndarray, what: str) -> Iterator[Found]:
    """One finding a channel: the number of bad values, and place and value of the first."""
    count = int(np.count_nonzero(bad))
    if count:
        at = int(np.argmax(bad))
        x, y = frame.place(name, at)
        value = float(frame.channels[name].flat[at])
        values = "1 value is" if count == 1 else f"{count} values are"
        yield Found(
            f"{name}: {values} {what}, the first at ({x}, {y}): {value:g}", channel=name, pixel=(x, y)
        )


def not_finite(frame: Frame) -> Iterator[tuple[str, np.ndarray]]:
    """Channels with values that are not finite, except ids, whose bits may be those of any float."""
    for name in frame.channels:
        if kind(name) is not Kind.ID and not np.isfinite(frame.extremes(name)).all():
            yield name, frame.float(name)


@check("nan", Severity.ERROR, "a value is not a number", rerender=True)
def nan(frame: Frame) -> Iterator[Found]:
    """Invalid arithmetic; filters spread it."""
    for name, values in not_finite(frame):
        yield from first_bad(frame, name, np.isnan(values), "NaN")


@check("infinity", Severity.ERROR, "a value is infinite", rerender=True)
def infinity(frame: Frame) -> Iterator[Found]:
    """Includes overflow of half precision in programs that do not clamp. In other renderers' frames,
    depths and positions of the background may be infinite."""
    for name, values in not_finite(frame):
        if frame.is_own or kind(name) in (Kind.LIGHT, Kind.ALPHA):
            yield from first_bad(frame, name, np.isinf(values), "infinite")


@check("half-overflow", Severity.WARNING, "a value of half precision is the largest that there is")
def half_overflow(frame: Frame) -> Iterator[Found]:
    """The renderer clamps to the largest half: the true value was larger."""
    for name, stored in frame.channels.items():
        # Not `<`: with NaN, the other values have to be checked.
        if (
            stored.dtype == np.float16
            and kind(name) in (Kind.LIGHT, Kind.ALPHA)
            and not max(map(abs, frame.extremes(name))) < LARGEST_HALF
        ):
            said = f"at the limit of half precision, {LARGEST_HALF:g}"
            yield from first_bad(frame, name, np.abs(stored) == LARGEST_HALF, said)


@check("negative", Severity.ERROR, "light, transmittance or albedo is negative")
def negative(frame: Frame) -> Iterator[Found]:
    """Filters with negative lobes, or subtraction in the wrong order. Lossy compression may go slightly
    below 0."""
    for name in frame.channels:
        least = -max(0.0 if frame.is_own else NEGATIVE_ROUNDING, rounding(frame.header_of(name)))
        if kind(name) is Kind.LIGHT and not frame.extremes(name)[0] >= least:
            with np.errstate(invalid="ignore"):
                yield from first_bad(frame, name, frame.float(name) < least, "negative")


@check("alpha-range", Severity.ERROR, "alpha is not between 0 and 1")
def alpha_range(frame: Frame) -> Iterator[Found]:
    """Causes haloes in compositing."""
    layer = split(frame.picture[0])[0] if frame.picture else ""
    for name in frame.channels:
        if kind(name) is not Kind.ALPHA or split(name)[0] != layer:
            continue
        smallest, largest = frame.extremes(name)
        if not (smallest >= 0 and largest <= 1 + ALPHA_ROUNDING):
            alpha = frame.float(name)
            with np.errstate(invalid="ignore"):
                yield from first_bad(
                    frame, name, (alpha < 0) | (alpha > 1 + ALPHA_ROUNDING), "not between 0 and 1"
                )
