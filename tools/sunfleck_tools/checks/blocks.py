"""Blocks of a picture that were never rendered: rectangles of zeros where the picture is lit.

Renderers work in buckets, and files in blocks of rows; a lost one is all zeros, with straight edges. A
black object has no straight edges, or also shows in the frames before and after. Invariant: no more than
`MOST` candidates a frame.
"""

from collections.abc import Iterator

import numpy as np

from ..exr.lossy import rounding
from ..findings import Found, Severity, check
from ..frame import Frame, wide
from ..summary import Rendered

SMALLEST = 8
"""Minimum columns and rows, those of the smallest buckets."""
LIT_SHARE = 0.9
"""Minimum lit share of a block's surroundings, and of its place in neighbouring frames."""
GRID = 8
"""Without neighbouring frames, a block's size has to be a multiple of this, as in renderers and files."""
MOST = 64

Block = tuple[int, int, int, int]
"""First and last column and row, both inclusive."""


def candidates(frame: Frame) -> list[Block]:
    """Rectangles of zeros with straight edges and light around them, in pixels of the full picture."""
    colors = [frame.channels[name] for name in frame.picture]
    if not colors or any(frame.extremes(name)[0] > 0 for name in frame.picture):
        return []
    dark = np.logical_and.reduce([color == 0 for color in colors])
    if dark.all():
        return []
    left, top = frame.header.data_window[:2]
    # Lossy compression rounds nearly black values to zero, block by block.
    if (most := rounding(frame.header)) > 0:
        dim = np.logical_and.reduce([np.abs(wide(color)) <= most for color in colors])
    else:
        dim = dark
    found = [block for block in _rectangles(dark) if _stands_out(dim, block)]
    found.sort(key=lambda b: (b[0] - b[2]) * (b[3] - b[1] + 1))
    return [(x0 + left, y0 + top, x1 + left, y1 + top) for x0, y0, x1, y1 in found[:MOST]]


def _rectangles(dark: np.ndarray) -> Iterator[Block]:
    """Runs of dark pixels that begin and end in the same columns over many rows."""
    height, width = dark.shape
    # Only columns that are dark for long enough can contain a rectangle.
    edges = np.diff(np.pad(dark, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    open_runs: dict[tuple[int, int], int] = {}
    for y in range(height + 1):
        runs = set()
        if y < height and dark[y].any():
            runs = set(
                zip(np.flatnonzero(edges[y] == 1).tolist(), (np.flatnonzero(edges[y] == -1) - 1).tolist())
            )
            runs = {run for run in runs if run[1] - run[0] + 1 >= SMALLEST}
        for run in [run for run in open_runs if run not in runs]:
            first = open_runs.pop(run)
            if y - first >= SMALLEST:
                yield run[0], first, run[1], y - 1
        for run in runs:
            open_runs.setdefault(run, y)


def _stands_out(dark: np.ndarray, block: Block) -> bool:
    """True if the rows above and below, where they exist, are lit; to the sides every rectangle ends
    anyway."""
    x0, y0, x1, y1 = block
    rows = [row for row in (y0 - 1, y1 + 1) if 0 <= row < dark.shape[0]]
    lit = [1 - dark[row, x0 : x1 + 1].mean() for row in rows]
    return bool(lit) and min(lit) >= LIT_SHARE


def lit_in(luminance: np.ndarray, found: list[Block], corner: tuple[int, int]) -> list[Block]:
    """Blocks in which a neighbouring frame's picture has light, in pixels of the full picture."""
    lit = []
    for block in found:
        x0, y0, x1, y1 = (max(0, value - corner[index % 2]) for index, value in enumerate(block))
        there = luminance[y0 : y1 + 1, x0 : x1 + 1]
        if there.size and np.count_nonzero(there) >= LIT_SHARE * there.size:
            lit.append(block)
    return lit


def unlikely_alone(found: list[Block], window: Block) -> list[Block]:
    """Blocks with the size of a bucket that are not bars along the edges of the picture, whose data window
    is given."""

    def is_bar(block: Block, axis: int) -> bool:
        spans = block[axis] == window[axis] and block[axis + 2] == window[axis + 2]
        return spans and (block[1 - axis] == window[1 - axis] or block[3 - axis] == window[3 - axis])

    def is_bucket(block: Block) -> bool:
        return all((block[axis + 2] - block[axis] + 1) % GRID == 0 for axis in (0, 1))

    return [block for block in found if is_bucket(block) and not is_bar(block, 0) and not is_bar(block, 1)]


@check("black-block", Severity.ERROR, "a rectangle of the picture is black to its last value", rerender=True)
def black_block(rendered: Rendered) -> Iterator[Found]:
    """One finding a frame, for its largest block."""
    for frame in rendered.decoded:
        if frame.black_blocks:
            x0, y0, x1, y1 = frame.black_blocks[0]
            more = f", and {len(frame.black_blocks) - 1} more" if len(frame.black_blocks) > 1 else ""
            message = f"{x1 - x0 + 1} x {y1 - y0 + 1} pixels from ({x0}, {y0}) on are black{more}: a block that was not rendered"
            yield frame.found(message, pixel=(x0, y0))
