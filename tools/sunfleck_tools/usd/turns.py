"""Rotations as orientations that USD interpolates well.

Quaternions are close if their dot product is above 1 - 1e-5, half a degree of rotation. Between them
`GfSlerp` interpolates along the chord. `GfRotation` takes twice the arc cosine of w without normalization.
Near the identity, where the arc cosine is steep, the error is up to 1e-3. So an animation that passes
there is written as two rotations: one that is half a turn away, and a constant half turn. Invariant: their
product is the given rotation.
"""

import numpy as np

CHORD_BELOW = 1e-5
GOOD_ENOUGH = 2e-6
"""Maximum error, radians."""
HALF_TURNS = np.eye(4)[:3]
"""Half turns about x, y and z, as x, y, z, w."""


def steadied(turns: np.ndarray) -> tuple[np.ndarray, np.ndarray | None]:
    """Rows of x, y, z, w to combine with a constant half turn; None if that is not needed."""
    if _error(turns) <= GOOD_ENOUGH:
        return turns, None
    # turn = other * half, and the inverse of a half turn is its negative.
    others = [product(turns, -half) for half in HALF_TURNS]
    best = int(np.argmin([_error(other) for other in others]))
    return others[best], HALF_TURNS[best]


def _error(turns: np.ndarray) -> float:
    """Largest distance of a chord from the arc, in radians, through the angle of its w."""
    cosines = np.abs(np.sum(turns[1:] * turns[:-1], axis=1))
    chords = np.nonzero((1 - cosines < CHORD_BELOW) & (cosines < 1))[0]
    if len(chords) == 0:
        return 0.0
    start, end = turns[chords], turns[chords + 1]
    middle = 0.5 * (start + np.where(np.sum(start * end, axis=1, keepdims=True) < 0, -end, end))
    length = np.linalg.norm(middle, axis=1)
    angle = 2 * np.arccos(np.clip(middle[:, 3], -1, 1))
    return float(np.abs(angle - 2 * np.arccos(np.clip(middle[:, 3] / length, -1, 1))).max())


def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Rotations `a` after the rotation `b`."""
    x, y, z, w = np.moveaxis(a, -1, 0)
    i, j, k, r = b
    return np.stack(
        [
            w * i + x * r + y * k - z * j,
            w * j - x * k + y * r + z * i,
            w * k + x * j - y * i + z * r,
            w * r - x * i - y * j - z * k,
        ],
        axis=-1,
    )
