"""Normals of refined subdivision surfaces. Invariant: corners at a vertex share a normal, unless a sharp
edge separates them."""

import numpy as np

from .subdivision import Cage, sums
from .triangles import cross


def smooth_normals(cage: Cage, points: np.ndarray) -> np.ndarray:
    """Normal for each corner: the area-weighted mean around its vertex, bounded by sharp edges."""
    here = points[cage.corners]
    facing = cross(here[cage.next_corner] - here, here[cage.corner_before] - here)
    fans = _fans(cage)
    about = sums(fans, facing, int(fans.max(initial=-1)) + 1)[fans]
    lengths = np.linalg.norm(about, axis=1, keepdims=True)
    flat = np.array([0.0, 0.0, 1.0])
    return np.where(lengths > 0, about / np.where(lengths > 0, lengths, 1.0), flat)


def _fans(cage: Cage) -> np.ndarray:
    """Number for each corner, equal for those at a vertex without a sharp edge between them."""
    edges = cage.edges
    parts = (edges.faces == 2) & (edges.sharpness > 0)
    if not parts.any():
        return cage.corners
    touched = np.zeros(cage.vertices, bool)
    touched[edges.ends[parts]] = True
    own = touched[cage.corners]
    fans = np.where(own, cage.vertices + np.arange(len(cage.corners)), cage.corners)
    # Corners on both sides of an edge, at each of its ends.
    order = np.argsort(edges.of_corner, kind="stable")
    twin = order[:-1][edges.of_corner[order[:-1]] == edges.of_corner[order[1:]]]
    other = order[1:][edges.of_corner[order[:-1]] == edges.of_corner[order[1:]]]
    open_ = ~parts[edges.of_corner[twin]] & (edges.faces[edges.of_corner[twin]] == 2)
    twin, other = twin[open_], other[open_]
    same_way = cage.corners[twin] == cage.corners[other]
    left = np.concatenate([twin, cage.next_corner[twin]])
    near = np.where(same_way, other, cage.next_corner[other])
    far = np.where(same_way, cage.next_corner[other], other)
    right = np.concatenate([near, far])
    inside = own[left]
    left, right = left[inside], right[inside]
    while True:
        lower = np.minimum(fans[left], fans[right])
        if (lower == fans[left]).all() and (lower == fans[right]).all():
            return fans
        np.minimum.at(fans, left, lower)
        np.minimum.at(fans, right, lower)
