"""Meshes as subdivision surfaces. In go faces and attributes of subdivision, out come refined faces and
values.

Invariant: equal cages are refined once.
"""

from functools import cached_property
from typing import NoReturn

import numpy as np
from pxr import Usd, UsdGeom

from ...errors import SceneError
from .faces import Faces, rows_of, value_of
from .primvars import Stream
from .rows import different_rows
from .subdivision import Cage, Refinement, refined

LEVELS = 2
MOST_REFINED = 2**21
"""Faces of a stage after refining: a quarter of a gigabyte of a file, and half a minute."""
MOST_OF_ONE = 2**19
"""Faces of a mesh after refining: they take most memory while they are numbered, half a gigabyte."""
MOST_KEPT = 200_000
"""Maximum corners of cages whose levels are cached."""
WORDS = (
    "subdivisionScheme",
    "faceVaryingLinearInterpolation",
    "interpolateBoundary",
    "triangleSubdivisionRule",
)
SHARP = {"creaseLengths", "creaseIndices", "creaseSharpnesses", "cornerIndices", "cornerSharpnesses"}
"""Attributes of subdivision."""
MOST_SUBDIVIDED, MOST_SHARED = 32, 2048
"""Number of cached refined meshes, and maximum corners of each."""
SEAM_RULES = ("none", "cornersOnly", "cornersPlus1", "cornersPlus2", "boundaries", "all")


