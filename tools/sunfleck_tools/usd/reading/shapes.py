"""Primitives of glTF from meshes and solids of a stage. Invariant: every index is checked before use."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from pxr import Usd, UsdGeom

from ...errors import SceneError
from .bends import Bend, normal_targets, read_bend
from .bindings import Bound, path_of
from .cages import LEVELS, Refiner, Subdivided, depth_of
from .changes import say_if_it_changes
from .colors import shows_colors, vertex_colors
from .faces import Faces, read_faces, read_points, rows_of, value_of
from .losses import Losses
from .normals import smooth_normals
from .primvars import Primvars, Stream
from .rows import different_numbers, different_rows
from .solids import SOLIDS, read_solid
from .source import Source
from .spans import Span
from .triangles import are_convex, triangulate


@dataclass
class Shape:
    """Triangles of one material: rows of attributes, and for deforming meshes the point of each row."""

    attributes: dict[str, np.ndarray]
    triangles: np.ndarray
    point_of_row: np.ndarray
    material: Usd.Prim | None
    layers: list[str]
    glow: tuple[float, float, float] | None = None
    """Radiance of a mesh that is a light."""
    corner_of_row: np.ndarray | None = None
    takes_tint: bool = False
    """Whether an instance's colour is used."""
    normal_targets: np.ndarray | None = None
    """Displacements of each row's normal, for the weights of a deforming mesh."""


@dataclass
class Shapes:
    """Shapes of a mesh."""

    parts: list[Shape] = field(default_factory=list)
    bend: Bend | None = None


@dataclass
class _Outline:
    """Points and faces of a prim, its points at any code, refined faces of a subdivision surface, and
    attributes by corner."""

    points: np.ndarray
    faces: Faces
    points_at: Callable[[float], np.ndarray]
    normals_at: Callable[[float], np.ndarray | None] = lambda _: None
    finer: Subdivided | None = None
    finer_points: np.ndarray | None = None
    rows: dict[str, np.ndarray] = field(default_factory=dict)
    layers: list[str] = field(default_factory=list)
    is_by_point: bool = True
    """Whether all corners at a point have the same attributes."""

    def spread(self, stream: Stream | None) -> np.ndarray | None:
        """A row for each corner of the faces."""
        self.is_by_point &= stream is None or stream.is_by_point
        if stream is None or self.finer is None:
            return None if stream is None else stream.rows(self.faces)
        return self.finer.stream(stream).rows(self.finer.faces)


Masked = tuple[Usd.Prim | None, np.ndarray | None]
"""Material and a mask of its faces; None for all."""


def is_shape(prim: Usd.Prim) -> bool:
    """True for prims with supported faces."""
    return prim.IsA(UsdGeom.Mesh) or prim.GetTypeName() in SOLIDS


