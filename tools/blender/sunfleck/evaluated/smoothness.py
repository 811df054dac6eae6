"""Whether straight lines between a frame's moments are near enough to what moves, or more moments are wanted.

In goes a record that grows, out comes yes or no. Invariant: what halves its distance quarters its error, so a round of moments
that lie within four times the tolerance of the lines before it leaves errors within the tolerance.
"""

import numpy

TOLERANCE_M = 2e-4


class Smoothness:
    """Of the frame that was looked at last."""

    def __init__(self, record):
        self.record, self.judged = record, 0

    def is_enough(self):
        """Whether what was looked at since the last question was to be expected."""
        moments, frame = self.record.moments, self.record.moments[-1][0]
        first = len(moments)
        while first and moments[first - 1][0] == frame:
            first -= 1
        ordered = sorted(range(first, len(moments)), key=lambda index: moments[index][1])
        new = [at for at in range(1, len(ordered) - 1) if ordered[at] >= max(self.judged, first)]
        self.judged = len(moments)
        return all(self.deviation(*ordered[at - 1 : at + 2]) < 4.0 * TOLERANCE_M for at in new)

    def deviation(self, *indices):
        """How far something is from the straight line between the moments before and after."""
        offsets = [self.record.moments[index][1] for index in indices]
        share = (offsets[1] - offsets[0]) / (offsets[2] - offsets[0])
        before, here, after = (self.record.matrices[index] for index in indices)
        if not len(before) == len(here) == len(after):
            return numpy.inf
        shown = [self.record.numbers[index] for index in indices]
        reach = numpy.array([self.record.reach(number) for number in range(len(self.record.geometries))] + [0.0])[shown[1]]
        off = numpy.abs(here - between(before, after, share))
        farthest = off[:, :3, 3].max(axis=1) + reach * off[:, :3, :3].max(axis=(1, 2))
        return max(float(farthest.max(initial=0.0)), self.bending(shown, here, share))

    def bending(self, shown, matrices, share):
        """The same of vertices of meshes that bend."""
        worst = 0.0
        for row in numpy.flatnonzero((shown[0] != shown[2]) & (shown[0] >= 0) & (shown[2] >= 0)):
            before, here, after = (self.record.geometries[number[row]] for number in shown)
            if before.topology == here.topology == after.topology:
                off = here.positions - (1.0 - share) * before.positions - share * after.positions
                worst = max(worst, float(numpy.abs(off).max()) * float(numpy.abs(matrices[row, :3, :3]).max()))
        return worst


def between(before, after, share):
    """Places on the way; what turns keeps its size, as on an arc."""
    found = (1.0 - share) * before + share * after
    wanted = (1.0 - share) * sizes(before) + share * sizes(after)
    found[:, :3, :3] *= (wanted / numpy.maximum(sizes(found), 1e-12))[:, None, :]
    return found


def sizes(matrices):
    return numpy.linalg.norm(matrices[:, :3, :3], axis=1)