class Subdivided:
    """Refined faces of a mesh, and the refinement of its values."""

    def __init__(self, prim: Usd.Prim, faces: Faces, points: int, code: float, refiner: "Refiner"):
        self.refiner = refiner
        mesh = UsdGeom.Mesh(prim)
        self.scheme = str(value_of(mesh.GetSubdivisionSchemeAttr(), code, "catmullClark"))
        self.seams = str(value_of(mesh.GetFaceVaryingLinearInterpolationAttr(), code, "cornersPlus1"))
        whole = np.nonzero(faces.counts >= 3)[0]
        kept = np.repeat(faces.counts >= 3, faces.counts)
        self.kept = kept
        cage = _cage(prim, mesh, faces.counts[whole], faces.corners[kept], points, code)
        boundary = str(value_of(mesh.GetInterpolateBoundaryAttr(), code, "edgeAndCorner"))
        holes = np.isin(whole, faces.holes)
        if self.scheme == "bilinear":
            cage = cage.with_sharp_vertices(np.ones(points, bool))
        elif boundary == "edgeAndCorner":
            cage = cage.with_sharp_vertices(cage.faces_at_vertex == 1)
        elif boundary == "none":
            at_boundary = np.zeros(points, bool)
            at_boundary[cage.edges.ends[cage.edges.faces == 1]] = True
            holes = holes | np.logical_or.reduceat(at_boundary[cage.corners], cage.starts)
        self.cage, self.levels = cage, refiner.levels(cage, self.scheme == "bilinear")
        parents = np.arange(len(whole))
        for level in self.levels:
            parents = parents[level.parents]
        self.parents = whole[parents]
        finest = self.cage_of_faces = self.levels[-1].finer
        self.faces = Faces(finest.counts, finest.corners, np.nonzero(holes[parents])[0], faces.flips)

    @cached_property
    def triangles(self) -> np.ndarray:
        """Triangles of the refined faces, as of `triangulate`; any diagonal is good enough."""
        sides = int(self.faces.counts[0])
        places = np.arange(len(self.faces.corners)).reshape(-1, sides)
        fans = np.stack([places[:, [0, step, step + 1]] for step in range(1, sides - 1)], axis=1).reshape(
            -1, 3
        )
        return np.column_stack([fans, np.repeat(np.arange(len(places)), sides - 2)])

    def points(self, values: np.ndarray) -> np.ndarray:
        """Refined values of points (rows)."""
        for level in self.levels:
            values = level.smooth(values)
        return values

    def stream(self, stream: Stream) -> Stream:
        """Primvar refined by its interpolation."""
        values, interpolation = stream.values, stream.interpolation
        if interpolation == "vertex":
            values = self.points(values[: self.cage.vertices])
        elif interpolation == "varying":
            values = values[: self.cage.vertices]
            for level in self.levels:
                values = level.linear(values)
        elif interpolation == "uniform":
            values = values[self.parents]
        elif interpolation == "faceVarying":
            values = self._face_varying(values[: len(self.kept)][self.kept])
        return Stream(stream.name, values, interpolation)

    def _face_varying(self, values: np.ndarray) -> np.ndarray:
        """Values by corner: equal corners are vertices of a separate surface. The mesh's rule decides
        where its seams are sharp."""
        cage = self.cage
        first, ids = different_rows(np.column_stack([cage.corners, values]))
        sharpness = cage.edges.sharpness[cage.edges.of_corner]
        sharp = np.nonzero((sharpness > 0) & (cage.edges.faces[cage.edges.of_corner] > 1))[0]
        ends = np.stack([ids[sharp], ids[cage.next_corner[sharp]]], axis=1)
        own = cage.vertex_sharpness[cage.corners[first]]
        channel = Cage(cage.counts, ids, ends, sharpness[sharp], own, cage.is_loop, cage.smooth_triangles)
        channel = channel.with_sharp_vertices(self._sharp_at_seams(channel, cage.corners[first]))
        rows = values[first]
        levels = self.refiner.levels(channel, self.scheme == "bilinear")
        for level in levels:
            rows = level.linear(rows) if self.seams == "all" else level.smooth(rows)
        return rows[levels[-1].finer.corners]

    def _sharp_at_seams(self, channel: Cage, points: np.ndarray) -> np.ndarray:
        """Vertices of a channel that stay sharp; `points` are those of the mesh."""
        at_boundary = np.zeros(channel.vertices, bool)
        at_boundary[channel.edges.ends[channel.edges.faces == 1]] = True
        rule = SEAM_RULES.index(self.seams) if self.seams in SEAM_RULES else 2
        if rule >= SEAM_RULES.index("boundaries"):
            return at_boundary
        values_at_point = np.bincount(points, minlength=self.cage.vertices)
        corner = channel.faces_at_vertex == 1
        sharp = corner & (rule >= 1)
        if rule >= 2:
            sharp |= values_at_point[points] >= 3
        if rule >= 3:
            # Ends of seams inside the mesh, and the opposite sides of corners.
            edges = self.cage.edges
            is_split = np.bincount(edges.of_corner, _differs(self.cage, channel), len(edges.ends)) > 0
            splits = np.bincount(edges.ends.ravel(), np.repeat(is_split, 2), self.cage.vertices)
            dart = (splits == 1) & (values_at_point == 1)
            has_corner = np.bincount(points, corner, self.cage.vertices) > 0
            sharp |= dart[points] | (has_corner[points] & at_boundary)
        return sharp


def _differs(cage: Cage, channel: Cage) -> np.ndarray:
    """For each corner, whether its edge has two faces in the mesh and one in the channel."""
    whole = cage.edges.faces[cage.edges.of_corner] > 1
    return (whole & (channel.edges.faces[channel.edges.of_corner] == 1)).astype(float)


class Refiner:
    """Refines cages, each different one once, to one depth for a whole stage."""

    def __init__(self, levels: int):
        self.depth = levels
        self._known: dict[bytes, list[Refinement]] = {}
        self._size = 0
        self._subdivided: dict[tuple, Subdivided] = {}

    def subdivided(
        self, prim: Usd.Prim, faces: Faces, points: int, code: float, authored: frozenset[str]
    ) -> Subdivided:
        """Refined faces of a mesh, shared by meshes with equal faces and attributes. Raises `SceneError`."""
        if authored & SHARP or len(faces.corners) > MOST_SHARED:
            return Subdivided(prim, faces, points, code, self)
        words = ((name, str(value_of(prim.GetAttribute(name), code))) for name in WORDS if name in authored)
        key = (faces, points, *words)
        if key not in self._subdivided:
            found = Subdivided(prim, faces, points, code, self)
            if len(self._subdivided) >= MOST_SUBDIVIDED:
                self._subdivided.clear()
            self._subdivided[key] = found
        return self._subdivided[key]

    def levels(self, cage: Cage, is_bilinear: bool) -> list[Refinement]:
        """Refinement levels of a cage."""
        if is_bilinear:
            cage = cage.with_sharp_vertices(np.ones(cage.vertices, bool))
            ends = cage.edges.ends
            endless = np.full(len(ends), np.inf)
            cage = Cage(cage.counts, cage.corners, ends, endless, cage.vertex_sharpness)
        arrays = (cage.counts, cage.corners, cage.crease_ends, cage.crease_sharpness, cage.vertex_sharpness)
        key = b"|".join(array.tobytes() for array in arrays) + bytes([cage.is_loop, cage.smooth_triangles])
        if key not in self._known:
            found = refined(cage, self.depth)
            self._size += len(cage.corners)
            if self._size > MOST_KEPT:
                self._known.clear()
                self._size = len(cage.corners)
            self._known[key] = found
        return self._known[key]


