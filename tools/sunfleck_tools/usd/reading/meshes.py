"""Meshes at nodes. Invariant: equal meshes are stored once, however many prims have them."""

from dataclasses import dataclass, replace

import numpy as np
from pxr import Usd, UsdGeom

from ...gltf.writer import GlbWriter
from .bends import Bend
from .bindings import Bound, path_of, read_bound
from .glows import read_glow
from .losses import UNREADABLE, Losses
from .nodes import Nodes
from .shapes import Shape, ShapeReader, Shapes
from .skins import Skins
from .source import Source
from .spans import Span, read_spans
from .surfaces import Surfaces


@dataclass(frozen=True)
class Piece:
    """Mesh of the file with its name, deformation, span of time, and joints."""

    name: str
    number: int
    bend: Bend | None = None
    span: Span | None = None
    skin: int | None = None


class Meshes:
    """Writes meshes and assigns them to nodes."""

    def __init__(self, writer: GlbWriter, nodes: Nodes, skins: Skins, source: Source, lost: Losses):
        self.writer, self.nodes, self.skins, self.source, self.lost = writer, nodes, skins, source, lost
        self.surfaces = Surfaces(writer, source, lost)
        self._reader = ShapeReader(source, lost)
        self._read: dict[tuple, list[Piece]] = {}
        self._known: dict[bytes, int] = {}
        # Colour of the instance whose prototype is written.
        self.tint: tuple[float, ...] | None = None
        self._takes_tint: dict[int, list[bool]] = {}
        self._in_color: dict[tuple[int, tuple[float, ...]], int] = {}

    def pieces(self, prims: list[Usd.Prim]) -> list[Piece]:
        """Meshes of prims with one transform, written once for all instances of the prims."""
        bound = [read_bound(prim, self.lost) for prim in prims]
        key = tuple((path_of(prim), each.key(), _color_key(prim)) for prim, each in zip(prims, bound))
        if key not in self._read:
            self._read[key] = self._pieces(prims, bound)
        return self._read[key]

    def put(self, pieces: list[Piece], node: int) -> None:
        """Puts pieces at a node: constant ones as one mesh, others in child nodes."""
        if self.tint is not None:
            pieces = [self._tinted(piece, self.tint) for piece in pieces]
        for index, piece in enumerate(pieces):
            is_still = piece.bend is None and piece.span is None and piece.skin is None
            is_alone = len(pieces) == 1 and piece.span is None
            at = node if is_alone or (is_still and index == 0) else self.nodes.add(piece.name, node)
            self.nodes.of(at)["mesh"] = piece.number
            if piece.skin is not None:
                self.nodes.of(at)["skin"] = piece.skin
            if piece.bend is not None:
                times = self.source.seconds(piece.bend.codes)
                self.writer.animate(at, "weights", times, piece.bend.weights.reshape(-1, 1))
            if piece.span is not None:
                self._take_turns(at, piece.span)

    def _tinted(self, piece: Piece, color: tuple[float, ...]) -> Piece:
        """Piece with an instance's colour, unless it has colours of its own."""
        takes = self._takes_tint.get(piece.number, [])
        if not any(takes):
            return piece
        key = piece.number, color
        if key not in self._in_color:
            mesh = self.writer.document["meshes"][piece.number]
            primitives = [
                {**each, "material": self.surfaces.tinted(each.get("material"), color)} if is_taken else each
                for each, is_taken in zip(mesh["primitives"], takes)
            ]
            self._in_color[key] = self.writer.add("meshes", {**mesh, "primitives": primitives})
        return replace(piece, number=self._in_color[key])

    def _pieces(self, prims: list[Usd.Prim], bound: list[Bound]) -> list[Piece]:
        """Meshes of prims, constant ones first."""
        still: list[Shape] = []
        moving: list[tuple[str, Shapes, Span | None, int | None]] = []
        for prim, each in zip(prims, bound):
            with self.lost.leaving_out(prim):
                glow = read_glow(prim, self.source, self.lost)
                for span in read_spans(prim, self.source):
                    # An unreadable time of an animated mesh must not drop the others.
                    with self.lost.leaving_out(prim):
                        shapes = self._reader.read(prim, each, span)
                        for part in shapes.parts:
                            part.glow = glow
                        skin = self.skins.tie(prim, shapes.parts)
                        if shapes.bend is None and span.is_always and skin is None:
                            still += shapes.parts
                        elif shapes.parts:
                            moving.append((prim.GetName(), shapes, None if span.is_always else span, skin))
        pieces = [Piece(prims[0].GetName(), self._write(prims[0].GetName(), Shapes(still)))] if still else []
        return pieces + [
            Piece(name, self._write(name, shapes), shapes.bend, span, skin) for name, shapes, span, skin in moving
        ]

    def _take_turns(self, node: int, span: Span) -> None:
        """Shows a node during a span."""
        edges = {self.source.first: span.start <= self.source.first < span.end}
        for code, is_start in ((span.start, True), (span.end, False)):
            if self.source.first < code < np.inf:
                edges[code] = is_start
        codes = np.array(sorted(edges))
        self.nodes.show(node, codes, np.array([edges[code] for code in codes.tolist()]))

    def _write(self, name: str, shapes: Shapes) -> int:
        mesh = {"name": name, "primitives": [self._primitive(part, shapes.bend) for part in shapes.parts]}
        if shapes.bend is not None:
            mesh["weights"] = shapes.bend.weights[0].tolist()
        # Blender's exports have a copy for each leaf.
        same = repr((mesh["primitives"], mesh.get("weights"))).encode()
        if same not in self._known:
            number = self._known[same] = self.writer.add("meshes", mesh)
            self._takes_tint[number] = [part.takes_tint and "material" in each
                                        for part, each in zip(shapes.parts, mesh["primitives"])]  # fmt: skip
        return self._known[same]

    def _primitive(self, part: Shape, bend: Bend | None) -> dict:
        attributes = {key: self._accessor(key, values) for key, values in part.attributes.items()}
        primitive: dict = {"attributes": attributes, "indices": self.writer.indices(part.triangles)}
        material = self._material(part)
        if material is not None:
            primitive["material"] = material
        if bend is not None:
            targets = [target[part.point_of_row] for target in bend.targets]
            primitive["targets"] = [
                {"POSITION": self.writer.floats(target, with_bounds=True)} for target in targets
            ]
            if part.normal_targets is not None:
                for target, normals in zip(primitive["targets"], part.normal_targets):
                    target["NORMAL"] = self.writer.floats(normals)
        return primitive

    def _accessor(self, name: str, values: np.ndarray) -> int:
        if name.startswith("JOINTS_"):
            return self.writer.joints(values)
        return self.writer.floats(values, name == "POSITION")

    def _material(self, part: Shape) -> int | None:
        try:
            return self.surfaces.number(part.material, part.layers, part.attributes.get("COLOR_0"), part.glow)
        except UNREADABLE as error:
            place = str(part.material.GetPath()) if part.material else ""
            self.lost.add("usd-material", place, f"cannot be read: {str(error).removeprefix(f'{place}: ')}")
            return None


def _color_key(prim: Usd.Prim) -> str:
    """Owner of a part's colours, which may differ between instances."""
    if not prim.IsInstanceProxy():
        return ""
    primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance("displayColor")
    return path_of(primvar.GetAttr().GetPrim()) if primvar else ""
