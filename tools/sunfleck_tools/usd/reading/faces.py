"""Faces of a mesh at one time. Invariant: every index is that of a point."""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from pxr import Usd, UsdGeom

from ...errors import SceneError
from .rows import different_numbers
from .triangles import fans_of

MOST_KEPT = 2**13
"""Maximum corners of a mesh whose faces are cached."""
KEPT = 64
"""Number of cached faces: at most 50 MB, with derived data."""


@dataclass(frozen=True, eq=False)
class Faces:
    """Corners a face, the point of each corner, and the faces that are holes; `flips` if its front is
    clockwise. Derived data are computed once."""

    counts: np.ndarray
    corners: np.ndarray
    holes: np.ndarray
    flips: bool = False

    @property
    def count(self) -> int:
        """Number of faces."""
        return len(self.counts)

    @cached_property
    def has_all_corners(self) -> bool:
        """Whether there are as many corners as the faces require."""
        return not (self.counts < 0).any() and int(self.counts.sum()) == len(self.corners)

    @cached_property
    def ends(self) -> tuple[int, int]:
        """Smallest and largest point index; (0, -1) without corners."""
        return (int(self.corners.min()), int(self.corners.max())) if len(self.corners) else (0, -1)

    @cached_property
    def loops(self) -> np.ndarray | None:
        """Points around each face, a row a face, if all faces have the same number, three or more."""
        sides = int(self.counts[0]) if self.count else 0
        return self.corners.reshape(-1, sides) if sides >= 3 and (self.counts == sides).all() else None

    @cached_property
    def fans(self) -> np.ndarray:
        """Triangles of `loops`, as of `triangulate`, if all faces are convex."""
        assert self.loops is not None
        return fans_of(np.arange(self.count), np.arange(len(self.corners)).reshape(self.loops.shape))

    @cached_property
    def welded(self) -> tuple[np.ndarray, np.ndarray]:
        """`fans` with shared vertices: the corner of each vertex, and triangles of vertices."""
        corner_of_row, row_of_corner = different_numbers(self.corners, self.ends[1] + 1)
        return corner_of_row, row_of_corner[self.fans[:, :3]]


def value_of(attribute: Usd.Attribute, code: float, default=None):
    """Value of an attribute at a time code, if it has one."""
    found = attribute.Get(code) if attribute else None
    return default if found is None else found


def rows_of(attribute: Usd.Attribute, code: float, width: int, kind: type = float) -> np.ndarray:
    """Rows of an array, empty without one. Raises `SceneError`, as a file may give an attribute any type."""
    found = value_of(attribute, code)
    if found is None:
        return np.zeros((0, width), kind)
    rows: np.ndarray = np.array(found, kind)
    if rows.size > 0 and rows.shape[1:] != (() if width == 1 else (width,)) or rows.ndim == 0:
        said = f"`{attribute.GetName()}` holds other values than {attribute.GetTypeName()}"
        raise SceneError(f"{attribute.GetPrim().GetPath()}: {said}")
    return rows.reshape(-1, width)


def read_points(prim: Usd.Prim, code: float) -> np.ndarray:
    """Points of a mesh at a time code. Raises `SceneError`."""
    points = rows_of(prim.GetAttribute("points"), code, 3)
    if not np.isfinite(points).all():
        raise SceneError(f"{prim.GetPath()}: points are not all finite")
    return points


def read_faces(prim: Usd.Prim, code: float, points: int, authored: frozenset[str]) -> Faces:
    """Faces of a mesh with `points` points; `authored` are its authored properties. Raises `SceneError`."""

    def numbers(name: str) -> bytes:
        return rows_of(prim.GetAttribute(name), code, 1, np.int64).tobytes()

    counts, corners = numbers("faceVertexCounts"), numbers("faceVertexIndices")
    holes = numbers("holeIndices") if "holeIndices" in authored else b""
    flips = (
        "orientation" in authored
        and value_of(prim.GetAttribute("orientation"), code) == UsdGeom.Tokens.leftHanded
    )
    make = _known_faces if len(corners) <= MOST_KEPT * np.int64().nbytes else _faces
    faces = make(counts, corners, holes, flips)
    if not faces.has_all_corners:
        raise SceneError(
            f"{prim.GetPath()}: faceVertexCounts ask for {faces.counts.sum()} corners, faceVertexIndices have "
            f"{len(faces.corners)}"
        )
    lowest, highest = faces.ends
    if lowest < 0 or highest >= points:
        raise SceneError(
            f"{prim.GetPath()}: faceVertexIndices go from {lowest} to {highest}, of {points} points"
        )
    return faces


def _faces(counts: bytes, corners: bytes, holes: bytes, flips: bool) -> Faces:
    return Faces(np.frombuffer(counts, np.int64), np.frombuffer(corners, np.int64), np.frombuffer(holes, np.int64), flips)


_known_faces = lru_cache(maxsize=KEPT)(_faces)
"""Cached, as stages have many meshes with equal faces: copies, and regular grids."""