def depth_of(faces: int, largest: int) -> int:
    """Maximum number of levels for cages with `faces` faces together, of which the largest has `largest`."""
    for depth in range(LEVELS, 0, -1):
        if faces * 4**depth <= MOST_REFINED and largest * 4**depth <= MOST_OF_ONE:
            return depth
    return 0


def _cage(
    prim: Usd.Prim, mesh: UsdGeom.Mesh, counts: np.ndarray, corners: np.ndarray, points: int, code: float
) -> Cage:
    """Faces of a mesh with creases and corners. Raises `SceneError`."""
    def refuse(what: str) -> NoReturn:
        raise SceneError(f"{prim.GetPath()}: {what}")

    scheme = value_of(mesh.GetSubdivisionSchemeAttr(), code)
    if scheme == UsdGeom.Tokens.loop and (counts != 3).any():
        refuse("the scheme `loop` is one of triangles, and it has faces of other counts")
    lengths = rows_of(mesh.GetCreaseLengthsAttr(), code, 1, np.int64).ravel()
    chain = rows_of(mesh.GetCreaseIndicesAttr(), code, 1, np.int64).ravel()
    sharpness = rows_of(mesh.GetCreaseSharpnessesAttr(), code, 1).ravel()
    ends, crease = np.zeros((0, 2), np.int64), np.zeros(0)
    if len(lengths):
        if (lengths < 2).any() or lengths.sum() != len(chain):
            refuse(f"creaseLengths ask for {lengths.sum()} points, creaseIndices have {len(chain)}")
        last = np.zeros(len(chain), bool)
        last[np.cumsum(lengths) - 1] = True
        ends = np.stack([chain[:-1], chain[1:]], axis=1)[~last[:-1]]
        if len(sharpness) == len(lengths):
            crease = np.repeat(sharpness, lengths - 1)
        elif len(sharpness) == len(ends):
            crease = sharpness
        else:
            refuse(f"has {len(lengths)} creases and {len(sharpness)} creaseSharpnesses")
    tips = rows_of(mesh.GetCornerIndicesAttr(), code, 1, np.int64).ravel()
    tip_sharpness = rows_of(mesh.GetCornerSharpnessesAttr(), code, 1).ravel()
    if len(tips) != len(tip_sharpness):
        refuse(f"has {len(tips)} cornerIndices and {len(tip_sharpness)} cornerSharpnesses")
    for name, indices in (("creaseIndices", ends), ("cornerIndices", tips)):
        if indices.size and (indices.min() < 0 or indices.max() >= points):
            refuse(f"{name} go from {indices.min()} to {indices.max()}, of {points} points")
    at_vertex = np.zeros(points)
    at_vertex[tips] = np.where(np.isnan(tip_sharpness), 0.0, tip_sharpness)
    rule = value_of(mesh.GetTriangleSubdivisionRuleAttr(), code)
    is_loop = scheme == UsdGeom.Tokens.loop
    sharp = np.where(np.isnan(crease), 0.0, crease)
    return Cage(counts, corners, ends, sharp, at_vertex, is_loop, rule == UsdGeom.Tokens.smooth)
