"""Meshes of a stage to primitives of glTF. Invariant: no index is used that was not checked."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdShade

from ...errors import SceneError
from .losses import Losses
from .places import codes_of
from .source import Source
from .triangles import triangulate

MOST_BYTES = 2**30
"""Of the points of a mesh over all frames."""
SMALLEST = 1e-6
"""Of the size of a mesh: how far vertices that bend may lie from where they should."""


@dataclass
class Shape:
    """Triangles of one material: rows of attributes, and for what bends which point each row is."""

    attributes: dict[str, np.ndarray]
    triangles: np.ndarray
    point_of_row: np.ndarray
    material: Usd.Prim | None
    layers: list[str]


@dataclass
class Bend:
    """Points that move: what is added to them, times weights, a row a code."""

    codes: np.ndarray
    targets: list[np.ndarray]
    weights: np.ndarray


@dataclass
class Shapes:
    """A mesh of a stage."""

    parts: list[Shape] = field(default_factory=list)
    bend: Bend | None = None


def read_mesh(prim: Usd.Prim, source: Source, lost: Losses) -> Shapes:
    """All of a mesh."""
    mesh = UsdGeom.Mesh(prim)
    if mesh.GetFaceVertexIndicesAttr().ValueMightBeTimeVarying():
        lost.add("usd-faces-animated", prim.GetPath(), "its faces change over time; those of the first frame are taken")
    if _value(mesh.GetSubdivisionSchemeAttr(), source, "none") != "none" and mesh.GetSubdivisionSchemeAttr().HasAuthoredValue():
        lost.add("usd-subdivision", prim.GetPath(), "subdivision is not carried, only its cage")
    points_attribute = mesh.GetPointsAttr()
    codes = codes_of([points_attribute], source.codes)
    points = _points(prim, points_attribute, codes[0])
    counts, corners = _faces(prim, mesh, source, len(points))
    try:
        triangles = triangulate(counts, points, corners)
    except ValueError as error:
        raise SceneError(f"{prim.GetPath()}: {error}") from None
    if _value(mesh.GetOrientationAttr(), source) == UsdGeom.Tokens.leftHanded:
        triangles = triangles[:, [0, 2, 1, 3]]
    holes = np.array(_value(mesh.GetHoleIndicesAttr(), source, []), np.int64)
    triangles = triangles[~np.isin(triangles[:, 3], holes)]
    moves = len(codes) > 1
    streams, layers = _streams(prim, mesh, source, len(points), corners, counts, with_normals=not moves)
    shapes = Shapes()
    for material, faces in _subsets(prim, mesh, source, len(counts)):
        chosen = triangles[faces[triangles[:, 3]]] if faces is not None else triangles
        if len(chosen):
            shapes.parts.append(_part(points, corners, chosen, streams, layers, material))
    if moves and shapes.parts:
        shapes.bend = _bend(prim, points_attribute, codes, points)
    return shapes


def _value(attribute: Usd.Attribute, source: Source, default=None):
    found = attribute.Get(source.first) if attribute else None
    return default if found is None else found


def _points(prim: Usd.Prim, attribute: Usd.Attribute, code: float) -> np.ndarray:
    found = attribute.Get(code)
    points = np.zeros((0, 3)) if found is None else np.array(found, float).reshape(-1, 3)
    if not np.isfinite(points).all():
        raise SceneError(f"{prim.GetPath()}: points are not all finite")
    return points


def _faces(prim: Usd.Prim, mesh: UsdGeom.Mesh, source: Source, points: int) -> tuple[np.ndarray, np.ndarray]:
    counts = np.array(_value(mesh.GetFaceVertexCountsAttr(), source, []), np.int64)
    corners = np.array(_value(mesh.GetFaceVertexIndicesAttr(), source, []), np.int64)
    if (counts < 0).any() or counts.sum() != len(corners):
        raise SceneError(f"{prim.GetPath()}: faceVertexCounts ask for {counts.sum()} corners, faceVertexIndices have {len(corners)}")
    if len(corners) and (corners.min() < 0 or corners.max() >= points):
        raise SceneError(f"{prim.GetPath()}: faceVertexIndices go from {corners.min()} to {corners.max()}, of {points} points")
    return counts, corners


def _streams(prim, mesh, source, points, corners, counts, with_normals):
    """Attributes as a row a corner, by their glTF names, and the names of the texture coordinates."""
    streams: dict[str, np.ndarray] = {}
    layers: list[str] = []
    api = UsdGeom.PrimvarsAPI(prim)
    rows = {"vertex": corners, "varying": corners, "faceVarying": np.arange(len(corners)),
            "uniform": np.repeat(np.arange(len(counts)), counts), "constant": np.zeros(len(corners), np.int64)}  # fmt: skip

    def spread(values, interpolation: str, width: int) -> np.ndarray | None:
        array = np.array(values, float).reshape(-1, width) if values is not None else np.zeros((0, width))
        places = rows.get(interpolation)
        if places is None or len(corners) == 0 or len(array) <= places.max() or not np.isfinite(array).all():
            return None
        return array[places]

    if with_normals:
        primvar = api.GetPrimvar("normals")
        if primvar and primvar.HasValue():
            normals = spread(primvar.ComputeFlattened(source.first), primvar.GetInterpolation(), 3)
        else:
            normals = spread(_value(mesh.GetNormalsAttr(), source), mesh.GetNormalsInterpolation(), 3)
        lengths = np.linalg.norm(normals, axis=1) if normals is not None else np.zeros(1)
        if (lengths > 1e-6).all():
            streams["NORMAL"] = normals / lengths[:, None]
    kinds = (Sdf.ValueTypeNames.TexCoord2fArray, Sdf.ValueTypeNames.Float2Array, Sdf.ValueTypeNames.TexCoord2hArray)
    coordinates = [primvar for primvar in api.GetPrimvars() if primvar.GetTypeName() in kinds]
    coordinates.sort(key=lambda primvar: (primvar.GetPrimvarName() not in ("st", "UVMap"), primvar.GetPrimvarName()))
    for primvar in coordinates[:8]:
        found = spread(primvar.ComputeFlattened(source.first), primvar.GetInterpolation(), 2)
        if found is not None:
            # glTF counts rows of texels from the top.
            streams[f"TEXCOORD_{len(layers)}"] = found * [1, -1] + [0, 1]
            layers.append(primvar.GetPrimvarName())
    colors = api.GetPrimvar("displayColor")
    is_bound = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]
    if colors and colors.HasValue() and (source.by_us or not is_bound):
        found = spread(colors.ComputeFlattened(source.first), colors.GetInterpolation(), 3)
        if found is not None:
            streams["COLOR_0"] = np.clip(found, 0, 1)
    return streams, layers


def _subsets(prim, mesh, source, faces):
    """Materials, and a mask of the faces that have each; None for all."""
    own = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]
    left = np.ones(faces, bool)
    subsets = UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets()
    if not subsets:
        yield (own.GetPrim() if own else None), None
        return
    for subset in subsets:
        chosen = np.array(_value(subset.GetIndicesAttr(), source, []), np.int64)
        if len(chosen) and (chosen.min() < 0 or chosen.max() >= faces):
            raise SceneError(f"{subset.GetPath()}: indices go from {chosen.min()} to {chosen.max()}, of {faces} faces")
        mask = np.zeros(faces, bool)
        mask[chosen] = True
        left &= ~mask
        material = UsdShade.MaterialBindingAPI(subset).ComputeBoundMaterial()[0]
        yield (material.GetPrim() if material else None), mask
    yield (own.GetPrim() if own else None), left


def _part(points, corners, triangles, streams, layers, material) -> Shape:
    """One material's triangles, with a row for each different corner."""
    places = triangles[:, :3].ravel()
    columns = [corners[places][:, None].astype(float)] + [values[places] for values in streams.values()]
    _, first, number = np.unique(np.column_stack(columns), axis=0, return_index=True, return_inverse=True)
    kept = places[first]
    attributes = {"POSITION": points[corners[kept]], **{name: values[kept] for name, values in streams.items()}}
    return Shape(attributes, number.reshape(-1, 3), corners[kept], material, layers)


