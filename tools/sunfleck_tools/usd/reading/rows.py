"""Equal rows of numbers. Invariant: rows are equal if all their numbers are."""

import numpy as np


def different_rows(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First index of each unique row, and the unique row of each row."""
    bits = np.ascontiguousarray(rows + 0.0).view(np.uint64)
    mixed = np.zeros(len(rows), np.uint64)
    for column in bits.T:
        # Multiplicative hash by the golden ratio, with the high bits folded down (Knuth 6.4).
        mixed = (mixed ^ column) * np.uint64(0x9E3779B97F4A7C15)
        mixed ^= mixed >> np.uint64(29)
    _, first, number = np.unique(mixed, return_index=True, return_inverse=True)
    if (rows[first[number]] == rows).all():
        return first, number
    _, first, number = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    return first, number.ravel()


def different_numbers(numbers: np.ndarray, most: int) -> tuple[np.ndarray, np.ndarray]:
    """The same for integers from 0 up to `most`, without sorting."""
    first = np.full(most, -1, np.int64)
    # Of several assignments the last one stays.
    first[numbers[::-1]] = np.arange(len(numbers))[::-1]
    is_there = first >= 0
    return first[is_there], (np.cumsum(is_there) - 1)[numbers]
