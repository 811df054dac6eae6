"""Meshes at nodes. Invariant: what is the same is stored once, in however many prims it came."""

from __future__ import annotations

from pxr import Usd

from ...gltf.writer import GlbWriter
from .losses import Losses
from .nodes import Nodes
from .shapes import Shapes, read_mesh
from .source import Source
from .surfaces import Surfaces


class Meshes:
    """Writes meshes and puts them where they stand."""

    def __init__(self, writer: GlbWriter, nodes: Nodes, source: Source, lost: Losses):
        self.writer, self.nodes, self.source, self.lost = writer, nodes, source, lost
        self.surfaces = Surfaces(writer, source, lost)
        self._read: dict[tuple[str, ...], tuple[int | None, Shapes]] = {}
        self._known: dict[bytes, int] = {}

    def place(self, prims: list[Usd.Prim], node: int) -> None:
        """Puts prims in one place, as one mesh, at a node."""
        same = [prim.GetPrimInPrototype() if prim.IsInstanceProxy() else prim for prim in prims]
        key = tuple(str(prim.GetPath()) for prim in same)
        if key not in self._read:
            shapes = [read_mesh(prim, self.source, self.lost) for prim in prims]
            bends = [shape.bend for shape in shapes if shape.bend is not None]
            joined = Shapes([part for shape in shapes for part in shape.parts], bends[0] if len(shapes) == 1 and bends else None)
            if bends and len(shapes) > 1:
                self.lost.add("usd-meshes-together", prims[0].GetParent().GetPath(), "of several meshes in one place none bends")
            self._read[key] = self._write(prims[0].GetName(), joined), joined
        number, joined = self._read[key]
        if number is None:
            return
        self.nodes.of(node)["mesh"] = number
        if joined.bend is not None:
            times = self.source.seconds(joined.bend.codes)
            self.writer.animate(node, "weights", times, joined.bend.weights.reshape(-1, 1))

    def _write(self, name: str, shapes: Shapes) -> int | None:
        primitives = []
        for part in shapes.parts:
            attributes = {
                key: self.writer.floats(values, with_bounds=key == "POSITION") for key, values in part.attributes.items()
            }
            primitive: dict = {"attributes": attributes, "indices": self.writer.indices(part.triangles)}
            material = self.surfaces.number(part.material, part.layers)
            if material is not None:
                primitive["material"] = material
            if shapes.bend is not None:
                targets = [target[part.point_of_row] for target in shapes.bend.targets]
                primitive["targets"] = [{"POSITION": self.writer.floats(target, with_bounds=True)} for target in targets]
            primitives.append(primitive)
        if not primitives:
            return None
        mesh = {"name": name, "primitives": primitives}
        if shapes.bend is not None:
            mesh["weights"] = shapes.bend.weights[0].tolist()
        # Blender's exports have a copy for each leaf.
        same = repr((primitives, mesh.get("weights"))).encode()
        if same not in self._known:
            self._known[same] = self.writer.add("meshes", mesh)
        return self._known[same]
