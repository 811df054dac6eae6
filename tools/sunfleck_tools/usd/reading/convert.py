"""Conversion of a USD stage to a .glb. Invariant: the target appears whole or not at all."""

from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

import numpy as np
from pxr import Sdf, Usd, UsdLux

from ...errors import SceneError
from ...gltf.writer import GlbWriter
from ...disk import write_whole
from ..surroundings import ENVIRONMENT
from .census import Census
from .crowds import Member, place_crowd, read_crowd
from .domes import is_dome
from .drawn import Drawn, children_of
from .kinds import Kinds
from .lamps import kept_of_lamp, read_lamp
from .lenses import read_camera
from .losses import Loss, Losses
from .meshes import Meshes, Piece
from .nodes import Nodes
from .options import ImportOptions
from .places import is_reset, local_matrices
from .properties import number_of, text_of
from .skins import Skins
from .source import Source, open_stage, usd_said
from .surroundings import Surroundings, ours_from_stage
from .unread import say_unread, say_unread_of_camera
from .volumes import Volumes
from .visibility import says_visibility, seen, up_to

@dataclass(frozen=True)
class Imported:
    """Result of the import: counts of glTF's lists, frames, and losses."""

    counts: dict[str, int]
    frames: tuple[int, int]
    fps: Fraction
    lost: list[Loss] = field(default_factory=list)
    """Losses, one a kind, with counts."""
    every: list[Loss] = field(default_factory=list)
    """Losses one by one."""


def import_usd(source: str | Path, target: str | Path, options: ImportOptions = ImportOptions()) -> Imported:
    """Writes the stage `source` as the .glb `target`. Raises `SceneError` or `OSError`."""
    source, target = Path(source), Path(target)
    if target.suffix.lower() != ".glb":
        raise SceneError(f"{target}: expected a name that ends in .glb")
    if not target.parent.is_dir():
        raise SceneError(f"{target}: there is no folder {target.parent}")
    with usd_said(source):
        lost = Losses()
        conversion = _Import(open_stage(source, options, lost), options, lost, target.parent)
        data = conversion.run()
    if options.strict and lost.list():
        said = "\n".join(f"  {loss}" for loss in lost.list())
        raise SceneError(f"{source}: is not carried as it is, and --strict asks for that:\n{said}")
    write_whole(target, data)
    document = conversion.writer.document
    counts = {
        kind: len(document.get(kind, ())) for kind in ("nodes", "meshes", "materials", "cameras", "images")
    }
    return Imported(counts, conversion.source.frames, conversion.source.fps, lost.list(), lost.every())