def _bend(prim: Usd.Prim, attribute: Usd.Attribute, codes: np.ndarray, rest: np.ndarray) -> Bend | None:
    """Principal components of the points' movement: as few targets as give every vertex at every code (Alexa and Mueller 2000)."""
    if len(codes) * rest.size * 8 > MOST_BYTES:
        raise SceneError(f"{prim.GetPath()}: {len(rest)} points that change over {len(codes)} frames are too many")
    moved = np.empty((len(codes), rest.size))
    for row, code in enumerate(codes.tolist()):
        points = _points(prim, attribute, code)
        if len(points) != len(rest):
            raise SceneError(f"{prim.GetPath()}: has {len(rest)} points at first and {len(points)} at time code {code:g}")
        moved[row] = (points - rest).ravel()
    bar = SMALLEST * max(float(np.ptp(rest, axis=0).max()), 1e-9)
    if np.abs(moved).max() <= bar:
        return None
    # Of the small matrix of codes with codes.
    squares, turns = np.linalg.eigh(moved @ moved.T)
    order = np.argsort(-squares)
    targets, weights, left = [], [], moved.copy()
    for number in order:
        if np.abs(left).max() <= bar:
            break
        weight = turns[:, number]
        target = weight @ moved
        # Weights of about 1.
        largest = np.abs(weight).max()
        targets.append((target * largest).reshape(-1, 3))
        weights.append(weight / largest)
        left -= np.outer(weight, target)
    return Bend(codes, targets, np.stack(weights, axis=1))
