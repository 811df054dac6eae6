"""Meshes as arrays, and their vertices when they bend (specification, 3.7)."""

from dataclasses import dataclass, field

import numpy as np

from .accessors import Accessors
from .nodes import Node
from .scene import Gltf
from .values import Value

TRIANGLES, STRIP, FAN = 4, 5, 6


@dataclass
class Primitive:
    """Triangles of one material. A target displaces every position; `joints` and `weights` bind vertices
    to a skin."""

    positions: np.ndarray
    triangles: np.ndarray
    material: int | None
    normals: np.ndarray | None
    uvs: dict[int, np.ndarray]
    colors: np.ndarray | None
    targets: list[np.ndarray] = field(default_factory=list)
    joints: np.ndarray | None = None
    weights: np.ndarray | None = None


@dataclass
class Mesh:
    """Primitives, and the default weights of their targets."""

    name: str
    primitives: list[Primitive]
    weights: np.ndarray


class Meshes:
    """The meshes of a file, each read once."""

    def __init__(self, gltf: Gltf, lost: list[str]):
        self.gltf, self.lost = gltf, lost
        self.sources = gltf.document.items("meshes")
        self.materials = gltf.document.items("materials")
        self._read: dict[int, Mesh] = {}

    def of(self, node: Node) -> tuple[int, Mesh] | None:
        """Index and mesh of a node."""
        mesh = node.source.member("mesh")
        if mesh is None:
            return None
        number = mesh.index(self.sources, "mesh")
        if number not in self._read:
            self._read[number] = self._mesh(number)
        return number, self._read[number]

    def _mesh(self, number: int) -> Mesh:
        source = self.sources[number]
        name = source.text_at("name") or f"mesh {number}"
        primitives = []
        for primitive in source.items("primitives"):
            mode = int(primitive.number_at("mode", TRIANGLES))
            if mode in (TRIANGLES, STRIP, FAN):
                primitives.append(self._primitive(primitive, mode))
            else:
                self.lost.append(f"points and lines are not carried: mesh `{name}`")
        counts = {len(primitive.targets) for primitive in primitives} or {0}
        weights = source.member("weights")
        rest = np.zeros(max(counts))
        if weights is not None:
            said = [weight.number() for weight in weights.each()]
            rest[: len(said)] = said[: len(rest)]
        return Mesh(name, primitives, rest)

    def _primitive(self, source: Value, mode: int) -> Primitive:
        accessors = self.gltf.accessors
        attributes = source.need("attributes")
        positions = accessors.floats(attributes.need("POSITION"), 3)
        count = len(positions)

        def rows(name: str, width: int) -> np.ndarray | None:
            accessor = attributes.member(name)
            if accessor is None:
                return None
            found = accessors.floats(accessor, width)
            if len(found) != count:
                accessor.fail(f"has {len(found)} values for {count} vertices")
            return found

        indices = source.member("indices")
        if indices is None:
            corners: np.ndarray = np.arange(count)
        else:
            corners = accessors.integers(indices, count, "vertices")[:, 0]
        uvs = {layer: found for layer in range(8) if (found := rows(f"TEXCOORD_{layer}", 2)) is not None}
        normals, colors = rows("NORMAL", 3), self._colors(attributes, count)
        primitive = Primitive(positions, _triangles(corners, mode), None, normals, uvs, colors)
        if (material := source.member("material")) is not None:
            primitive.material = material.index(self.materials, "material")
        for target in source.items("targets"):
            moved = target.member("POSITION")
            found = np.zeros_like(positions) if moved is None else accessors.floats(moved, 3)
            if len(found) != count:
                target.fail(f"moves {len(found)} of {count} vertices")
            primitive.targets.append(found)
        self._tie(primitive, attributes, accessors, count)
        return primitive

    def _colors(self, attributes: Value, count: int) -> np.ndarray | None:
        accessor = attributes.member("COLOR_0")
        if accessor is None:
            return None
        described = self.gltf.accessors.described
        width = 4 if accessor.item_of(described, "accessor").text_at("type") == "VEC4" else 3
        found = self.gltf.accessors.floats(accessor, width)[:, :3]
        return found if len(found) == count and (found < 1.0).any() else None

    def _tie(self, primitive: Primitive, attributes: Value, accessors: Accessors, count: int) -> None:
        joints, weights = attributes.member("JOINTS_0"), attributes.member("WEIGHTS_0")
        if joints is None or weights is None:
            return
        primitive.joints = accessors.integers(joints, 65536, "joints", 4)
        primitive.weights = accessors.floats(weights, 4).astype(np.float64)
        if len(primitive.joints) != count or len(primitive.weights) != count:
            joints.fail(f"ties {len(primitive.joints)} of {count} vertices")
        if attributes.member("JOINTS_1") is not None:
            self.lost.append("of more than four joints a vertex the first four are taken")


def _triangles(corners: np.ndarray, mode: int) -> np.ndarray:
    if mode == TRIANGLES:
        return corners[: len(corners) // 3 * 3].reshape(-1, 3)
    if len(corners) < 3:
        return np.zeros((0, 3), np.int64)
    if mode == FAN:
        return np.stack([np.full(len(corners) - 2, corners[0]), corners[1:-1], corners[2:]], axis=1)
    found = np.stack([corners[:-2], corners[1:-1], corners[2:]], axis=1)
    found[1::2, :2] = found[1::2, 1::-1]
    return found
