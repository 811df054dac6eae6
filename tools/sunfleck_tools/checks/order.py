"""Swapped frames whose files do not store their numbers, found by the motion between pictures.

In three ordered frames, the outer two differ more than either does from the middle one; where motion
reverses, they differ less. Two frames count as swapped if exchanging them removes all reversals.
Invariant: unordered motion (noise, shaking, blinking) gives no finding.
"""

from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from ..findings import Found, Severity, check
from ..frame import Frame
from ..summary import FrameSummary, Rendered
from .constancy import number_said

CELLS_ACROSS = 24
"""Cells across a signature: coarse enough that a motion by a few pixels changes it gradually."""
BACKWARDS = 0.75
"""Maximum distance of the outer two of three frames, relative to the middle one's larger distance, in a
reversal. It is 2 for uniform motion, 1 for noise, and 0 for an object that appears and vanishes."""
ONWARDS = 1.2
"""Minimum distance in ordered motion: 1.4 for a moving hard edge."""
REACH = 3
"""Frames to either side that have to be in order after the exchange."""
CALM_REACH = 12
"""Frames to either side without any other reversal."""
LEAST_TRIPLES = 4
MOST_ROUGH = 40
"""Maximum number of reversals in a sequence with an order."""


def signature(frame: Frame, luminance: np.ndarray) -> np.ndarray:
    """Small picture of the luminance: square roots of the means of cells, so that highlights do not
    dominate."""
    luminance = frame.on_canvas(luminance)
    step = -(-luminance.shape[1] // CELLS_ACROSS)
    rows, columns = (np.arange(0, extent, step) for extent in luminance.shape)
    sums = np.add.reduceat(np.add.reduceat(luminance, rows, axis=0), columns, axis=1)
    return np.sqrt(np.maximum(sums / step**2, 0)).astype(np.float32)


@check("order", Severity.ERROR, "two frames are in order only if they change places")
def order(rendered: Rendered) -> Iterator[Found]:
    """Files that store their own numbers are checked by `image-counter`."""
    for frames in _runs(rendered.decoded):
        for i, j in _swapped(frames):
            for one, other in ((i, j), (j, i)):
                yield frames[one].found(
                    f"it belongs where frame {frames[other].number} is, and that one here: they seem swapped"
                )


def _runs(frames: Sequence[FrameSummary]) -> Iterator[list[FrameSummary]]:
    """Frames with consecutive numbers and signatures of one size."""
    run: list[FrameSummary] = []
    for frame in frames:
        fits = frame.signature is not None and number_said(frame) is None
        if run and not (fits and frame.number == run[-1].number + 1 and _size(frame) == _size(run[-1])):
            yield run
            run = []
        if fits:
            run.append(frame)
    yield run


def _size(frame: FrameSummary) -> tuple[int, ...] | None:
    return None if frame.signature is None else frame.signature.shape


def _swapped(frames: list[FrameSummary]) -> Iterator[tuple[int, int]]:
    """Indices of swapped pairs."""
    distances: dict[tuple[int, int], float] = {}
    signatures = [frame.signature for frame in frames if frame.signature is not None]

    def distance(i: int, j: int) -> float:
        if (i, j) not in distances:
            distances[i, j] = float(np.sqrt(np.mean(np.square(signatures[i] - signatures[j]))))
        return distances[i, j]

    def progress(i: int, j: int, k: int) -> float:
        step = max(distance(i, j), distance(j, k))
        return distance(i, k) / step if step > 0 else 1.0

    count = len(frames)
    rough = [i for i in range(1, count - 1) if progress(i - 1, i, i + 1) < BACKWARDS]
    if not rough or len(rough) > MOST_ROUGH:
        return
    for i, j in combinations(sorted({0, count - 1, *rough}), 2):
        near = {k for end in (i, j) for k in range(end - REACH, end + REACH + 1) if 1 <= k < count - 1}
        place = {i: j, j: i}
        triples = [tuple(place.get(index, index) for index in (k - 1, k, k + 1)) for k in near]
        # Reversals here and nearby have to vanish; if more remain, the motion itself is irregular.
        around = {k for k in rough if min(abs(k - i), abs(k - j)) <= CALM_REACH}
        explained = bool(around) and around <= {k + side for k in (i, j) for side in (-1, 0, 1)}
        if (
            explained
            and len(triples) >= LEAST_TRIPLES
            and all(progress(*triple) >= ONWARDS for triple in triples)
        ):
            yield i, j
