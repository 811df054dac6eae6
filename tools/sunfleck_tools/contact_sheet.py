"""Sequences as one picture: frames side by side, each with its number below, each sequence from a new row on.

Invariant: a frame that is missing or cannot be shown has its place all the same, hatched.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from math import ceil, sqrt

import numpy as np

from .digits import HEIGHT, drawn
from .errors import ToolError
from .pictures import Shown, fitted

GAP, BACKGROUND, INK, FAULTY_INK = 4, 24, (200, 200, 200), (255, 90, 90)
LARGEST_SHEET = 1 << 28
"""Pixels."""


@dataclass
class Sheet:
    """The picture, and the frames that it could not show with the reasons."""

    pixels: np.ndarray
    faults: list[tuple[int, str]]


def contact_sheet(pictures: Iterable[Shown], counts: Sequence[int], columns: int | None = None) -> Sheet:
    """Lays pictures out, as many as `counts` says of each sequence, as nearly square as screens are wide, or
    in so many columns."""
    count = sum(counts)
    cells = iter(pictures)
    ahead: list[Shown] = []
    # The first frame that can be shown says how large the cells are.
    for picture in cells:
        ahead.append(picture)
        if picture.pixels is not None:
            break
    height, width = next((p.pixels.shape[:2] for p in reversed(ahead) if p.pixels is not None), (54, 96))
    step_y, step_x = height + HEIGHT + 3 * GAP, width + GAP
    columns = min(max(counts), columns or max(1, round(sqrt(count * 16 / 9 * step_y / step_x))))
    rows = sum(ceil(one / columns) for one in counts)
    if rows * step_y * columns * step_x > LARGEST_SHEET:
        raise ToolError(
            f"{count} frames of {width}x{height} pixels are no sheet: choose a smaller --width, or fewer "
            "--frames"
        )
    sheet = np.full((GAP + rows * step_y, GAP + columns * step_x, 3), BACKGROUND, np.uint8)
    faults, places = [], _places(counts, columns)

    def place(picture: Shown) -> None:
        row, column = next(places)
        y, x = GAP + row * step_y, GAP + column * step_x
        sheet[y : y + height, x : x + width] = fitted(picture.pixels, height, width)
        label = drawn(picture.number)[:, :width]
        below = sheet[y + height + GAP : y + height + GAP + HEIGHT, x : x + label.shape[1]]
        below[label] = INK if picture.fault is None else FAULTY_INK
        if picture.fault is not None:
            faults.append((picture.number, picture.fault))

    for picture in chain(ahead, cells):
        place(picture)
    return Sheet(sheet, faults)


def _places(counts: Sequence[int], columns: int) -> Iterator[tuple[int, int]]:
    """Row and column of each picture."""
    first = 0
    for count in counts:
        yield from ((first + index // columns, index % columns) for index in range(count))
        first += ceil(count / columns)
