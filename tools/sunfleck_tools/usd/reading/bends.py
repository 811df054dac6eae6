"""Points that move over time as morph targets and their weights.

In: where points are at each code. Out: as few targets as put every point within a bar of where it should be; one target a code
where few do not do. Invariant: no point is further off than the bar, at any code.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...errors import SceneError

MOST_VALUES = 2**26
"""Coordinates of a mesh over all codes: 256 MiB in single precision, and as much again as targets."""
ROWS_A_TIME = 16
"""In double precision."""
SMALLEST = 1e-6
"""Of the size of a mesh: how far points may lie from where they should."""
TRIED_RANKS = (8, 32, 128)


@dataclass
class Bend:
    """Points that move: what is added to them, times weights, a row a code."""

    codes: np.ndarray
    targets: list[np.ndarray]
    weights: np.ndarray


def read_bend(place: object, points_at: Callable[[float], np.ndarray], codes: np.ndarray, rest: np.ndarray) -> Bend | None:
    """The movement of points; None if they stay. Raises `SceneError`, with the `place`, if they are too many."""
    if len(codes) * rest.size > MOST_VALUES:
        raise SceneError(f"{place}: {len(rest)} points that change over {len(codes)} frames are too many")
    moved = np.empty((len(codes), rest.size), np.float32)
    for row, code in enumerate(codes.tolist()):
        points = points_at(code)
        if len(points) != len(rest):
            raise SceneError(f"{place}: has {len(rest)} points at first and {len(points)} at time code {code:g}")
        moved[row] = (points - rest).ravel()
    bar = SMALLEST * max(float(np.ptp(rest, axis=0).max(initial=0.0)), 1e-9)
    if not len(rest) or np.abs(moved).max() <= bar:
        return None
    different, number = _different(moved)
    targets, weights = _components(different, bar) or _one_each(different)
    return Bend(codes, [target.reshape(-1, 3) for target in targets], weights[number])


def _different(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rows that differ, and which of those each one is: codes at which points are where they are at another add nothing."""
    known: dict[bytes, int] = {}
    first, number = [], np.empty(len(rows), np.int64)
    for index, row in enumerate(rows):
        number[index] = known.setdefault(hashlib.blake2b(row).digest(), len(first))
        if number[index] == len(first):
            first.append(index)
    return (rows if len(first) == len(rows) else rows[first]), number


def _components(moved: np.ndarray, bar: float) -> tuple[np.ndarray, np.ndarray] | None:
    """Principal components of movement (Alexa and Mueller 2000), if those are at most half as many as its rows.

    The space of the rows by random mixtures of them (Halko, Martinsson and Tropp 2011, algorithm 4.1): where few components do, the
    cost is that of reading the rows a few times, and where many are needed, that is soon known.
    """
    mixer = np.random.default_rng(0)
    for rank in TRIED_RANKS:
        if 2 * rank > max(len(moved), 2 * TRIED_RANKS[0]):
            return None
        mixtures = mixer.standard_normal((min(rank, len(moved)), len(moved)), np.float32) @ moved
        basis = np.linalg.qr(mixtures.T.astype(float))[0].T
        weights = np.concatenate([moved[start : start + ROWS_A_TIME] @ basis.T for start in range(0, len(moved), ROWS_A_TIME)])
        if _is_within(bar, moved, weights, basis):
            return _fewest(moved, *_turned(weights, basis), bar)
    return None


def _is_within(bar: float, moved: np.ndarray, weights: np.ndarray, basis: np.ndarray) -> bool:
    """True if a product is the rows, but for the bar."""
    blocks = [slice(start, start + ROWS_A_TIME) for start in range(0, len(moved), ROWS_A_TIME)]
    return all(np.abs(moved[block] - weights[block] @ basis).max() <= bar for block in blocks)


def _turned(weights: np.ndarray, basis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same product, by components in the order of their size."""
    left, sizes, right = np.linalg.svd(weights, full_matrices=False)
    return left * sizes, right @ basis


def _fewest(moved: np.ndarray, weights: np.ndarray, basis: np.ndarray, bar: float) -> tuple[np.ndarray, np.ndarray]:
    """The first components, as many as the bar asks for; weights about 1."""
    too_few, enough = 0, len(basis)
    while enough - too_few > 1:
        middle = (too_few + enough) // 2
        if _is_within(bar, moved, weights[:, :middle], basis[:middle]):
            enough = middle
        else:
            too_few = middle
    largest = np.abs(weights[:, :enough]).max(axis=0)
    return basis[:enough] * largest[:, None], weights[:, :enough] / largest


def _one_each(moved: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A target for each row that is not zero."""
    moves = moved.any(axis=1)
    weights = np.zeros((len(moved), int(moves.sum())))
    weights[moves] = np.eye(int(moves.sum()))
    return moved[moves], weights
