"""Pixels that are not square (HDV, DV, anamorphic pictures), of square ones.

In go Blender's size and aspect, out come the size for the program, which knows square pixels alone, and Blender's pixels
of its frame. Invariant: no side of a pixel is coarser than Blender's.
"""

import numpy

from .. import render
from .picture import Picture


class Pixels:
    """Blender's pixels, and those of the program, which are `along` times as many in each direction."""

    def __init__(self, settings, width, height):
        aspect = settings.pixel_aspect_x / settings.pixel_aspect_y
        self.size, self.along = (width, height), (max(1.0, aspect), max(1.0, 1.0 / aspect))
        self.square = tuple(max(1, round(side * along)) for side, along in zip(self.size, self.along))
        self.border = render.border(settings, width, height) if settings.use_border else None

    def flags(self):
        """Flags for the program."""
        size = f"--size={self.square[0]}x{self.square[1]}"
        if self.border is None:
            return [size]
        edges = [round(edge * square / side) for edge, square, side in zip(self.border, 2 * self.square, 2 * self.size)]
        return [size, f"--crop={','.join(map(str, edges))}"]

    def of(self, picture):
        """Blender's pixels of the program's, which are of the whole picture or of its border."""
        if self.square == self.size:
            return picture
        left, top, right, bottom = self.border or (0, 0, *self.size)
        is_whole = picture.pixels.shape[1::-1] == self.square
        columns, rows = self.size if is_whole else (right - left, bottom - top)
        names = list(picture.numbers)
        found = numpy.empty((rows, columns, len(names)), "f4")
        nearest = numpy.ix_(middles(picture.pixels.shape[0], rows), middles(picture.pixels.shape[1], columns))
        for at, name in enumerate(names):
            one = picture.pixels[..., at]
            found[..., at] = means(means(one, rows).T, columns).T if is_light(name) else one[nearest]
            if name.startswith("Vector."):
                # Pixels from left to right, then from the bottom up.
                found[..., at] /= self.along[name[-1] in "YW"]
        return Picture(names, found, picture.manifest)


def is_light(name):
    """Whether a channel can be averaged, and is no number of a thing, normal or place."""
    return name[-1] in "RGBAY" and name[-2:-1] in ("", ".") and not name.startswith(("Crypto", "Normal", "Position", "Vector"))


def middles(count, wanted):
    """Of so many, those in the middles of others."""
    return ((numpy.arange(wanted) + 0.5) * count / wanted).astype(int)


def means(rows, wanted):
    """Means of rows over as many stretches, whose ends may lie within rows."""
    if len(rows) == wanted:
        return rows
    sums = numpy.concatenate([numpy.zeros((1, rows.shape[1])), numpy.cumsum(rows, axis=0, dtype=float)])
    ends = numpy.linspace(0.0, len(rows), wanted + 1)
    whole = numpy.minimum(ends.astype(int), len(rows) - 1)
    sums = sums[whole] + (ends - whole)[:, None] * rows[whole]
    return numpy.diff(sums, axis=0) * (wanted / len(rows))
