"""Keys of nodes: placements, visibility and weights as channels of the file's animation.

In go nodes with placements at moments, out come node properties and channels. Invariant: at every moment a
node is within 1e-5 m of its placement; constant properties have no key.
"""

from dataclasses import dataclass

import numpy

from . import thinning

TOLERANCE_M = 1e-5
# Number of tracks processed together, to limit memory.
TOGETHER = 1000


@dataclass
class Moving:
    """One path of a node's transform over time."""

    node: int
    path: str
    times: numpy.ndarray
    values: numpy.ndarray
    tolerance: float


class Tracks:
    """Collects motions; `write` makes channels of them."""

    def __init__(self, document, clock):
        self.document, self.clock, self.moving = document, clock, []

    def place(self, node, times, places, reach_m):
        """Sets a node's placement; `reach_m` is the maximum distance of its geometry from its origin,
        before its scale."""
        reach_m = max(reach_m, 1e-3)
        largest = max(1.0, reach_m * float(numpy.abs(places.scale).max()))
        # Errors of the three parts add up.
        for path, values, tolerance, rest in (
            ("translation", places.translation, 0.4 * TOLERANCE_M, (0.0, 0.0, 0.0)),
            ("rotation", places.rotation, 0.3 * TOLERANCE_M / largest, (0.0, 0.0, 0.0, 1.0)),
            ("scale", places.scale, 0.2 * TOLERANCE_M / max(1.0, reach_m), (1.0, 1.0, 1.0)),
        ):
            self.path(Moving(node, path, times, values, tolerance), rest)

    def path(self, moving, rest):
        said = self.document.lists["nodes"][moving.node]
        first = moving.values[0]
        if numpy.abs(moving.values - first).max() <= 0.5 * moving.tolerance:
            if not numpy.array_equal(first, rest):
                said[moving.path] = first.tolist()
            return
        said[moving.path] = first.tolist()
        self.moving.append(moving)

    def visible(self, node, frames, is_there, switch):
        """Shows a node only at these frames."""
        if all(is_there):
            return
        self.document.extensions.add("KHR_node_visibility")
        said = self.document.lists["nodes"][node]
        said.setdefault("extensions", {})["KHR_node_visibility"] = {"visible": bool(is_there[0])}
        is_there = numpy.asarray(is_there)
        changes = numpy.flatnonzero(numpy.diff(is_there)) + 1
        if len(changes) == 0:
            return
        at = numpy.concatenate([[0], changes])
        times = self.clock.seconds(numpy.asarray(frames, float)[at] + switch)
        pointer = f"/nodes/{node}/extensions/KHR_node_visibility/visible"
        self.document.pointer_channel(pointer, times, is_there[at].astype("u1"), "STEP")

    def write(self):
        """Writes the channels of all motions."""
        for path, thin in (
            ("translation", thinning.straight),
            ("rotation", thinning.arcs),
            ("scale", thinning.straight),
        ):
            moving = sorted((one for one in self.moving if one.path == path), key=lambda one: len(one.times))
            for first in range(0, len(moving), TOGETHER):
                self.write_some(moving[first : first + TOGETHER], thin)

    def write_some(self, moving, thin):
        lengths = numpy.array([len(one.times) for one in moving])
        shape = (len(moving), lengths.max())
        times, values = numpy.zeros(shape), numpy.zeros((*shape, moving[0].values.shape[1]))
        for row, one in enumerate(moving):
            times[row, : lengths[row]], values[row, : lengths[row]] = one.times, one.values
        stays = thin(times, values, lengths, numpy.array([one.tolerance for one in moving]))
        for row, one in enumerate(moving):
            kept = stays[row, : lengths[row]]
            self.document.node_channel(
                one.node, one.path, self.clock.seconds(one.times[kept]), one.values[kept]
            )
