"""Triangulation of polygons. Invariant: the area of a flat polygon is that of its triangles, even if it is
not convex."""

from functools import lru_cache

import numpy as np

MOST_CORNERS = 1000
"""Maximum corners of a face that is not convex, as clipping takes quadratic time."""
AROUND = np.array([0, 1, 2, 3, 0, 1])
"""The corners of a quadrangle, and the first two once more."""
TURNED, TURNED_TWICE = np.array([1, 2, 0]), np.array([2, 0, 1])
MOST_KNOWN = 4096
"""Maximum faces of a mesh whose fans are cached."""


def triangulate(counts: np.ndarray, points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Triangles as indices into `corners`, and in a fourth column their face. `points` are positions of
    vertices.

    Raises `ValueError` if a face has too many corners.
    """
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(np.int64)
    found = []
    is_one = len(counts) and counts.min() == counts.max()
    different = counts[:1] if is_one else np.unique(counts)
    for count in different:
        if count < 3:
            continue
        if is_one and len(counts) <= MOST_KNOWN:
            faces, places, fans = _known_fans(len(counts), int(count))
        else:
            faces = np.nonzero(counts == count)[0]
            places = starts[faces, None] + np.arange(count)
            fans = None
        bent = np.zeros(len(faces), bool) if count == 3 else ~_is_convex(points[corners[places]])
        if count > MOST_CORNERS and bent.any():
            raise ValueError(f"a face has {count} corners and is not convex: at most {MOST_CORNERS} can be")
        if fans is None or bent.any():
            fans = fans_of(faces[~bent], places[~bent])
        found.append(fans)
        for face in np.nonzero(bent)[0]:
            ears = places[face][_ears(points[corners[places[face]]])]
            found.append(np.column_stack([ears, np.full(len(ears), faces[face])]))
    if not found:
        return np.zeros((0, 4), np.int64)
    if len(found) == 1:
        return found[0]
    triangles = np.concatenate(found)
    return triangles[np.argsort(triangles[:, 3], kind="stable")]


@lru_cache(maxsize=16)
def _known_fans(faces: int, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Faces, indices of corners, and fans for faces with equal numbers of corners, cached as stages have
    many meshes of few such sizes."""
    numbers = np.arange(faces)
    places = numbers[:, None] * count + np.arange(count)
    known = numbers, places, fans_of(numbers, places)
    for each in known:
        each.setflags(write=False)
    return known


def fans_of(faces: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Triangles around the first corner of each face, as of `triangulate`."""
    fans = np.empty((len(places), places.shape[1] - 2, 4), np.int64)
    fans[:, :, 0], fans[:, :, 1] = places[:, :1], places[:, 1:-1]
    fans[:, :, 2], fans[:, :, 3] = places[:, 2:], faces[:, None]
    return fans.reshape(-1, 4)


def _following(rows: np.ndarray) -> np.ndarray:
    """The next of each face's rows."""
    return np.concatenate([rows[:, 1:], rows[:, :1]], axis=1)


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Cross products of rows; numpy's own is several times slower for few vectors, of which a stage has
    many."""
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)


def _normals(polygons: np.ndarray) -> np.ndarray:
    """Newell's normals, also for polygons that are not flat."""
    return cross(polygons, _following(polygons)).sum(axis=1)


def are_convex(points: np.ndarray, loops: np.ndarray) -> bool:
    """Whether all polygons are convex; they are rows of points."""
    sides = loops.shape[1]
    if sides != 4:
        return sides == 3 or bool(_is_convex(points[loops]).all())
    # Quadrangles are most frequent: the same sums with a third of the calls.
    around = points.take(loops.take(AROUND, axis=1), axis=0)
    edges = around[:, 1:] - around[:, :-1]
    # y, z, x and z, x, y, for products of whole arrays.
    turned, turned_twice = edges.take(TURNED, axis=2), edges.take(TURNED_TWICE, axis=2)
    turns = turned[:, :-1] * turned_twice[:, 1:] - turned_twice[:, :-1] * turned[:, 1:]
    normals = turns[:, 0] + turns[:, 1] + turns[:, 2] + turns[:, 3]
    along = turns * normals[:, None]
    return float((along[..., 0] + along[..., 1] + along[..., 2]).min()) >= 0


def _is_convex(polygons: np.ndarray) -> np.ndarray:
    edges = _following(polygons) - polygons
    turns = cross(edges, _following(edges))
    # The cross products of a quadrangle add up to twice Newell's normal.
    normals = turns.sum(axis=1) if polygons.shape[1] == 4 else _normals(polygons)
    return (np.einsum("fci,fi->fc", turns, normals) >= 0).all(axis=1)


def _ears(polygon: np.ndarray) -> np.ndarray:
    """Ear clipping (Meisters 1975), in the coordinate plane where the polygon is largest."""
    normal = _normals(polygon[None])[0]
    axis = int(np.argmax(np.abs(normal)))
    flat = np.delete(polygon, axis, axis=1)
    # Without y the plane is mirrored.
    if (normal[axis] < 0) != (axis == 1):
        flat = flat * [1, -1]
    left = list(range(len(flat)))
    ears = []
    while len(left) > 3:
        tip = next((at for at in range(len(left)) if _is_ear(flat, left, at)), 0)
        ears.append([left[tip - 1], left[tip], left[(tip + 1) % len(left)]])
        del left[tip]
    return np.array(ears + [left])


def _is_ear(flat: np.ndarray, left: list[int], at: int) -> bool:
    a, b, c = flat[left[at - 1]], flat[left[at]], flat[left[(at + 1) % len(left)]]
    if _side(a, b, c) <= 0:
        return False
    others = flat[[each for each in left if each not in (left[at - 1], left[at], left[(at + 1) % len(left)])]]
    within = (_side(a, b, others) >= 0) & (_side(b, c, others) >= 0) & (_side(c, a, others) >= 0)
    return not within.any()


def _side(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    return (b[0] - a[0]) * (c[..., 1] - a[1]) - (b[1] - a[1]) * (c[..., 0] - a[0])
