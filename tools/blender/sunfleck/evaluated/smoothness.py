"""Decision whether linear interpolation between a frame's moments suffices, or more moments are needed.

In goes a growing record, out comes a boolean. Invariant: halving an interval quarters the error, so a
round of moments within four times the tolerance of the previous lines leaves errors within the tolerance.
"""

import numpy

TOLERANCE_M = 2e-4


class Smoothness:
    """Smoothness of the last visited frame."""

    def __init__(self, record):
        self.record, self.judged = record, 0

    def is_enough(self):
        """Whether the moments since the last call were within tolerance."""
        moments, frame = self.record.moments, self.record.moments[-1][0]
        first = len(moments)
        while first and moments[first - 1][0] == frame:
            first -= 1
        ordered = sorted(range(first, len(moments)), key=lambda index: moments[index][1])
        new = [at for at in range(1, len(ordered) - 1) if ordered[at] >= max(self.judged, first)]
        self.judged = len(moments)
        return all(self.deviation(*ordered[at - 1 : at + 2]) < 4.0 * TOLERANCE_M for at in new)

    def deviation(self, *indices):
        """Distance from the line between the moments before and after."""
        offsets = [self.record.moments[index][1] for index in indices]
        share = (offsets[1] - offsets[0]) / (offsets[2] - offsets[0])
        before, here, after = (self.record.matrices[index] for index in indices)
        placed = [self.record.placed[index] for index in indices]
        alike = all(numpy.array_equal(one[0], placed[1][0]) for one in placed)
        if not (len(before) == len(here) == len(after) and alike):
            return numpy.inf
        # Cameras, lights and fog have no geometry; a metre counts for them.
        reach = numpy.ones(len(here))
        reach[placed[1][0]] = [self.record.capture.reach(number) for number in placed[1][1]]
        off = numpy.abs(here - between(before, after, share))
        farthest = off[:, :3, 3].max(axis=1) + reach * off[:, :3, :3].max(axis=(1, 2))
        return max(float(farthest.max(initial=0.0)), self.bending(placed, here, share))

    def bending(self, placed, matrices, share):
        """Distances of vertices of deforming meshes."""
        worst = 0.0
        for at in numpy.flatnonzero(placed[0][1] != placed[2][1]):
            before, here, after = (self.record.geometries[rows[1][at]] for rows in placed)
            if before.topology == here.topology == after.topology:
                off = here.positions - (1.0 - share) * before.positions - share * after.positions
                worst = max(
                    worst,
                    float(numpy.abs(off).max()) * float(numpy.abs(matrices[placed[1][0][at], :3, :3]).max()),
                )
        return worst


def between(before, after, share):
    """Interpolated placements; rotating ones keep their size, as on an arc."""
    found = (1.0 - share) * before + share * after
    wanted = (1.0 - share) * sizes(before) + share * sizes(after)
    found[:, :3, :3] *= (wanted / numpy.maximum(sizes(found), 1e-12))[:, None, :]
    return found


def sizes(matrices):
    return numpy.linalg.norm(matrices[:, :3, :3], axis=1)
