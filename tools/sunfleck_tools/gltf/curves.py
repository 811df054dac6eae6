"""Interpolation of keys (specification, 3.11 and appendix C)."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Curve:
    """Keys of a value. Times strictly increase, in single precision as in files; in a cubic curve each key
    has three rows."""

    times_s: np.ndarray
    values: np.ndarray
    interpolation: str
    turns: bool

    def at(self, times_s: np.ndarray) -> np.ndarray:
        """Values at times, a row each; constant outside the keys."""
        # A key in single precision may lie after the exact time of its frame.
        times = np.asarray(times_s, np.float32).astype(np.float64)
        keys = self.times_s.astype(np.float64)
        before = np.clip(np.searchsorted(keys, times, side="right") - 1, 0, len(keys) - 1)
        after = np.minimum(before + 1, len(keys) - 1)
        span = keys[after] - keys[before]
        share = np.clip((times - keys[before]) / np.where(span > 0, span, 1.0), 0.0, 1.0)[:, None]
        values = self.values.astype(np.float64)
        if self.interpolation == "STEP":
            found = values[before]
        elif self.interpolation == "CUBICSPLINE":
            found = _hermite(values, before, after, share, span[:, None])
        elif self.turns:
            return slerp(unit(values[before]), unit(values[after]), share)
        else:
            found = values[before] + share * (values[after] - values[before])
        return unit(found) if self.turns else found


def _hermite(values, before, after, s, span):
    start, leave = values[3 * before + 1], values[3 * before + 2] * span
    end, arrive = values[3 * after + 1], values[3 * after] * span
    return (
        (2 * s**3 - 3 * s**2 + 1) * start
        + (s**3 - 2 * s**2 + s) * leave
        + (-2 * s**3 + 3 * s**2) * end
        + (s**3 - s**2) * arrive
    )


def unit(quaternions: np.ndarray) -> np.ndarray:
    """Quaternions at unit length; the identity for zeros."""
    lengths = np.linalg.norm(quaternions, axis=-1, keepdims=True)
    identity = np.array([0.0, 0.0, 0.0, 1.0])
    return np.where(lengths > 0, quaternions / np.where(lengths > 0, lengths, 1.0), identity)


def slerp(start: np.ndarray, end: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Along the shorter arc (Shoemake 1985)."""
    cosine = np.sum(start * end, axis=-1, keepdims=True)
    end = np.where(cosine < 0, -end, end)
    cosine = np.minimum(np.abs(cosine), 1.0)
    angle = np.arccos(cosine)
    sine = np.sin(angle)
    is_short = sine < 1e-6
    divisor = np.where(is_short, 1.0, sine)
    a = np.where(is_short, 1.0 - share, np.sin((1.0 - share) * angle) / divisor)
    b = np.where(is_short, share, np.sin(share * angle) / divisor)
    return unit(a * start + b * end)
