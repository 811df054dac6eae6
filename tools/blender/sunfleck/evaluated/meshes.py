"""Geometries as meshes of the file: equal corners become one vertex, and each material slot a primitive.

In go a geometry and its deformation, out comes the index of a glTF mesh. Invariant: vertices are in the
file's axes, y up.
"""

from functools import partial

import numpy

from ..materials.colours import rec709
from .attributes import four
from .document import INDICES, VERTICES
from .heeding import heeding, nobody


def turned(vectors):
    """Vectors (x, y, z) of Blender in glTF's axes."""
    return numpy.stack([vectors[..., 0], vectors[..., 2], -vectors[..., 1]], axis=-1)


class Layout:
    """Vertices of corners, for every shape of a topology."""

    def __init__(self, geometry, is_bent):
        vertices = geometry.corner_vertices
        keys = [vertices.reshape(-1, 1), *geometry.uvs.values(), *geometry.colors.values()]
        if geometry.normals_of == "CORNER":
            # In a deforming mesh, equal normals may differ later.
            corners = numpy.arange(len(vertices), dtype="i4").reshape(-1, 1)
            keys.append(corners if is_bent else geometry.normals)
        rows = numpy.concatenate(
            [numpy.ascontiguousarray(key).view("i4").reshape(len(vertices), -1) for key in keys], axis=1
        )
        self.corners, self.vertex_of_corner = unique_rows(rows)

    def positions(self, geometry):
        return turned(geometry.positions[geometry.corner_vertices[self.corners]])

    def normals(self, geometry):
        if geometry.normals_of == "FACE":
            return None
        of_corners = geometry.normals
        if geometry.normals_of != "CORNER":
            of_corners = of_corners[geometry.corner_vertices]
        normals = turned(of_corners[self.corners]).astype(float)
        lengths = numpy.linalg.norm(normals, axis=1, keepdims=True)
        up = numpy.array([0.0, 1.0, 0.0])
        return numpy.where(lengths > 1e-6, normals / numpy.maximum(lengths, 1e-6), up).astype("f4")


def unique_rows(rows):
    """First index of each unique row, in order, and the unique row of each row."""
    if rows.shape[1] == 1:
        keys = rows[:, 0]
    else:
        whole = numpy.dtype((numpy.void, rows.dtype.itemsize * rows.shape[1]))
        keys = numpy.ascontiguousarray(rows).view(whole).ravel()
    _, first, kind = numpy.unique(keys, return_index=True, return_inverse=True)
    order = numpy.argsort(first, kind="stable")
    rank = numpy.empty(len(order), int)
    rank[order] = numpy.arange(len(order))
    return first[order], rank[kind.ravel()]


class Meshes:
    """Meshes of a document, each once. `materials` is a library; `heed` raises to cancel."""

    def __init__(self, document, materials, heed=nobody):
        self.document, self.materials, self.heed, self.known = document, materials, heed, {}

    def number(self, geometry, materials, bend=None):
        """Index of a geometry's mesh with these materials, one a slot. A deforming mesh has targets:
        displacements of positions and normals."""
        key = (geometry.known_by(), materials, None if bend is None else id(bend))
        if key not in self.known:
            self.known[key] = self.made(geometry, materials, bend), bend
        return self.known[key][0]

    def made(self, geometry, materials, bend):
        """Mesh; None if all its materials are fully transparent."""
        layout = bend.layout if bend else self.made_of(geometry, lambda: Layout(geometry, False))
        attributes, colors = self.attributes(geometry, layout), {}
        targets = bend.targets(self.document) if bend else []
        primitives = []
        for slot in numpy.unique(geometry.slots):
            material = materials[min(max(int(slot), 0), len(materials) - 1)] if materials else None
            if not self.materials.is_seen(material):
                continue
            corners = self.made_of(geometry, lambda: geometry.triangles[geometry.slots == slot])
            indices = self.made_of(geometry, lambda: layout.vertex_of_corner[corners].ravel())
            small = len(layout.corners) < 65535
            primitive = {
                "attributes": {**attributes, **self.colors(geometry, layout, material, colors)},
                "indices": self.document.accessor(indices.astype("u2" if small else "u4"), INDICES),
                "material": self.materials.number(material, geometry),
            }
            primitives.append({**primitive, "targets": targets} if targets else primitive)
        mesh = {"name": geometry.name, "primitives": primitives}
        return self.document.add("meshes", mesh) if primitives else None

    def made_of(self, geometry, work):
        return heeding(self.heed, len(geometry.corner_vertices), work)

    def attributes(self, geometry, layout):
        add = self.document.accessor
        found = {"POSITION": add(self.made_of(geometry, lambda: layout.positions(geometry)), VERTICES, bounds=True)}
        normals = self.made_of(geometry, lambda: layout.normals(geometry))
        if normals is not None:
            found["NORMAL"] = add(normals, VERTICES)
        # From the bottom in Blender, from the top in glTF.
        flipped = lambda uv: (uv * [1, -1] + [0, 1]).astype("f4")[layout.corners]
        for number, uv in enumerate(geometry.uvs.values()):
            found[f"TEXCOORD_{number}"] = add(self.made_of(geometry, partial(flipped, uv)), VERTICES)
        return found

    def colors(self, geometry, layout, material, known):
        """COLOR_0: factor on this material's base colour and alpha."""
        wanted = self.materials.color_attribute(material, geometry)
        if wanted is None:
            return {}
        if wanted not in known:
            name, part = wanted
            values = four(geometry.colors[name][layout.corners])
            rgb = rec709(values[:, :3]) if part != "a" else numpy.ones_like(values[:, :3])
            rows = numpy.clip(
                rgb if part == "rgb" else numpy.concatenate([rgb, values[:, 3:]], axis=1), 0.0, 1.0
            )
            if rgb.max(initial=0.0) > 1.0 + 1e-6:
                self.materials.lose(material, "attribute-above-one")
            known[wanted] = self.document.accessor(rows.astype("f4"), VERTICES)
        return {"COLOR_0": known[wanted]}
