"""Keys that straight lines between others give are left out.

In go values at times, out come masks of those that stay. Invariant: at every time that went in, the line (or
the arc of constant speed) through the keys that stay is within the tolerance. All tracks go along together, a
key at a time. From the last key that stayed, the slopes that pass near enough to every key since are an
interval. A key that lies beyond it ends the run before it.
"""

from collections.abc import Callable
from typing import Any

import numpy
from numpy.typing import NDArray

Array = NDArray[Any]
Between = Callable[[Array, Array], Array]
# Arcs from key to key are less than half a turn.
LARGEST_ARC = 0.95 * numpy.pi


def straight(times: Array, values: Array, lengths: Array, tolerance: Array | float) -> Array:
    """Which keys stay, of tracks (tracks, keys, channels) of which each has so many keys."""
    return _thinned(times, values, lengths, tolerance, lambda start, end: end - start)


def arcs(times: Array, quaternions: Array, lengths: Array, tolerance: Array | float) -> Array:
    """The same of rotations (x, y, z, w), which turn at constant speed between keys."""
    return _thinned(times, quaternions, lengths, tolerance, turn)


def turn(start: Array, end: Array) -> Array:
    """The rotation from one to the other as a vector in the start's space; half turns are too
    long to be sure of."""
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
        # The run ends a key earlier, where the next begins.
        stays[ended, key - 1] = True
        anchor[ended] = key - 1
        low[ended], high[ended] = -numpy.inf, numpy.inf
        span[~fits] = (times[ended, key] - times[ended, key - 1])[:, None]
        moved[~fits] = difference(values[ended, key - 1], values[ended, key])
        with numpy.errstate(invalid="ignore"):
            low[at] = numpy.maximum(low[at], (moved - tolerance[at]) / span)
            high[at] = numpy.minimum(high[at], (moved + tolerance[at]) / span)
    return stays
