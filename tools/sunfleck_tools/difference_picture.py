"""Output, reference and what differs, side by side."""

from __future__ import annotations

import numpy as np

from .difference import Overlap
from .display import Display

HEAT = np.array([[0, 0, 0], [70, 10, 110], [200, 40, 70], [250, 150, 40], [255, 255, 220]], np.float32)
"""From no difference to the largest: darker to lighter, so that it can be read without colours."""
GAP = 4


def difference_picture(
    overlap: Overlap, display: Display, white: float | None = None
) -> tuple[np.ndarray, float]:
    """The picture, and the difference of a channel that is white in it; by default the 99.9th percentile."""
    output, reference = overlap.colors()
    with np.errstate(invalid="ignore"):
        apart = np.abs(output - reference).max(axis=-1)
    finite = np.isfinite(apart)
    if white is None:
        known = apart[finite]
        white = float(np.quantile(known, 0.999)) if known.size else 0.0
        # Where less than a thousandth of the pixels differ at all, they are to be seen too.
        white = white or float(known.max(initial=0.0)) or 1.0
    place = np.where(finite, np.clip(np.where(finite, apart, 0) / white, 0, 1), 1) * (len(HEAT) - 1)
    heat = np.stack(
        [np.interp(place, np.arange(len(HEAT)), HEAT[:, channel]) for channel in range(3)], axis=-1
    )
    corner = (overlap.left, overlap.top)
    space = np.zeros((apart.shape[0], GAP, 3), np.uint8)
    seen_output, seen_reference = overlap.shown()
    panels = [
        display.bytes(seen_output, corner),
        space,
        display.bytes(seen_reference, corner),
        space,
        np.rint(heat).astype(np.uint8),
    ]
    return np.concatenate(panels, axis=1), white
