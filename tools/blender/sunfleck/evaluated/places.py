"""Placements as glTF's translation, rotation and scale.

In go matrices of Blender, (rows, 4, 4), out come those of glTF and their parts. Invariant: the product of
the parts is the matrix, to single precision; for a shear, there is an inner rotation before the scale.
"""

from dataclasses import dataclass

import numpy

# From Blender's axes to glTF's.
TURN = numpy.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]], float)
# Tolerance of orthogonal axes, for single precision.
SQUARE = 3e-6
# Replacement of a scale of 0, relative to the largest scale.
FLAT = 1e-6


@dataclass
class Places:
    """Parts of matrices, a row each; `inner` is None without a shear."""

    translation: numpy.ndarray
    rotation: numpy.ndarray
    scale: numpy.ndarray
    inner: numpy.ndarray | None = None


def in_gltf(matrices, looks):
    """Placements in glTF's axes. Cameras and lights look along -z in both; shapes are rotated."""
    return TURN @ matrices if looks else TURN @ matrices @ TURN.T


def unit_axes(linear):
    """Axes at unit length, lengths, and for each matrix the largest cosine between two axes."""
    lengths = numpy.linalg.norm(linear, axis=1)
    axes = linear / numpy.where(lengths > 0.0, lengths, 1.0)[:, None, :]
    products = numpy.abs(numpy.swapaxes(axes, 1, 2) @ axes)
    products[:, range(3), range(3)] = 0.0
    return axes, lengths, products.max(axis=(1, 2), initial=0.0)


def turned_and_scaled(axes, lengths):
    """Quaternions and scales; one of a mirrored matrix is negative in all three."""
    sign = numpy.where(numpy.linalg.det(axes) < 0.0, -1.0, 1.0)
    return quaternions(axes * sign[:, None, None]), lengths * sign[:, None]


def parts(matrices):
    """Parts of the matrices of one moving object, in the order of time."""
    linear, translation = matrices[:, :3, :3], matrices[:, :3, 3]
    axes, lengths, cosines = unit_axes(linear)
    if cosines.max(initial=0.0) > SQUARE:
        return sheared(linear, translation)
    turns, scales = turned_and_scaled(filled(axes, lengths), shown(lengths))
    return Places(translation, smooth(turns), scales)


def each(matrices):
    """Parts of the matrices of constant objects, one each, all at once."""
    axes, lengths, cosines = unit_axes(matrices[:, :3, :3])
    is_plain = (cosines <= SQUARE) & (lengths > 0.0).all(axis=1)
    turns, scales = turned_and_scaled(axes, lengths)
    return [
        Places(matrices[row : row + 1, :3, 3], turns[row : row + 1], scales[row : row + 1])
        if is_plain[row] else parts(matrices[row : row + 1])
        for row in range(len(matrices))
    ]


def shown(lengths):
    """Scales with a very small value in place of 0, as flat objects are visible and points are not."""
    is_flat = (lengths <= 0.0) & ((lengths <= 0.0).sum(axis=1, keepdims=True) == 1)
    return numpy.where(is_flat, FLAT * lengths.max(axis=1, keepdims=True), lengths)


def filled(axes, lengths):
    """Orthogonal axes even for scales of 0: those of the previous row, or arbitrary ones."""
    flat = numpy.flatnonzero((lengths <= 0.0).any(axis=1))
    if len(flat) == 0:
        return axes
    axes = axes.copy()
    whole = (lengths > 0.0).all(axis=1)
    for row in flat:
        missing = lengths[row] <= 0.0
        earlier = numpy.flatnonzero(whole[:row])
        if missing.all():
            axes[row] = axes[earlier[-1]] if len(earlier) else numpy.eye(3)
            continue
        # Basis of the rest, by singular value decomposition.
        left, _, right = numpy.linalg.svd(numpy.where(missing, 0.0, axes[row]))
        nearest = left @ right
        axes[row][:, missing] = nearest[:, missing]
        if numpy.linalg.det(axes[row]) < 0.0:
            axes[row][:, numpy.flatnonzero(missing)[0]] *= -1.0
    return axes


def sheared(linear, translation):
    """Left rotation, scales and right rotation (the singular values), each as near as possible to those of
    the previous row."""
    left, scale, right = numpy.linalg.svd(linear)
    mirrored = numpy.linalg.det(left @ right) < 0.0
    for row in range(len(linear)):
        if numpy.linalg.det(right[row]) < 0.0:
            left[row], right[row] = -left[row], -right[row]
        if row:
            left[row], scale[row], right[row] = nearest_to(right[row - 1], left[row], scale[row], right[row])
    left[mirrored], scale[mirrored] = -left[mirrored], -scale[mirrored]
    return Places(translation, smooth(quaternions(left)), scale, smooth(quaternions(right)))


def nearest_to(before, left, scale, right):
    """The same decomposition, with singular vectors ordered and signed so that the right ones are nearest
    to the previous ones."""
    best = None
    for order in ((0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1), (2, 1, 0), (1, 0, 2)):
        rows = right[list(order)]
        signs = numpy.where((rows * before).sum(axis=1) < 0.0, -1.0, 1.0)
        if numpy.linalg.det(rows * signs[:, None]) < 0.0:
            weakest = int(numpy.argmin(numpy.abs((rows * before).sum(axis=1))))
            signs[weakest] *= -1.0
        alike = float((rows * signs[:, None] * before).sum())
        if best is None or alike > best[0] + 1e-9:
            best = (alike, left[:, list(order)] * signs, scale[list(order)], rows * signs[:, None])
    return best[1:]


def quaternions(rotations):
    """Quaternions (x, y, z, w) of rotation matrices, by the largest component (Shepperd 1978)."""
    m = rotations
    trace = m[:, 0, 0] + m[:, 1, 1] + m[:, 2, 2]
    squares = numpy.stack([m[:, 0, 0], m[:, 1, 1], m[:, 2, 2], trace], axis=1)
    largest = squares.argmax(axis=1)
    found = numpy.empty((len(m), 4))
    last = largest == 3
    found[last, 3] = 1.0 + trace[last]
    for axis in range(3):
        at = largest == axis
        i, j, k = axis, (axis + 1) % 3, (axis + 2) % 3
        found[at, i] = 1.0 + m[at, i, i] - m[at, j, j] - m[at, k, k]
        found[at, j] = m[at, i, j] + m[at, j, i]
        found[at, k] = m[at, i, k] + m[at, k, i]
        found[at, 3] = m[at, k, j] - m[at, j, k]
        found[last, i] = m[last, k, j] - m[last, j, k]
    return found / numpy.linalg.norm(found, axis=1, keepdims=True)


def smooth(found):
    """Signs of quaternions chosen nearest to the previous row."""
    if len(found) > 1:
        flips = numpy.where((found[1:] * found[:-1]).sum(axis=1) < 0.0, -1.0, 1.0)
        found[1:] *= numpy.cumprod(flips)[:, None]
    return found
