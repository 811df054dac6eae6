"""Moving points as morph targets with weights.

In go positions at each code, out come few targets, or one a code where few do not suffice. Invariant: the
error of every point is within the tolerance at every code.
"""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...errors import SceneError

MOST_VALUES = 2**26
"""Maximum coordinates of a mesh over all codes: 256 MiB in single precision, and as much again as targets."""
COLUMNS_A_TIME = 2**14
"""Columns in a block, in double precision."""
SMALLEST = 1e-6
"""Tolerance of points, relative to the size of a mesh."""
SAMPLED = 512
"""Coordinates in the sample that determines the number of components."""
MOST_TARGETS = 128
LEAST_NORMALS = 32
"""Minimum number of codes at which normals are read, if there are as many."""
FEW = 16
"""Number of rows up to which each row is a target."""


@dataclass
class Bend:
    """Moving points: displacements and their weights, a row a code."""

    codes: np.ndarray
    targets: list[np.ndarray]
    weights: np.ndarray


def read_bend(
    place: object, points_at: Callable[[float], np.ndarray], codes: np.ndarray, rest: np.ndarray
) -> Bend | None:
    """Motion of points; None if they are constant. Raises `SceneError`, with the `place`, if there are too
    many."""
    if len(codes) * rest.size > MOST_VALUES:
        raise SceneError(f"{place}: {len(rest)} points that change over {len(codes)} frames are too many")
    moved = np.empty((len(codes), rest.size), np.float32)
    for row, code in enumerate(codes.tolist()):
        points = points_at(code)
        if len(points) != len(rest):
            raise SceneError(
                f"{place}: has {len(rest)} points at first and {len(points)} at time code {code:g}"
            )
        moved[row] = (points - rest).ravel()
    bar = SMALLEST * max(float(np.ptp(rest, axis=0).max(initial=0.0)), 1e-9)
    if not len(rest) or np.abs(moved).max() <= bar:
        return None
    different, number = _different(moved)
    targets, weights = _components(different, bar) or _one_each(different)
    return Bend(codes, [target.reshape(-1, 3) for target in targets], weights[number])


def _different(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unique rows and the index of each code's row: equal codes add nothing."""
    known: dict[bytes, int] = {}
    first: list[int] = []
    number = np.empty(len(rows), np.int64)
    for index, row in enumerate(rows):
        number[index] = known.setdefault(hashlib.blake2b(row).digest(), len(first))
        if number[index] == len(first):
            first.append(index)
    return (rows if len(first) == len(rows) else rows[first]), number


def _components(moved: np.ndarray, bar: float) -> tuple[np.ndarray, np.ndarray] | None:
    """Targets and weights: principal components of the motion (Alexa and Mueller 2000), if they are at most
    half as many as its rows.

    The weights come from a sample of the columns (Frieze, Kannan and Vempala 2004), and are then checked
    against every column. So the cost of the decomposition does not grow with the points, and a motion with
    many components is recognized before all columns are read.
    """
    chosen = np.random.default_rng(0).permutation(moved.shape[1])[:SAMPLED]
    sample = moved[:, np.sort(chosen)].astype(float)
    most = min(len(moved) // 2 if len(moved) > FEW else len(moved), MOST_TARGETS)
    mixes = np.linalg.svd(sample, full_matrices=False)[0]
    rank = _rank(sample, mixes[:, :most], bar)
    while rank is not None:
        targets = _targets(moved, mixes[:, :rank], bar)
        if targets is not None:
            # Scales weights to about 1.
            largest = np.abs(mixes[:, :rank]).max(axis=0)
            return targets * largest[:, None], mixes[:, :rank] / largest
        rank = rank + max(rank // 4, 1)
        rank = rank if rank <= min(most, mixes.shape[1]) else None
    return None


def _rank(sample: np.ndarray, mixes: np.ndarray, bar: float) -> int | None:
    """Number of components that reproduce the sample within the tolerance; None if all of them do not."""
    left = sample.copy()
    for rank in range(1, mixes.shape[1] + 1):
        mix = mixes[:, rank - 1]
        left -= np.outer(mix, mix @ sample)
        if np.abs(left).max() <= bar:
            return rank
    return None


def _targets(moved: np.ndarray, mixes: np.ndarray, bar: float) -> np.ndarray | None:
    """Targets for these weights in each column; None at the first column out of tolerance."""
    found = np.empty((mixes.shape[1], moved.shape[1]), np.float32)
    for start in range(0, moved.shape[1], COLUMNS_A_TIME):
        columns = slice(start, start + COLUMNS_A_TIME)
        part = moved[:, columns].astype(float)
        target = mixes.T @ part
        if np.abs(part - mixes @ target).max() > bar:
            return None
        found[:, columns] = target
    return found


def _one_each(moved: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """One target for each row that is not zero."""
    moves = moved.any(axis=1)
    weights = np.zeros((len(moved), int(moves.sum())))
    weights[moves] = np.eye(int(moves.sum()))
    return moved[moves], weights


def normal_targets(
    normals_at: Callable[[float], np.ndarray | None], bend: Bend, rest: np.ndarray
) -> np.ndarray | None:
    """Displacements of normals (rows at rest) for the points' weights, by least squares.

    None if normals are constant. Normals do not move linearly with points; a renderer normalizes them.
    """
    count = max(2 * len(bend.targets), LEAST_NORMALS)
    count = min(len(bend.codes), count, max(MOST_VALUES // max(rest.size, 1), 2))
    chosen = np.unique(np.linspace(0, len(bend.codes) - 1, count).round().astype(int))
    turned = np.zeros((len(chosen), rest.size), np.float32)
    for row, code in enumerate(bend.codes[chosen].tolist()):
        normals = normals_at(code)
        if normals is not None and normals.shape == rest.shape:
            turned[row] = (normals - rest).ravel()
    if np.abs(turned).max() < SMALLEST:
        return None
    return (np.linalg.pinv(bend.weights[chosen]) @ turned).reshape(len(bend.targets), *rest.shape)
