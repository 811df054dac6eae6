"""Rows of numbers that are the same. Invariant: rows count as the same if all their numbers are."""

import numpy as np


def different_rows(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The first place of each different row, and for each row which of those it is."""
    bits = np.ascontiguousarray(rows + 0.0).view(np.uint64)
    mixed = np.zeros(len(rows), np.uint64)
    for column in bits.T:
        # Multiplied by the fraction of the golden ratio; to fold the high bits down makes
        # them count (Knuth 6.4).
        mixed = (mixed ^ column) * np.uint64(0x9E3779B97F4A7C15)
        mixed ^= mixed >> np.uint64(29)
    _, first, number = np.unique(mixed, return_index=True, return_inverse=True)
    if (rows[first[number]] == rows).all():
        return first, number
    _, first, number = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    return first, number.ravel()


def different_numbers(numbers: np.ndarray, most: int) -> tuple[np.ndarray, np.ndarray]:
    """The same of whole numbers from 0 up to `most`, without a sort."""
    first = np.full(most, -1, np.int64)
    # Of several places the last one that is written stays.
    first[numbers[::-1]] = np.arange(len(numbers))[::-1]
    is_there = first >= 0
    return first[is_there], (np.cumsum(is_there) - 1)[numbers]
