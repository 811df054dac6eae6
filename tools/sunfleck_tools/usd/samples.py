"""Time samples of curves. Invariant: at whole frames a sample equals the renderer's value, and linear
segments stay linear.

Time codes are frames. Besides whole frames there is a sample at each key between two of them.
"""

from collections.abc import Callable

import numpy as np

from ..gltf.curves import Curve
from ..gltf.scene import Control, Settings

WHOLE = 1e-3
"""Tolerance of a whole frame in frames, as keys are stored in single precision."""
JUMP = 1e-3
"""Distance in frames before a step at which the old value is repeated."""


class Sampler:
    """Chooses time codes for curves."""

    def __init__(self, settings: Settings, per_frame: int):
        count = (settings.last - settings.first) * per_frame + 1
        frames = settings.first + np.arange(count) / per_frame
        opening, closing = settings.shutter
        ends = [settings.first + opening, settings.last + closing] if closing > opening else []
        self.settings = settings
        self.frames = np.unique(np.concatenate([frames, ends]))

    def codes(self, *curves: Curve | None) -> np.ndarray:
        """Codes for values that depend on these curves; one without curves."""
        moving = [curve for curve in curves if curve is not None and len(curve.times_s) > 1]
        if not moving:
            return self.frames[:1]
        found = [self.frames]
        for curve in moving:
            keys = curve.times_s.astype(np.float64) * float(self.settings.fps)
            keys = np.where(np.abs(keys - np.round(keys)) < WHOLE, np.round(keys), keys)
            found.append(keys)
            if curve.interpolation == "STEP":
                found.append(keys - JUMP)
        codes = np.unique(np.round(np.concatenate(found), 6))
        return codes[(codes >= self.frames[0]) & (codes <= self.frames[-1])]

    def seconds(self, codes: np.ndarray) -> np.ndarray:
        """Times of codes."""
        return self.settings.seconds(codes)

    def rows(
        self, curve: Curve | None, at: Callable[[np.ndarray], np.ndarray]
    ) -> tuple[np.ndarray, np.ndarray]:
        """Codes of a curve and its rows, without samples inside runs of equal ones."""
        codes = self.codes(curve)
        return thinned(codes, at(self.seconds(codes)))

    def numbers(self, control: Control | None, still: float) -> tuple[np.ndarray, np.ndarray]:
        """The same for a number that may be animated."""
        if control is None:
            return self.frames[:1], np.array([still])
        codes, rows = self.rows(control.curve, lambda times_s: control.at(times_s)[:, :1])
        return codes, rows[:, 0]


def thinned(codes: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Samples without those inside runs of equal ones."""
    if len(codes) < 2:
        return codes, rows
    flat = rows.reshape(len(rows), -1)
    same = (flat[1:] == flat[:-1]).all(axis=1)
    if same.all():
        return codes[:1], rows[:1]
    keep = np.ones(len(codes), bool)
    # Equal to both neighbours.
    keep[1:-1] = ~(same[:-1] & same[1:])
    return codes[keep], rows[keep]
