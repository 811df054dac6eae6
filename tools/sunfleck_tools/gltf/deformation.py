"""Vertices of a deforming mesh at any time. Skinned vertices are in world space: their node's own
transform is ignored (3.7.3.3)."""

import numpy as np

from .curves import Curve
from .meshes import Mesh, Primitive
from .nodes import Node
from .scene import Gltf


class Bending:
    """Deformation of a node's mesh."""

    def __init__(self, gltf: Gltf, node: Node, mesh: Mesh):
        self.node, self.mesh = node, mesh
        self.joints: list[Node] = []
        self.joint_from_mesh: np.ndarray = np.zeros((0, 4, 4))
        skins = gltf.document.items("skins")
        skin = node.source.member("skin")
        tied = any(primitive.joints is not None for primitive in mesh.primitives)
        if skin is not None and tied:
            self._read_skin(gltf, skin.item_of(skins, "skin"))
        said = node.source.member("weights")
        self.rest = mesh.weights.copy()
        if said is not None:
            weights = [weight.number() for weight in said.each()][: len(self.rest)]
            self.rest[: len(weights)] = weights

    def _read_skin(self, gltf, skin) -> None:
        by_index = {node.index: node for node in gltf.nodes}
        sources = gltf.document.items("nodes")
        for joint in skin.items("joints"):
            index = joint.index(sources, "node")
            if index not in by_index:
                joint.fail(f"node {index} is not in the scene")
            self.joints.append(by_index[index])
        count = len(self.joints)
        inverse = skin.member("inverseBindMatrices")
        if inverse is None:
            self.joint_from_mesh = np.tile(np.eye(4), (count, 1, 1))
        else:
            found = gltf.accessors.floats(inverse, 16).astype(np.float64)
            if len(found) < count:
                inverse.fail(f"has {len(found)} matrices for {count} joints")
            self.joint_from_mesh = found[:count].reshape(-1, 4, 4).transpose(0, 2, 1)
        for primitive in self.mesh.primitives:
            if primitive.joints is not None and int(primitive.joints.max(initial=0)) >= count:
                skin.fail(f"a vertex is tied to joint {int(primitive.joints.max())} of {count}")

    @property
    def is_skinned(self) -> bool:
        """True if vertices are in world space."""
        return bool(self.joints)

    @property
    def curves(self) -> list[Curve]:
        """All curves that affect the shape."""
        found = [] if self.node.weights is None else [self.node.weights]
        for joint in self.joints:
            found += [curve for node in joint.upwards for curve in node.curves.values()]
        return list({id(curve): curve for curve in found}.values())

    def positions(self, primitive: Primitive, times_s: np.ndarray) -> np.ndarray:
        """Vertices at each time."""
        found = np.tile(primitive.positions.astype(np.float64), (len(times_s), 1, 1))
        if primitive.targets:
            weights = np.tile(self.rest, (len(times_s), 1))
            if self.node.weights is not None:
                said = self.node.weights.at(times_s)[:, : weights.shape[1]]
                weights[:, : said.shape[1]] = said
            for number, target in enumerate(primitive.targets):
                found += weights[:, number, None, None] * target
        if primitive.joints is not None and primitive.weights is not None and self.is_skinned:
            # time, joint
            world_from_mesh = (
                np.stack([joint.world_from_node(times_s) for joint in self.joints], axis=1)
                @ self.joint_from_mesh
            )
            total = np.maximum(primitive.weights.sum(axis=1, keepdims=True), 1e-12)
            shares = primitive.weights / total
            for number in range(len(times_s)):
                blended = np.einsum("vk,vkij->vij", shares, world_from_mesh[number][primitive.joints])
                found[number] = np.einsum("vij,vj->vi", blended[:, :3, :3], found[number]) + blended[:, :3, 3]
        return found
