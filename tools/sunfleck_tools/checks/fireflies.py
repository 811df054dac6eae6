"""Isolated pixels far brighter than their neighbours in space and time.

A spike of noise is one pixel in one frame; a spark, a gap between leaves or a highlight is wider, or
lasts. Spikes no brighter than well-lit surfaces cannot be told from small leaves, and pass. Invariant: at
most `MOST` candidates a frame, as more are noise, and slow.
"""

from collections.abc import Iterator

import numpy as np

from ..findings import Found, Severity, check
from ..summary import Rendered

REACH = 2
"""The neighbourhood: 5x5 pixels."""
DEVIATIONS = 20.0
"""Standard deviations (by the median absolute deviation of the neighbours) above the neighbours' median."""
ISOLATION = 5.0
"""Minimum brightness relative to the brightest neighbour in space, and to the same place in neighbouring
frames."""
COMPANY = 2.0
"""Minimum brightness relative to the brightest other pixel of the picture: a leaf smaller than a pixel is
a spike too, but not brighter than larger leaves."""
MOST = 200
NORMAL_FROM_MAD = 1.4826

Candidate = tuple[int, int, float, float]
"""Column, row, luminance, median of the neighbours."""


def candidates(luminance: np.ndarray) -> list[Candidate]:
    """Spikes in space, in pixels of the data window."""
    # With so many pixels at least half as bright, the brightest is not isolated; noise everywhere is not a
    # firefly either.
    if np.count_nonzero(luminance > luminance.max() / COMPANY) > MOST:
        return []
    padded = np.pad(luminance, REACH, mode="edge")
    inner = padded[1:-1, 1:-1]
    rows = inner[:, :-2] + inner[:, 1:-1] + inner[:, 2:]
    sums = rows[:-2] + rows[1:-1] + rows[2:]
    # A spike exceeds its neighbours' mean by more than it exceeds the brightest of them.
    rough = luminance * (8.0 + ISOLATION) > ISOLATION * sums
    # The brightest pixel that is no rough spike; exact spikes are tested again below.
    rough &= luminance > COMPANY * float(luminance[~rough].max(initial=0.0))
    ys, xs = np.nonzero(rough)
    if len(ys) > MOST:
        brightest = np.argpartition(luminance[ys, xs], -MOST)[-MOST:]
        ys, xs = ys[brightest], xs[brightest]
    if not len(ys):
        return []
    windows = np.lib.stride_tricks.sliding_window_view(padded, (2 * REACH + 1, 2 * REACH + 1))[ys, xs]
    others = np.delete(windows.reshape(len(ys), -1), (2 * REACH + 1) ** 2 // 2, axis=1)
    middle = np.median(others, axis=1)
    deviation = NORMAL_FROM_MAD * np.median(np.abs(others - middle[:, None]), axis=1)
    value = luminance[ys, xs]
    spikes = (value > middle + DEVIATIONS * deviation) & (value > ISOLATION * others.max(axis=1))
    spikes &= value > COMPANY * value[~spikes].max(initial=0.0)
    return [
        (int(x), int(y), float(v), float(m))
        for x, y, v, m in zip(xs[spikes], ys[spikes], value[spikes], middle[spikes])
    ]


def absent_in(luminance: np.ndarray, found: list[Candidate], corner: tuple[int, int]) -> list[Candidate]:
    """Candidates, in pixels of the full picture, that a neighbouring frame's picture does not show within
    a pixel. The upper left pixel of that picture is `corner`."""
    height, width = luminance.shape
    absent = []
    for candidate in found:
        x, y, value = candidate[0] - corner[0], candidate[1] - corner[1], candidate[2]
        if not (0 <= x < width and 0 <= y < height):
            continue
        near = luminance[max(0, y - 1) : y + 2, max(0, x - 1) : x + 2]
        if value > ISOLATION * float(near.max()):
            absent.append(candidate)
    return absent


@check("firefly", Severity.WARNING, "a single pixel is far brighter than its neighbours in space and time")
def firefly(rendered: Rendered) -> Iterator[Found]:
    """One finding a frame, for its brightest spike."""
    for frame in rendered.decoded:
        if frame.fireflies:
            x, y, value, middle = max(frame.fireflies, key=lambda found: found[2])
            count = len(frame.fireflies)
            pixels = "a pixel" if count == 1 else f"{count} pixels, the brightest"
            message = f"{pixels} at ({x}, {y}) has luminance {value:.4g} among {middle:.4g}"
            yield frame.found(message, pixel=(x, y))
