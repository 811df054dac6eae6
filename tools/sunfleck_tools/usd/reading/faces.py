"""Faces of a mesh at one time. Invariant: an index that is handed out is that of a point."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pxr import Usd, UsdGeom

from ...errors import SceneError


@dataclass(frozen=True)
class Faces:
    """Corners a face, the point of each corner, and the faces that are holes; `flips` if its
    front is clockwise."""

    counts: np.ndarray
    corners: np.ndarray
    holes: np.ndarray
    flips: bool = False

    @property
    def count(self) -> int:
        """How many there are."""
        return len(self.counts)


def value_of(attribute: Usd.Attribute, code: float, default=None):
    """An attribute's value at a time code, if it has one."""
    found = attribute.Get(code) if attribute else None
    return default if found is None else found


def rows_of(attribute: Usd.Attribute, code: float, width: int, kind: type = float) -> np.ndarray:
    """An array's values, none without one."""
    found = value_of(attribute, code)
    return np.zeros((0, width), kind) if found is None else np.array(found, kind).reshape(-1, width)


def read_points(prim: Usd.Prim, code: float) -> np.ndarray:
    """Points of a mesh at a time code. Raises `SceneError`."""
    points = rows_of(UsdGeom.Mesh(prim).GetPointsAttr(), code, 3)
    if not np.isfinite(points).all():
        raise SceneError(f"{prim.GetPath()}: points are not all finite")
    return points


def read_faces(prim: Usd.Prim, code: float, points: int) -> Faces:
    """Faces of a mesh of so many points. Raises `SceneError`."""
    mesh = UsdGeom.Mesh(prim)
    counts = rows_of(mesh.GetFaceVertexCountsAttr(), code, 1, np.int64).ravel()
    corners = rows_of(mesh.GetFaceVertexIndicesAttr(), code, 1, np.int64).ravel()
    if (counts < 0).any() or counts.sum() != len(corners):
        raise SceneError(
            f"{prim.GetPath()}: faceVertexCounts ask for {counts.sum()} corners, faceVertexIndices have "
            f"{len(corners)}"
        )
    if len(corners) and (corners.min() < 0 or corners.max() >= points):
        raise SceneError(
            f"{prim.GetPath()}: faceVertexIndices go from {corners.min()} to {corners.max()}, of {points} "
            "points"
        )
    holes = rows_of(mesh.GetHoleIndicesAttr(), code, 1, np.int64).ravel()
    return Faces(
        counts, corners, holes, value_of(mesh.GetOrientationAttr(), code) == UsdGeom.Tokens.leftHanded
    )
