"""Meshes and solids of a stage to primitives of glTF. Invariant: no index is used that was not checked."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from pxr import Usd, UsdGeom

from ...errors import SceneError
from .bends import Bend, read_bend
from .bindings import Bound
from .cages import LEVELS, Refiner, Subdivided, depth_of, smooth_normals
from .faces import Faces, read_faces, read_points, rows_of, value_of
from .losses import Losses
from .primvars import Primvars, Stream
from .solids import SOLIDS, read_solid
from .source import Source
from .spans import Span
from .triangles import triangulate


@dataclass
class Shape:
    """Triangles of one material: rows of attributes, and for what bends which point each row is."""

    attributes: dict[str, np.ndarray]
    triangles: np.ndarray
    point_of_row: np.ndarray
    material: Usd.Prim | None
    layers: list[str]


@dataclass
class Shapes:
    """A mesh of a stage."""

    parts: list[Shape] = field(default_factory=list)
    bend: Bend | None = None


@dataclass
class _Outline:
    """A prim's points and faces, what belongs to its corners, its faces' subsets, and its points at any code."""

    points: np.ndarray
    faces: Faces
    streams: list[Stream]
    layers: list[str]
    masks: list[tuple[Usd.Prim | None, np.ndarray | None]]
    points_at: Callable[[float], np.ndarray]
    normals: np.ndarray | None = None
    refine: Callable[[np.ndarray], np.ndarray] | None = None


def is_shape(prim: Usd.Prim) -> bool:
    """True for what has faces here."""
    return prim.IsA(UsdGeom.Mesh) or prim.GetTypeName() in SOLIDS


class ShapeReader:
    """Reads the shapes of a stage."""

    def __init__(self, source: Source, lost: Losses):
        self.source, self.lost = source, lost
        self._refiner: Refiner | None = None

    def read(self, prim: Usd.Prim, bound: Bound, span: Span) -> Shapes:
        """A shape for as long as its faces are the same. Raises `SceneError`."""
        codes, rests_at = span.codes, span.rests_at
        outline = self._mesh(prim, bound, span) if prim.IsA(UsdGeom.Mesh) else self._solid(prim, bound, rests_at)
        try:
            triangles = triangulate(outline.faces.counts, outline.points, outline.faces.corners)
        except ValueError as error:
            raise SceneError(f"{prim.GetPath()}: {error}") from None
        if outline.faces.flips:
            triangles = triangles[:, [0, 2, 1, 3]]
        triangles = triangles[~np.isin(triangles[:, 3], outline.faces.holes)]
        streams = {each.name: each.rows(outline.faces) for each in outline.streams}
        if outline.normals is not None and len(codes) == 1:
            streams["NORMAL"] = outline.normals
        shapes = Shapes()
        for material, mask in outline.masks:
            chosen = triangles if mask is None else triangles[mask[triangles[:, 3]]]
            if len(chosen):
                shapes.parts.append(_part(outline, chosen, streams, material))
        if len(codes) > 1 and shapes.parts:
            rest = outline.points_at(rests_at)
            shapes.bend = read_bend(prim.GetPath(), outline.points_at, codes, rest)
            if shapes.bend is not None and outline.refine is not None:
                shapes.bend.targets = [outline.refine(target) for target in shapes.bend.targets]
        return shapes

    def _solid(self, prim: Usd.Prim, bound: Bound, code: float) -> _Outline:
        solid = read_solid(prim, code)
        streams = self._colors(bound, Primvars(prim, code, solid.faces, self.lost))
        return _Outline(
            solid.points, solid.faces, [each for each in streams if each.interpolation == "constant"], [], [(bound.material, None)],
            lambda at: read_solid(prim, at).points, solid.normals,
        )  # fmt: skip

    def _mesh(self, prim: Usd.Prim, bound: Bound, span: Span) -> _Outline:
        code, moves = span.rests_at, len(span.codes) > 1
        points = read_points(prim, code)
        faces = read_faces(prim, code, len(points))
        primvars = Primvars(prim, code, faces, self.lost)
        streams, layers = primvars.coordinates()
        streams += self._colors(bound, primvars)
        outline = _Outline(points, faces, streams, layers, _masks(bound, faces.count, code), span.points_at or partial(read_points, prim))
        if self._is_refined(prim, faces, code):
            self._refine(prim, outline, code, moves)
        elif not moves:
            normals = primvars.normals()
            outline.streams += [normals] if normals is not None else []
        return outline

    def _colors(self, bound: Bound, primvars: Primvars) -> list[Stream]:
        """Colours of the mesh, which a material has its own of."""
        if not self.source.by_us and bound.material is not None:
            return []
        colors = primvars.colors()
        return [colors] if colors is not None else []

    def _is_refined(self, prim: Usd.Prim, faces: Faces, code: float) -> bool:
        scheme = value_of(UsdGeom.Mesh(prim).GetSubdivisionSchemeAttr(), code)
        if scheme == UsdGeom.Tokens.none or not (faces.counts >= 3).any():
            return False
        if self._refiner is None:
            self._refiner = Refiner(depth_of(_cage_faces(self.source)))
        if self._refiner.depth < LEVELS:
            what = "is refined once" if self._refiner.depth else "is not refined"
            self.lost.add("usd-subdivision", prim.GetPath(), f"{what}: the stage's subdivision surfaces have too many faces for two levels")
        return self._refiner.depth > 0

    def _refine(self, prim: Usd.Prim, outline: _Outline, code: float, moves: bool) -> None:
        finer = Subdivided(prim, outline.faces, len(outline.points), code, self._refiner)
        outline.streams = [finer.stream(stream) for stream in outline.streams]
        outline.masks = [(material, None if mask is None else mask[finer.parents]) for material, mask in outline.masks]
        outline.points, outline.faces, outline.refine = finer.points(outline.points), finer.faces, finer.points
        if not moves:
            outline.normals = smooth_normals(finer.levels[-1].finer, outline.points)


def _cage_faces(source: Source) -> int:
    """Faces of all subdivision surfaces of a stage."""
    total = 0
    for root in (source.stage.GetPseudoRoot(), *source.stage.GetPrototypes()):
        for prim in Usd.PrimRange(root):
            if prim.IsA(UsdGeom.Mesh):
                mesh = UsdGeom.Mesh(prim)
                if value_of(mesh.GetSubdivisionSchemeAttr(), source.first) != UsdGeom.Tokens.none:
                    total += len(value_of(mesh.GetFaceVertexCountsAttr(), source.first, ()))
    return total


def _masks(bound: Bound, faces: int, code: float) -> list[tuple[Usd.Prim | None, np.ndarray | None]]:
    """Materials, and a mask of the faces that have each; None for all."""
    if not bound.subsets:
        return [(bound.material, None)]
    found, left = [], np.ones(faces, bool)
    for subset, material in bound.subsets:
        chosen = rows_of(UsdGeom.Subset(subset).GetIndicesAttr(), code, 1, np.int64).ravel()
        if len(chosen) and (chosen.min() < 0 or chosen.max() >= faces):
            raise SceneError(f"{subset.GetPath()}: indices go from {chosen.min()} to {chosen.max()}, of {faces} faces")
        mask = np.zeros(faces, bool)
        mask[chosen] = True
        left &= ~mask
        found.append((material, mask))
    return [*found, (bound.material, left)]


def _part(outline: _Outline, triangles: np.ndarray, streams: dict[str, np.ndarray], material: Usd.Prim | None) -> Shape:
    """One material's triangles, with a row for each different corner."""
    corners = outline.faces.corners
    places = triangles[:, :3].ravel()
    columns = [corners[places][:, None].astype(float)] + [values[places] for values in streams.values()]
    first, number = _different(np.column_stack(columns))
    kept = places[first]
    attributes = {"POSITION": outline.points[corners[kept]], **{name: values[kept] for name, values in streams.items()}}
    return Shape(attributes, number.reshape(-1, 3), corners[kept], material, outline.layers)


def _different(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The first place of each different row, and for each row which of those it is."""
    bits = np.ascontiguousarray(rows + 0.0).view(np.uint64)
    mixed = np.zeros(len(rows), np.uint64)
    for column in bits.T:
        # Multiplied by the fraction of the golden ratio; to fold the high bits down makes them count (Knuth 6.4).
        mixed = (mixed ^ column) * np.uint64(0x9E3779B97F4A7C15)
        mixed ^= mixed >> np.uint64(29)
    _, first, number = np.unique(mixed, return_index=True, return_inverse=True)
    if (rows[first[number]] == rows).all():
        return first, number
    _, first, number = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    return first, number.ravel()