class _Import:
    """File under construction."""

    def __init__(self, source: Source, options: ImportOptions, lost: Losses, folder: Path):
        self.source, self.options, self.lost = source, options, lost
        self.writer = GlbWriter("sunfleck-tools import-usd")
        self.nodes = Nodes(self.writer, source, self.lost)
        self.skins = Skins(source, self.nodes, self.lost)
        self.volumes = Volumes(self.nodes, folder)
        self.meshes = Meshes(self.writer, self.nodes, self.skins, source, self.lost)
        self.lights: list[dict] = []
        self.surroundings = Surroundings(source, self.nodes, self.lost)
        self.census = Census(source)
        self.kinds = Kinds()
        self.drawn = Drawn(self.kinds, source, options, lost)
        self._crowds: dict[Sdf.Path, list[Member]] = {}
        # Meshes of prototypes that only have shapes; None for others.
        self._plain: dict[Sdf.Path, list[Piece] | None] = {}

    def run(self) -> bytes:
        """Bytes of the file."""
        self.skins.prepare()
        above = self._root()
        for prim in self.source.stage.GetPseudoRoot().GetChildren():
            self._visit(prim, above, 0)
        self.skins.finish()
        self._finish()
        return self.writer.bytes()

    def _root(self) -> int | None:
        """Node that converts the stage's axes and unit."""
        turn = ours_from_stage(self.source)
        if np.array_equal(turn, np.eye(4)):
            return None
        return self.nodes.place(self.nodes.add("stage", None), self.source.codes[:1], turn[None])

    def _visit(self, first: Usd.Prim, above: int | None, depth: int) -> None:
        """Reads a prim and its descendants below a node; those with `!resetXformStack!` become direct
        children."""
        pending = [(first, above)]
        while pending:
            prim, parent = pending.pop()
            kind = self.kinds.of(prim)
            say_unread(prim, self.source, self.lost)
            if kind.stands_nowhere or (depth == 0 and prim.IsAbstract()):
                continue
            if kind.is_unknown:
                said = f"is a `{prim.GetTypeName()}`, which USD does not know, and is passed over"
                self.lost.add("usd-prim", prim, said)
            below = parent
            if not kind.is_xformable:
                children = children_of(prim)
                self.surroundings.read(prim)
                if says_visibility(prim, self.source):
                    below = self.nodes.add(self._name(prim), parent)
                    self._hide([prim], below)
            else:
                children = []
                with self.lost.leaving_out(prim):
                    below, children = self._node(prim, first, parent, above, depth)
            pending += [(child, below) for child in reversed(children)]

    def _node(
        self, prim: Usd.Prim, first: Usd.Prim, parent: int | None, above: int | None, depth: int
    ) -> tuple:
        """Node of a prim, and the children that are not merged into it."""
        children = children_of(prim)
        is_drawn = self.drawn.holds(prim)
        if not is_drawn and not children:
            return parent, []
        stands_alone = is_reset(prim, self.source)
        codes, matrices = local_matrices(prim, self.source)
        node = self.nodes.add(self._name(prim), above if stands_alone else parent)
        below = self.nodes.place(node, codes, matrices)
        self._hide(up_to(prim, first) if stands_alone else [prim], node)
        self._extras(prim, node)
        self.skins.stands(prim, below)
        things = [prim] if is_drawn else []
        if prim.GetTypeName() in ("Xform", "SkelRoot", ""):
            # A child with its parent's transform, like leaves and Blender's cameras and lights, is merged
            # with it.
            own = [child for child in children if self.drawn.joins(child)]
            shapes = [child for child in own if self.kinds.of(child).is_shape]
            things = shapes if shapes else own[:1] if len(own) == 1 else []
            for thing in things:
                say_unread(thing, self.source, self.lost)
            children = [child for child in children if child not in things]
        if any(self.kinds.of(thing).is_camera for thing in things):
            self.surroundings.cameras.setdefault(self._name(prim), below)
        self._things(things, below, depth)
        return below, [] if self.kinds.of(prim).is_instancer else children

    def _name(self, prim: Usd.Prim) -> str:
        said = text_of(prim, "sunfleck_name", self.source)
        if said is not None:
            return said.partition("#")[0] or prim.GetName()
        return text_of(prim, "blender:object_name", self.source) or prim.GetDisplayName() or prim.GetName()

    def _hide(self, prims: list[Usd.Prim], node: int) -> None:
        """Sets a node's visibility to that of all these prims."""
        found = seen(prims, self.source)
        if found is not None:
            self.nodes.show(node, *found)

    def _extras(self, prim: Usd.Prim, node: int) -> None:
        found, carried = self.surroundings.read(prim)
        for name, fields in found.items():
            self.nodes.extra(node, name, fields)
        for field_name, (codes, rows) in carried.items():
            if field_name.partition(".")[0] in found:
                self.nodes.carry(node, field_name, codes, rows)
        leaf_id = number_of(prim, "leaf_id", self.source)
        if leaf_id is not None:
            self.nodes.extra(node, "leaf_id", leaf_id)

    def _things(self, things: list[Usd.Prim], node: int, depth: int) -> None:
        """Reads the contents of a node."""
        shapes = [thing for thing in things if self.kinds.of(thing).is_shape]
        if shapes:
            self.meshes.put(self.meshes.pieces(shapes), node)
        for thing in things:
            with self.lost.leaving_out(thing):
                self._thing(thing, node, depth)

    def _thing(self, thing: Usd.Prim, node: int, depth: int) -> None:
        """Reads a camera, a light or an instancer."""
        kind = self.kinds.of(thing)
        if kind.is_camera:
            seen = read_camera(thing, self.source)
            stops = say_unread_of_camera(thing, self.source, self.lost)
            self.surroundings.read_camera(thing, node, stops, seen.shutter)
            self.nodes.of(node)["camera"] = self.writer.add(
                "cameras", {"name": self.nodes.of(node)["name"], **seen.camera}
            )
            for name, (codes, rows) in seen.carried.items():
                self.nodes.carry(node, f"sunfleck_camera.{name}", codes, rows)
        elif not kind.is_mesh and thing.HasAPI(UsdLux.LightAPI):
            self._place_lamp(thing, node)
        elif kind.is_volume:
            self.volumes.place(thing, node, self._extras)
        elif kind.is_instancer:
            if depth == 0:
                self.census.add(thing)
            members = self._members(thing)
            place_crowd(
                members, self.nodes, node, lambda member, place: self._instance(member, place, depth)
            )

    def _place_lamp(self, prim: Usd.Prim, node: int) -> None:
        if is_dome(prim):
            return self.surroundings.read_sky(prim)
        lamp = read_lamp(prim, self.source, self.nodes.linear(node), self.lost)
        if lamp is None:
            return
        if lamp.light is not None:
            self.lights.append({"name": self.nodes.of(node)["name"], **lamp.light})
            extension = {"light": len(self.lights) - 1}
            self.nodes.of(node).setdefault("extensions", {})["KHR_lights_punctual"] = extension
        lamp.extras |= kept_of_lamp(prim, "angle" in lamp.extras, self.lost)
        if lamp.extras:
            self.nodes.extra(node, "sunfleck_light", lamp.extras)
        for name, (codes, rows) in lamp.carried.items():
            self.nodes.carry(node, f"sunfleck_light.{name}", codes, rows)

    def _instance(self, member: Member, node: int, depth: int) -> None:
        """Puts a prototype below a node, or into it if it only has shapes."""
        prototype, outer = member.prototype, self.meshes.tint
        # Nested instances have their own colours, or else those of the outer instance.
        self.meshes.tint = outer if member.color is None else member.color
        try:
            self._prototype(prototype, node, depth)
        finally:
            self.meshes.tint = outer

    def _prototype(self, prototype: Usd.Prim, node: int, depth: int) -> None:
        path = prototype.GetPath()
        if path not in self._plain:
            shapes = self.drawn.only_shapes(prototype)
            self._plain[path] = None if shapes is None else self.meshes.pieces(shapes)
        pieces = self._plain[path]
        if pieces is None:
            self._visit(prototype, node, depth + 1)
        else:
            self.meshes.put(pieces, node)

    def _members(self, prim: Usd.Prim) -> list[Member]:
        """Instances of an instancer, which is read once."""
        path = prim.GetPath()
        if path not in self._crowds:
            self._crowds[path] = read_crowd(prim, self.source, self.lost)
        return self._crowds[path]

    def _finish(self) -> None:
        source, document = self.source, self.writer.document
        self.surroundings.finish(self.options)
        if self.lights:
            self.writer.extensions.add("KHR_lights_punctual")
            document["extensions"] = {"KHR_lights_punctual": {"lights": self.lights}}
        scene = {"name": source.path.stem, "nodes": self.nodes.roots, "extras": self.surroundings.extras}
        document["scenes"] = [
            scene if self.nodes.roots else {key: value for key, value in scene.items() if key != "nodes"}
        ]
        for kind in [kind for kind, value in document.items() if value == []]:
            del document[kind]
        has_sky = ENVIRONMENT in self.surroundings.extras
        shown = (document.get("meshes"), document.get("cameras"), self.lights, has_sky, self.volumes.count)
        # Dropped prims are reported already.
        if not any(shown) and {loss.kind for loss in self.lost.list()} <= {"usd-missing"}:
            self.lost.add("usd-empty", "/", "the stage holds nothing to be seen")
