"""Thinning of keys that interpolation between others gives.

In go values at times, out come masks of the kept keys. Invariant: at every given time, the line (or the
arc of constant speed) through the kept keys is within the tolerance. All tracks advance together, a key at
a time. The slopes from the last kept key that pass near all later keys form an interval. A key outside it
ends the run before it.
"""

from collections.abc import Callable
from typing import Any

import numpy
from numpy.typing import NDArray

Array = NDArray[Any]
Between = Callable[[Array, Array], Array]
# Maximum arc between keys, below half a turn.
LARGEST_ARC = 0.95 * numpy.pi


def straight(times: Array, values: Array, lengths: Array, tolerance: Array | float) -> Array:
    """Mask of kept keys, for tracks (tracks, keys, channels) with their numbers of keys."""
    return _thinned(times, values, lengths, tolerance, lambda start, end: end - start)


def arcs(times: Array, quaternions: Array, lengths: Array, tolerance: Array | float) -> Array:
    """The same for rotations (x, y, z, w), at constant speed between keys."""
    return _thinned(times, quaternions, lengths, tolerance, turn)


def turn(start: Array, end: Array) -> Array:
    """Rotation between two as a vector in the space of the first; half turns are ambiguous."""
    x, y, z, w = (start * numpy.array([-1.0, -1.0, -1.0, 1.0])).T
    a, b, c, d = end.T
    relative = numpy.stack(
        [w * a + x * d + y * c - z * b, w * b - x * c + y * d + z * a, w * c + x * b - y * a + z * d, w * d - x * a - y * b - z * c],
        axis=-1,
    )
    relative = numpy.where(relative[:, 3:] < 0.0, -relative, relative)
    sine = numpy.linalg.norm(relative[:, :3], axis=1)
    angle = 2.0 * numpy.arctan2(sine, relative[:, 3])
    scale = numpy.divide(angle, sine, out=numpy.full_like(sine, 2.0), where=sine > 1e-12)
    vector: Array = relative[:, :3] * scale[:, None]
    vector[angle > LARGEST_ARC] = numpy.inf
    return vector


def _thinned(
    times: Array, values: Array, lengths: Array, tolerance: Array | float, difference: Between
) -> Array:
    tracks, keys = times.shape
    stays = numpy.zeros((tracks, keys), bool)
    stays[:, 0] = True
    every = numpy.arange(tracks)
    stays[every, lengths - 1] = True
    anchor = numpy.zeros(tracks, int)
    tolerance = numpy.broadcast_to(numpy.asarray(tolerance, float).reshape(-1, 1), (tracks, 1))
    channels = difference(values[:1, 0], values[:1, 0]).shape[1] if tracks else 0
    low, high = numpy.full((tracks, channels), -numpy.inf), numpy.full((tracks, channels), numpy.inf)
    for key in range(1, keys):
        at = every[lengths > key]
        if len(at) == 0:
            break
        span = (times[at, key] - times[at, anchor[at]])[:, None]
        moved = difference(values[at, anchor[at]], values[at, key])
        slope = moved / span
        fits = numpy.all(numpy.isfinite(moved) & (slope >= low[at]) & (slope <= high[at]), axis=1)
        ended = at[~fits]
        # The run ends at the previous key, where the next begins.
        stays[ended, key - 1] = True
        anchor[ended] = key - 1
        low[ended], high[ended] = -numpy.inf, numpy.inf
        span[~fits] = (times[ended, key] - times[ended, key - 1])[:, None]
        moved[~fits] = difference(values[ended, key - 1], values[ended, key])
        with numpy.errstate(invalid="ignore"):
            low[at] = numpy.maximum(low[at], (moved - tolerance[at]) / span)
            high[at] = numpy.minimum(high[at], (moved + tolerance[at]) / span)
    return stays
