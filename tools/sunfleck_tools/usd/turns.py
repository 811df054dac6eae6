"""Turns as orientations that USD interpolates well.

Two quaternions are near where their cosine is above 1 - 1e-5, which is half a degree of turn. Between such
`GfSlerp` goes along the chord. `GfRotation` takes twice the arc cosine of w without bringing the quaternion
to unit length. Near no turn at all, where the arc cosine is steep, that is off by up to 1e-3. So an animation
that passes there is written as two turns: another one, half a turn away, and a half turn that does not
change. Invariant: both together are the turns that went in.
"""

import numpy as np

CHORD_BELOW = 1e-5
GOOD_ENOUGH = 2e-6
"""Radians."""
HALF_TURNS = np.eye(4)[:3]
"""About x, y and z, as x, y, z, w."""


def steadied(turns: np.ndarray) -> tuple[np.ndarray, np.ndarray | None]:
    """Rows of x, y, z, w that go before a still turn; None if there is no need of one."""
    if _error(turns) <= GOOD_ENOUGH:
        return turns, None
    # turn = other * half, and the inverse of a half turn is its negative.
    others = [product(turns, -half) for half in HALF_TURNS]
    best = int(np.argmin([_error(other) for other in others]))
    return others[best], HALF_TURNS[best]


def _error(turns: np.ndarray) -> float:
    """How far from the arc the worst chord is, in radians, once its w became an angle."""
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
    """Rows of turns `a` after the turn `b`."""
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
