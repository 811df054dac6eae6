"""Deforming meshes: shapes over time as morph targets with weights.

In go shapes of one topology by time, out come few targets. Invariant: at every time each vertex is within
the tolerance of its position. Shapes that are linear combinations of a few (shape keys, a hinge's small
rotation) need only those few; otherwise each shape is a target.
"""

import numpy

from . import thinning
from .meshes import Layout, turned

TOLERANCE_M = 5e-6
# With more independent shapes, each shape becomes a target.
MOST_MIXED = 24


class Bend:
    """Deformation of one topology: `times` are frames with offset, `shapes` the index of the shape at
    each, among `geometries`."""

    def __init__(self, times, shapes, geometries):
        self.times = numpy.asarray(times, float)
        distinct, self.of_time = numpy.unique(numpy.asarray(shapes), return_inverse=True)
        self.geometries = [geometries[shape] for shape in distinct]
        self.base = geometries[shapes[0]]
        self.layout = Layout(self.base, True)
        moved = numpy.stack([shape.positions - self.base.positions for shape in self.geometries]).reshape(
            len(distinct), -1
        )
        self.chosen = mixed_from(moved)
        self.weights = weights(moved, self.chosen)
        if self.weights is None:
            self.chosen = [index for index in range(len(distinct)) if numpy.any(moved[index])]
            self.weights = numpy.eye(len(distinct))[:, self.chosen]

    def targets(self, document):
        positions = [self.geometries[index].positions - self.base.positions for index in self.chosen]
        vertices = self.base.corner_vertices[self.layout.corners]
        found = [
            {"POSITION": document.accessor(turned(moved[vertices]).astype("f4"), bounds=True)}
            for moved in positions
        ]
        for target, normals in zip(found, self.normals()):
            target["NORMAL"] = document.accessor(normals.astype("f4"))
        return found

    def normals(self):
        """Displacements of normals of each target, by least squares over all times."""
        at_rest = self.layout.normals(self.base)
        if at_rest is None:
            return []
        moved = numpy.stack([self.layout.normals(shape) - at_rest for shape in self.geometries])
        fitted, *_ = numpy.linalg.lstsq(self.weights, moved.reshape(len(moved), -1).astype(float), rcond=None)
        return fitted.reshape(len(self.chosen), -1, 3)

    def keys(self):
        """Times and weights of the targets, without keys that interpolation gives."""
        values = self.weights[self.of_time]
        moved = numpy.stack([self.geometries[index].positions for index in self.chosen]) - self.base.positions
        largest = max(1e-9, float(numpy.abs(moved).max()))
        stays = thinning.straight(
            self.times[None], values[None], numpy.array([len(self.times)]), 0.2 * TOLERANCE_M / largest
        )[0]
        return self.times[stays], values[stays]


def mixed_from(moved):
    """Rows that span all others: repeatedly the one that is farthest from the span of those before."""
    left, chosen = moved.astype(float), []
    while len(chosen) < min(MOST_MIXED, len(moved)):
        farthest = numpy.abs(left).max(axis=1)
        row = int(farthest.argmax())
        if farthest[row] < 0.5 * TOLERANCE_M:
            break
        chosen.append(row)
        direction = left[row] / numpy.linalg.norm(left[row])
        left -= numpy.outer(left @ direction, direction)
    return chosen


def weights(moved, chosen):
    """Weights of each row in terms of those; None if it is outside their span."""
    if not chosen:
        return None
    basis = moved[chosen].astype(float)
    found = numpy.linalg.lstsq(basis.T, moved.T.astype(float), rcond=None)[0].T
    off = float(numpy.abs(found.astype("f4").astype(float) @ basis - moved).max())
    return found if off < TOLERANCE_M else None
