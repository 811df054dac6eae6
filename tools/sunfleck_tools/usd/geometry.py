"""Meshes: shared prototypes, and a mesh of its own for each deformation."""

import numpy as np
from pxr import Sdf, Vt

from ..gltf.deformation import Bending
from ..gltf.meshes import Mesh, Meshes, Primitive
from ..gltf.nodes import Node
from ..gltf.scene import Gltf
from ..errors import SceneError
from .materials import Materials
from .prims import Names, Prim, Types, texture_coordinates
from .samples import Sampler, thinned

MOST_BYTES = 2**28
"""Maximum bytes of a deforming mesh's points over all frames."""


class Geometry:
    """Writes meshes, undeformed ones once."""

    def __init__(self, gltf: Gltf, names: Names, materials: Materials, prototypes: Prim, lost: list[str]):
        self.gltf, self.names, self.materials, self.prototypes = gltf, names, materials, prototypes
        self.meshes = Meshes(gltf, lost)
        self._written: dict[int, Sdf.Path] = {}

    def bending(self, node: Node) -> Bending | None:
        """Deformation of a node's mesh, if it has one."""
        found = self.meshes.of(node)
        if found is None:
            return None
        mesh = found[1]
        bending = Bending(self.gltf, node, mesh)
        return bending if bending.is_skinned or any(primitive.targets for primitive in mesh.primitives) else None

    def prototype(self, node: Node) -> Sdf.Path:
        """Prototype of the node's mesh."""
        found = self.meshes.of(node)
        assert found is not None, "whoever asks has seen a mesh"
        number, mesh = found
        if number not in self._written:
            holder = self.prototypes.child(self.names.new(mesh.name), "Xform")
            self.fill(holder, mesh)
            self._written[number] = holder.path
        return self._written[number]

    def fill(
        self, holder: Prim, mesh: Mesh, bending: Bending | None = None, sampler: Sampler | None = None
    ) -> None:
        """Writes a mesh below a prim, with its materials beside it."""
        bound = {}
        for primitive in mesh.primitives:
            prim = holder.child(self.names.new(f"{mesh.name}_mesh"), "Mesh")
            _write_faces(prim, primitive)
            if bending is None or sampler is None:
                _write_points(prim, [0.0], primitive.positions[None])
            else:
                codes = sampler.codes(*bending.curves)
                if len(codes) * primitive.positions.nbytes > MOST_BYTES:
                    raise SceneError(
                        f"mesh `{mesh.name}` bends for {len(codes)} frames: that is too much; export fewer "
                        "frames"
                    )
                _write_points(prim, *thinned(codes, bending.positions(primitive, sampler.seconds(codes))))
            if primitive.normals is not None and bending is None:
                prim.set("normals", Types.Normal3fArray, Vt.Vec3fArray.FromNumpy(primitive.normals))
                prim.annotate("normals", "interpolation", "vertex")
            material = primitive.material
            if material is not None:
                if material not in bound:
                    bound[material] = self.materials.refer(holder, material)
                prim.apply("MaterialBindingAPI")
                prim.relate("material:binding", bound[material])


def _write_faces(prim: Prim, primitive: Primitive) -> None:
    triangles = primitive.triangles
    prim.set("faceVertexCounts", Types.IntArray, Vt.IntArray.FromNumpy(np.full(len(triangles), 3, np.int32)))
    prim.set("faceVertexIndices", Types.IntArray, Vt.IntArray.FromNumpy(triangles.astype(np.int32).ravel()))
    prim.set("subdivisionScheme", Types.Token, "none", uniform=True)
    prim.set("doubleSided", Types.Bool, True, uniform=True)
    for layer, uvs in primitive.uvs.items():
        name = texture_coordinates(layer)
        # glTF counts rows of texels from the top.
        flipped = np.ascontiguousarray(uvs * np.array([1, -1], np.float32) + np.array([0, 1], np.float32))
        prim.set(f"primvars:{name}", Types.TexCoord2fArray, Vt.Vec2fArray.FromNumpy(flipped))
        prim.annotate(f"primvars:{name}", "interpolation", "vertex")
    if primitive.colors is not None:
        colors = Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(primitive.colors))
        prim.set("primvars:displayColor", Types.Color3fArray, colors)
        prim.annotate("primvars:displayColor", "interpolation", "vertex")


def _write_points(prim: Prim, codes, positions: np.ndarray) -> None:
    arrays = [Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(each, np.float32)) for each in positions]
    prim.animate("points", Types.Point3fArray, codes, arrays)
    extents = [Vt.Vec3fArray.FromNumpy(_extent(each)) for each in positions]
    prim.animate("extent", Types.Float3Array, codes, extents)


def _extent(positions: np.ndarray) -> np.ndarray:
    if len(positions) == 0:
        return np.zeros((2, 3), np.float32)
    return np.stack([positions.min(axis=0), positions.max(axis=0)]).astype(np.float32)