class ShapeReader:
    """Reads the shapes of a stage."""

    def __init__(self, source: Source, lost: Losses):
        self.source, self.lost = source, lost
        self._refiner: Refiner | None = None
        self._shows: dict[str, bool] = {}

    def read(self, prim: Usd.Prim, bound: Bound, span: Span) -> Shapes:
        """Shapes of a prim during a span of constant faces. Raises `SceneError`."""
        outline = self._mesh(prim, span) if prim.IsA(UsdGeom.Mesh) else _solid(prim, span.rests_at)
        normals = outline.normals_at(span.rests_at)
        if normals is not None:
            outline.rows["NORMAL"] = normals
        masks = _masks(bound, outline.faces.count, span.rests_at, self.lost)
        colored = [material for material, _ in masks if self._shows_colors(material)]
        if colored:
            self._color(prim, colored[0], outline, span.rests_at)
        shapes = Shapes(_parts(prim, masks, outline))
        for subset, _ in bound.subsets:
            say_if_it_changes(UsdGeom.Subset(subset).GetIndicesAttr(), self.source, self.lost, "list of faces")
        for part in shapes.parts:
            is_colored = self._shows_colors(part.material)
            if not is_colored:
                part.attributes.pop("COLOR_0", None)
            part.takes_tint = is_colored and "COLOR_0" not in part.attributes
        if len(span.codes) > 1 and shapes.parts:
            shapes.bend = read_bend(prim.GetPath(), outline.points_at, span.codes, outline.points)
        if prim.IsA(UsdGeom.Mesh) and span.points_at is None:
            primvars = Primvars(prim, span.rests_at, outline.faces, self.source, self.lost)
            primvars.say_what_changes(self.source, shapes.bend is not None or outline.finer is not None or not span.is_always)
        if shapes.bend is not None and normals is not None:
            targets = normal_targets(outline.normals_at, shapes.bend, normals)
            for part in shapes.parts:
                part.normal_targets = targets[:, part.corner_of_row] if targets is not None else None
        if shapes.bend is not None and outline.finer is not None:
            shapes.bend.targets = [outline.finer.points(target) for target in shapes.bend.targets]
        return shapes

    def _shows_colors(self, material: Usd.Prim | None) -> bool:
        looks = path_of(material)
        if looks not in self._shows:
            self._shows[looks] = shows_colors(material, self.source)
        return self._shows[looks]

    def _mesh(self, prim: Usd.Prim, span: Span) -> _Outline:
        code = span.rests_at
        points_at = span.points_at or partial(read_points, prim)
        points = points_at(code)
        faces = read_faces(prim, code, len(points), self.source.authored(prim))
        outline = _Outline(points, faces, points_at)
        refiner = self._refines(prim, faces, code)
        if refiner is not None:
            authored = self.source.authored(prim)
            outline.finer = refiner.subdivided(prim, faces, len(points), code, authored)
            outline.finer_points = outline.finer.points(points)
        primvars = Primvars(prim, code, faces, self.source, self.lost)
        streams, outline.layers = primvars.coordinates()
        for each in streams:
            rows = outline.spread(each)
            assert rows is not None
            outline.rows[each.name] = rows
        finer, refined = outline.finer, outline.finer_points
        if finer is not None and refined is not None:
            outline.is_by_point = False
            finest = finer.cage_of_faces
            outline.normals_at = lambda at: smooth_normals(
                finest, refined if at == code else finer.points(points_at(at))
            )
        else:
            outline.normals_at = lambda at: outline.spread(
                Primvars(prim, at, faces, self.source, self.lost).normals()
            )
        return outline

    def _color(self, prim: Usd.Prim, material: Usd.Prim | None, outline: _Outline, code: float) -> None:
        primvars = Primvars(prim, code, outline.faces, self.source, self.lost)

        def spread(values: object, interpolation: str, width: int) -> np.ndarray | None:
            # Faces of solids are this program's own.
            fits = prim.IsA(UsdGeom.Mesh) or interpolation == "constant"
            return outline.spread(primvars.fit("COLOR_0", values, interpolation, width)) if fits else None

        colors = vertex_colors(prim, material, code, self.lost, spread)
        if colors is not None:
            outline.rows["COLOR_0"] = colors

    def _refines(self, prim: Usd.Prim, faces: Faces, code: float) -> Refiner | None:
        """Refiner of a subdivision surface; None for other meshes, and if no level fits."""
        scheme = value_of(prim.GetAttribute("subdivisionScheme"), code)
        if scheme == UsdGeom.Tokens.none or not (faces.counts >= 3).any():
            return None
        if self._refiner is None:
            self._refiner = Refiner(depth_of(*_cage_faces(self.source)))
        if self._refiner.depth < LEVELS:
            what = "is refined once" if self._refiner.depth else "is not refined"
            said = f"{what}: the stage's subdivision surfaces have too many faces for two levels"
            self.lost.add("usd-subdivision", prim, said)
        return self._refiner if self._refiner.depth > 0 else None


def _parts(prim: Usd.Prim, masks: list[Masked], outline: _Outline) -> list[Shape]:
    """Triangles by material. Raises `SceneError`."""
    finer = outline.finer
    if finer is not None and outline.finer_points is not None:
        points, faces, triangles = outline.finer_points, finer.faces, finer.triangles
    else:
        points, faces = outline.points, outline.faces
        triangles = _triangles(prim, points, faces)
    if faces.flips:
        triangles = triangles[:, [0, 2, 1, 3]]
    if len(faces.holes):
        triangles = triangles[~np.isin(triangles[:, 3], faces.holes)]
    found = []
    for material, mask in masks:
        if mask is not None:
            chosen = triangles[(mask if finer is None else mask[finer.parents])[triangles[:, 3]]]
        else:
            chosen = triangles
        if len(chosen):
            found.append(_part(points, faces, chosen, outline, material))
    return found


