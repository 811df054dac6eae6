"""Differences of two frames' pictures, as in `sunfleck diff`.

Invariant: both have the same window.
"""

from math import nan

import numpy as np

from .frame import Frame


def relative_mse(output: Frame, reference: Frame) -> float:
    """mean((o - r)^2 / (r^2 + (0.1 mean(r))^2)) over red, green and blue; NaN if any value is not finite."""
    o, r = (colors.astype(np.float64) for colors in _colors(output, reference))
    # Equal infinities are no difference.
    finite = np.isfinite(o) & np.isfinite(r)
    if not finite.any() or np.any(~finite & (o != r)):
        return nan
    o, r = o[finite], r[finite]
    squares = np.square(o - r)
    with np.errstate(invalid="ignore"):
        # Avoids 0 / 0 where both are black.
        relative = np.where(squares > 0, squares / (np.square(r) + (0.1 * r.mean()) ** 2), 0.0)
    return float(relative.mean())


def mean_flip(output: Frame, reference: Frame) -> float:
    """Mean HDR-FLIP (Andersson et al. 2021) over the picture, by the authors' package."""
    import flip_evaluator

    arrays = [np.ascontiguousarray(colors, np.float32) for colors in _colors(reference, output)]
    return float(flip_evaluator.evaluate(*arrays, "HDR")[1])


def _colors(*frames: Frame) -> list[np.ndarray]:
    """Red, green and blue in the last axis; in linear Rec. 709 if the spaces differ."""
    is_one = frames[0].space == frames[1].space
    return [np.stack(frame.group() if is_one else frame.shown(), axis=-1) for frame in frames]
