"""Evaluated meshes as arrays, identified by their contents.

In go Blender's meshes, out comes a `Geometry`. Invariant: two with the same `topology` have the same
triangles, corners, texture coordinates, colours and material slots, and may differ in where their vertices
are; two with the same `shape` too do not differ.
"""

import hashlib
from dataclasses import dataclass, field, replace

import numpy

from .attributes import NO_GROUPS, numbers, of_corners, uv_of_corners
from .heeding import heeding, nobody

# Name of the texture coordinates made for baking.
ATLAS = "sunfleck bake"
# Name of texture coordinates in place of missing render ones.
NONE_RENDERS = "sunfleck none renders"
# Distance of the two sides of a mesh from its middle, relative to its extent.
SIDES_APART = 3e-5


@dataclass
class Geometry:
    """Corners are Blender's loops; all in Blender's axes."""

    name: str
    positions: numpy.ndarray
    corner_vertices: numpy.ndarray
    triangles: numpy.ndarray
    slots: numpy.ndarray
    # "FACE", "POINT" or "CORNER": domain of the normals, one a face, vertex or corner; none for faces.
    normals_of: str
    normals: numpy.ndarray
    uvs: dict = field(default_factory=dict)
    # One to four numbers a corner.
    colors: dict = field(default_factory=dict)
    topology: bytes = b""
    shape: bytes = b""
    # Scale of the first object that shows it.
    size: float = 1.0

    def known_by(self):
        return self.topology + self.shape

    def fingerprint(self):
        """Computes its keys."""
        of_corners = [self.corner_vertices, self.triangles, self.slots]
        widths = {name: values.shape[1] for name, values in self.colors.items()}
        names = repr((len(self.positions), self.normals_of, list(self.uvs), widths))
        self.topology = digest(names.encode(), *of_corners, *self.uvs.values(), *self.colors.values())
        self.shape = digest(self.positions, self.normals)
        return self

    def coarseness(self):
        """Angle between shading and face normals: root mean square over the area, in radians."""
        if self.normals_of == "FACE":
            return 0.0
        vertices = self.corner_vertices[self.triangles]
        corners = self.positions[vertices].astype(float)
        faces = numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        areas = numpy.linalg.norm(faces, axis=1)
        normals = self.normals[self.triangles if self.normals_of == "CORNER" else vertices]
        cosines = numpy.einsum("tci,ti->tc", normals, faces).mean(axis=1)
        return float(numpy.sqrt(max(0.0, 2.0 * (1.0 - cosines.sum() / max(areas.sum(), 1e-30)))))

    def uv(self, name):
        """Texture coordinates of a name, without one those that render; None if there are none."""
        return self.uvs.get(name) if name else next(iter(self.uvs.values()), None)

    def sides_m(self, uv):
        """Mean length and height of a unit of texture coordinates, to two digits."""
        uvs = self.uv(uv)
        if uvs is None or not len(self.triangles):
            return 1.0, 1.0
        corners, places = self.positions[self.corner_vertices[self.triangles]], uvs[self.triangles]
        x, y = (places[:, at] - places[:, 0] for at in (1, 2))
        a, b = (corners[:, at] - corners[:, 0] for at in (1, 2))
        # For each triangle, twice its area in texture space, times the positions a unit apart.
        areas = x[:, 0] * y[:, 1] - y[:, 0] * x[:, 1]
        along, up = a * y[:, 1:] - b * x[:, 1:], b * x[:, :1] - a * y[:, :1]
        whole = max(float(numpy.abs(areas).sum()), 1e-30)
        lengths = (self.size * float(numpy.linalg.norm(rows, axis=1).sum()) / whole for rows in (along, up))
        return tuple(float(f"{min(max(length, 1e-6), 1e6):.2g}") for length in lengths)

    def drifted(self, velocities, seconds):
        """Geometry after some seconds; velocities are by corner."""
        positions = self.positions.copy()
        positions[self.corner_vertices] += numpy.float32(seconds) * velocities
        return replace(self, positions=positions).fingerprint()

    def sided(self, slots):
        """Geometry doubled into two sides slightly apart: front faces, and back faces in additional slots."""
        corners = self.positions[self.corner_vertices[self.triangles]].astype(float)
        of_faces = numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        forwards = numpy.zeros(self.positions.shape)
        numpy.add.at(forwards, self.corner_vertices[self.triangles], of_faces[:, None])
        lengths = numpy.linalg.norm(forwards, axis=1, keepdims=True)
        apart = SIDES_APART * float(numpy.linalg.norm(numpy.ptp(self.positions, axis=0)))
        shift = apart * forwards / numpy.maximum(lengths, 1e-30)
        twice = lambda rows, more=0: numpy.concatenate([rows, rows + rows.dtype.type(more)])
        return replace(
            self, positions=numpy.concatenate([self.positions + shift, self.positions - shift]).astype("f4"),
            corner_vertices=twice(self.corner_vertices, len(self.positions)),
            triangles=twice(self.triangles, len(self.corner_vertices)), slots=twice(numpy.clip(self.slots, 0, slots - 1), slots),
            normals=twice(self.normals), uvs={name: twice(rows) for name, rows in self.uvs.items()},
            colors={name: twice(rows) for name, rows in self.colors.items()},
        ).fingerprint()

    def unwrapped(self):
        """Geometry with separate corners for each triangle, and texture coordinates without overlap."""
        corners = self.triangles.ravel()
        # Two triangles to a square of a grid, with gaps.
        count = len(self.triangles)
        columns = max(1, int(numpy.ceil(numpy.sqrt(numpy.ceil(count / 2)))))
        cells = numpy.arange(count) // 2
        origin = numpy.stack([cells % columns, cells // columns], axis=1)[:, None, :]
        apart = 0.06
        lower = numpy.array([[apart, apart], [1.0 - 3.0 * apart, apart], [apart, 1.0 - 3.0 * apart]])
        inner = numpy.where((numpy.arange(count) % 2 == 0)[:, None, None], lower, 1.0 - lower)
        atlas = ((origin + inner) / columns).reshape(-1, 2).astype("f4")
        return replace(
            self, corner_vertices=self.corner_vertices[corners], triangles=numpy.arange(len(corners), dtype="i4").reshape(-1, 3),
            normals=self.normals[corners] if self.normals_of == "CORNER" else self.normals,
            uvs={**{name: uv[corners] for name, uv in self.uvs.items()}, ATLAS: atlas},
            colors={name: color[corners] for name, color in self.colors.items()},
        ).fingerprint()


def digest(*pieces):
    """Hash of bytes and arrays."""
    made = hashlib.blake2b(digest_size=16)
    for piece in pieces:
        made.update(piece if isinstance(piece, bytes) else numpy.ascontiguousarray(piece).ravel().view("u1"))
    return made.digest()


def of_mesh(mesh, colors=(), uvs=(), groups=NO_GROUPS, heed=nobody):
    """Geometry of a mesh, with the colours and texture coordinates that its materials use; None without
    faces. `groups` are its vertex groups by name."""
    if not mesh.polygons:
        return None
    mesh.calc_loop_triangles()
    heeded = lambda read, *asked: heed() or read(*asked)
    corners, triangles = len(mesh.loops), len(mesh.loop_triangles)
    faces = heeded(numbers, mesh.loop_triangles, "polygon_index", triangles, "i4")
    slots = heeded(numbers, mesh.polygons, "material_index", len(mesh.polygons), "i4")[faces]
    normals_of, normals = heeded(normals_and_owner, mesh)
    layers = {layer.name: heeded(numbers, layer.uv, "vector", (corners, 2), "f4") for layer in ordered_uvs(mesh)}
    if layers and not any(layer.active_render for layer in mesh.uv_layers):
        # As for meshes from nodes in Blender 5.0: Cycles uses the corner of pictures.
        layers = {NONE_RENDERS: numpy.zeros((corners, 2), "f4"), **layers}
    found = Geometry(
        name=mesh.name,
        positions=heeded(numbers, mesh.vertices, "co", (len(mesh.vertices), 3), "f4"),
        corner_vertices=heeded(numbers, mesh.loops, "vertex_index", corners, "i4"),
        triangles=heeded(numbers, mesh.loop_triangles, "loops", (triangles, 3), "i4"),
        slots=slots,
        normals_of=normals_of,
        normals=normals,
        uvs={**layers, **{name: heeded(uv_of_corners, mesh, name) for name in uvs if name not in layers}},
        colors={name: heeded(of_corners, mesh, name, groups) for name in colors},
    )
    return heeding(heed, corners, found.fingerprint)


def normals_and_owner(mesh):
    if mesh.normals_domain == "FACE":
        return "FACE", numpy.empty((0, 3), "f4")
    if mesh.normals_domain == "POINT":
        normals = numbers(mesh.vertex_normals, "vector", (len(mesh.vertices), 3), "f4")
        return with_sharp_faces(mesh, normals) if mesh.has_custom_normals else ("POINT", normals)
    return "CORNER", numbers(mesh.corner_normals, "vector", (len(mesh.loops), 3), "f4")


def with_sharp_faces(mesh, normals):
    """Custom normals by point: Cycles still shades sharp faces flat."""
    count = len(mesh.polygons)
    is_smooth = numbers(mesh.polygons, "use_smooth", count, "?")
    if is_smooth.all():
        return "POINT", normals
    of_faces = numpy.repeat(numpy.arange(count), numbers(mesh.polygons, "loop_total", count, "i4"))
    corners = normals[numbers(mesh.loops, "vertex_index", len(mesh.loops), "i4")]
    flat = numbers(mesh.polygons, "normal", (count, 3), "f4")[of_faces]
    return "CORNER", numpy.where(is_smooth[of_faces, None], corners, flat)


def ordered_uvs(mesh):
    """UV maps, the render one first, which textures without a name use."""
    layers = list(mesh.uv_layers)
    return sorted(layers, key=lambda layer: not layer.active_render)