def _triangles(prim: Usd.Prim, points: np.ndarray, faces: Faces) -> np.ndarray:
    """Triangles of faces, as of `triangulate`. Raises `SceneError`."""
    if faces.loops is not None and are_convex(points, faces.loops):
        return faces.fans
    try:
        return triangulate(faces.counts, points, faces.corners)
    except ValueError as error:
        raise SceneError(f"{prim.GetPath()}: {error}") from None


def _solid(prim: Usd.Prim, code: float) -> _Outline:
    solid = read_solid(prim, code)
    outline = _Outline(
        solid.points,
        solid.faces,
        lambda at: read_solid(prim, at).points,
        lambda at: read_solid(prim, at).normals,
    )
    outline.is_by_point = False
    return outline


def _cage_faces(source: Source) -> tuple[int, int]:
    """Faces of all subdivision surfaces of a stage, and of the largest."""
    found = [0]
    for root in (source.stage.GetPseudoRoot(), *source.stage.GetPrototypes()):
        for prim in Usd.PrimRange(root):
            if prim.IsA(UsdGeom.Mesh):
                mesh = UsdGeom.Mesh(prim)
                if value_of(mesh.GetSubdivisionSchemeAttr(), source.first) != UsdGeom.Tokens.none:
                    found.append(len(value_of(mesh.GetFaceVertexCountsAttr(), source.first, ())))
    return sum(found), max(found)


def _masks(bound: Bound, faces: int, code: float, lost: Losses) -> list[Masked]:
    """Materials of faces, with masks."""
    if not bound.subsets:
        return [(bound.material, None)]
    found, left = [], np.ones(faces, bool)
    for subset, material in bound.subsets:
        chosen = rows_of(UsdGeom.Subset(subset).GetIndicesAttr(), code, 1, np.int64).ravel()
        if len(chosen) and (chosen.min() < 0 or chosen.max() >= faces):
            raise SceneError(
                f"{subset.GetPath()}: indices go from {chosen.min()} to {chosen.max()}, of {faces} faces"
            )
        mask = np.zeros(faces, bool)
        mask[chosen] = True
        if (mask & ~left).any():
            lost.add("usd-primvar", subset, "has faces of a subset before it, whose material they keep")
        mask &= left
        left &= ~mask
        found.append((material, mask))
    return [each for each in (*found, (bound.material, left)) if each[1].any()]


def _part(
    points: np.ndarray,
    faces: Faces,
    triangles: np.ndarray,
    outline: _Outline,
    material: Usd.Prim | None,
) -> Shape:
    """Triangles of one material, with a row for each unique corner."""
    if outline.is_by_point and faces.loops is not None and triangles is faces.fans:
        kept, triangles_of_rows = faces.welded
    else:
        kept, triangles_of_rows = _welded(len(points), faces.corners, triangles, outline)
    point_of_row = faces.corners[kept]
    attributes = {
        "POSITION": points[point_of_row],
        **{name: values[kept] for name, values in outline.rows.items()},
    }
    return Shape(
        attributes, triangles_of_rows, point_of_row, material, outline.layers, corner_of_row=kept
    )


def _welded(
    points: int, corners: np.ndarray, triangles: np.ndarray, outline: _Outline
) -> tuple[np.ndarray, np.ndarray]:
    """Corner of each row, and triangles of rows: equal corners share one."""
    is_used = np.zeros(len(corners), bool)
    is_used[triangles[:, :3]] = True
    used = np.nonzero(is_used)[0]
    if outline.is_by_point:
        first, number = different_numbers(corners[used], points)
    else:
        rows = [corners[used], *(values[used] for values in outline.rows.values())]
        first, number = different_rows(np.column_stack(rows).astype(float))
    row_of_corner = np.zeros(len(corners), np.int64)
    row_of_corner[used] = number
    return used[first], row_of_corner[triangles[:, :3]]
