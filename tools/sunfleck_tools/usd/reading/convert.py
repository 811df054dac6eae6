"""Conversion of a USD stage to a .glb. Invariant: the target appears whole or not at all."""

from dataclasses import dataclass, field
from fractions import Fraction
from itertools import product
from pathlib import Path

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdLux

from ...errors import SceneError
from ...gltf.writer import GlbWriter
from ...disk import write_whole
from ..properties import SPACE
from ..surroundings import ENVIRONMENT, OF_SCENE
from .census import Census
from .crowds import Member, place_crowd, read_crowd
from .domes import is_dome, picture_uri, read_dome
from .kinds import Kinds
from .lamps import kept_of_lamp, read_lamp
from .lenses import read_camera
from .losses import Loss, Losses
from .meshes import Meshes, Piece
from .nodes import Nodes
from .options import ImportOptions
from .render_settings import Lenses, take_exposure, take_render_settings
from .places import STILL, is_placed, is_reset, local_matrices
from .properties import custom_data, number_of, read_properties, text_of
from .shapes import is_shape
from .skins import Skins
from .source import Source, open_stage, usd_said
from .unread import say_unread, say_unread_of_camera
from .volumes import Volumes
from .visibility import is_hidden_by_purpose, says_visibility, seen, up_to

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


def _predicate(is_abstract: bool, is_defined: bool):
    """Predicate of the children to read, those of instances included. Below an `over` or a `class`, which
    may contain prototypes, undefined prims are read too."""
    kinds = Usd.PrimIsActive & Usd.PrimIsLoaded
    kinds = kinds if is_abstract else kinds & ~Usd.PrimIsAbstract
    return Usd.TraverseInstanceProxies(kinds & Usd.PrimIsDefined if is_defined else kinds)


PREDICATES = {pair: _predicate(*pair) for pair in product((False, True), repeat=2)}


def _bounds_fog_of_ours(prim: Usd.Prim) -> bool:
    """True for the guide box of fog that `export-usd` writes."""
    return bool(prim.GetParent().GetPropertiesInNamespace(f"{SPACE}sunfleck_fog_volume"))


def _children(prim: Usd.Prim) -> list[Usd.Prim]:
    return list(prim.GetFilteredChildren(PREDICATES[prim.IsAbstract(), prim.IsDefined()]))


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
        self.shutter: tuple[float, float] | None = None
        self.scene: dict = {}
        self.has_dome = False
        self.lenses: Lenses = {}
        # Cameras by their names in the stage, as nodes may get others.
        self.cameras: dict[str, int] = {}
        self.census = Census(source)
        self.kinds = Kinds()
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
        turn = self._ours_from_stage()
        if np.array_equal(turn, np.eye(4)):
            return None
        return self.nodes.place(self.nodes.add("stage", None), self.source.codes[:1], turn[None])

    def _ours_from_stage(self) -> np.ndarray:
        turn = np.eye(4)
        if UsdGeom.GetStageUpAxis(self.source.stage) == UsdGeom.Tokens.z:
            turn[1:3, 1:3] = [[0, 1], [-1, 0]]
        turn[:3, :3] *= self.source.metres
        return turn

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
                children = _children(prim)
                self._read_scene(prim)
                if says_visibility(prim, self.source):
                    below = self.nodes.add(self._name(prim), parent)
                    self._hide([prim], below)
            else:
                children = []
                with self.lost.leaving_out(prim):
                    below, children = self._node(prim, first, parent, above, depth)
            pending += [(child, below) for child in reversed(children)]

    def _is_drawn(self, prim: Usd.Prim) -> bool:
        """Whether a shape is drawn; one of another type or purpose is reported."""
        kind = self.kinds.of(prim)
        if not (kind.is_gprim or kind.is_instancer):
            return True
        purpose = UsdGeom.Imageable(prim).ComputePurpose()
        if purpose != UsdGeom.Tokens.default_ and purpose not in self.options.purposes:
            if not (self.source.by_us or _bounds_fog_of_ours(prim)):
                self.lost.add("usd-purpose", prim, f"is of purpose `{purpose}`, which is not drawn")
            return False
        if is_hidden_by_purpose(prim, str(purpose), self.source):
            return False
        if not (kind.is_shape or kind.is_instancer or kind.is_volume):
            self.lost.add("usd-shape", prim, f"a {prim.GetTypeName()} is not carried, only faces are")
            return False
        return True

    def _read_scene(self, prim: Usd.Prim) -> tuple[dict[str, dict], dict[str, tuple[np.ndarray, np.ndarray]]]:
        """Custom properties, as of `read_properties`; those of the scene are kept apart."""
        found, carried = read_properties(prim, self.source)
        for name in OF_SCENE:
            if name in found and name not in self.scene:
                self.scene[name] = found.pop(name)
                picture = prim.GetAttribute(f"{SPACE}{name}:image")
                if isinstance(asset := picture.Get() if picture else None, Sdf.AssetPath):
                    self.scene[name]["image"] = picture_uri(asset, str(picture.GetPath()))
                for field_name, (codes, rows) in carried.items():
                    if field_name.startswith(f"{name}."):
                        self.nodes.carry(None, field_name, codes, rows)
        return found, carried

    def _node(
        self, prim: Usd.Prim, first: Usd.Prim, parent: int | None, above: int | None, depth: int
    ) -> tuple:
        """Node of a prim, and the children that are not merged into it."""
        children = _children(prim)
        is_drawn = self._is_drawn(prim)
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
            own = [child for child in children if self._joins(child)]
            shapes = [child for child in own if self.kinds.of(child).is_shape]
            things = shapes if shapes else own[:1] if len(own) == 1 else []
            for thing in things:
                say_unread(thing, self.source, self.lost)
            children = [child for child in children if child not in things]
        if any(self.kinds.of(thing).is_camera for thing in things):
            self.cameras.setdefault(self._name(prim), below)
        self._things(things, below, depth)
        return below, [] if self.kinds.of(prim).is_instancer else children

    def _name(self, prim: Usd.Prim) -> str:
        said = text_of(prim, "sunfleck_name", self.source)
        if said is not None:
            return said.partition("#")[0] or prim.GetName()
        return text_of(prim, "blender:object_name", self.source) or prim.GetDisplayName() or prim.GetName()

    def _joins(self, prim: Usd.Prim) -> bool:
        """True if a prim can be merged into its parent's node."""
        kind = self.kinds.of(prim)
        if not (kind.is_shape or kind.is_camera or kind.is_volume or prim.HasAPI(UsdLux.LightAPI)):
            return False
        if (
            says_visibility(prim, self.source)
            or any(self.kinds.of(child).is_xformable for child in _children(prim))
            or not self._is_drawn(prim)
        ):
            return False
        if is_placed(prim, self.source):
            if is_reset(prim, self.source):
                return False
            _, matrices = local_matrices(prim, self.source)
            return bool(np.abs(matrices - STILL).max() < 1e-12)
        return True

    def _hide(self, prims: list[Usd.Prim], node: int) -> None:
        """Sets a node's visibility to that of all these prims."""
        found = seen(prims, self.source)
        if found is not None:
            self.nodes.show(node, *found)

    def _extras(self, prim: Usd.Prim, node: int) -> None:
        found, carried = self._read_scene(prim)
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
            self.lenses[str(thing.GetPath())] = self.nodes.of(node)["name"], stops
            self.shutter = self.shutter or seen.shutter
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
            return self._background(prim)
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

    def _background(self, light: Usd.Prim) -> None:
        if ENVIRONMENT in self.scene:
            # The renderer's own properties override any dome.
            if self.has_dome:
                self.lost.add("usd-dome-second", light, "a second DomeLight is not carried: there is one sky")
            return
        hidden = seen(up_to(light, light.GetStage().GetPseudoRoot()), self.source)
        if hidden is not None and hidden[1].any():
            self.lost.add(
                "usd-dome-animated", light, "a sky that is seen for a while is seen as it is at first"
            )
        if hidden is not None and not hidden[1][0]:
            return
        self.has_dome = True
        self.scene[ENVIRONMENT] = read_dome(light, self.source, self._ours_from_stage(), self.lost)

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
            shapes = self._only_shapes(prototype)
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

    def _only_shapes(self, prototype: Usd.Prim) -> list[Usd.Prim] | None:
        """Visible shapes of a prototype; None if it has more than untransformed shapes."""
        children = [child for child in _children(prototype) if child.IsA(UsdGeom.Imageable)]
        stands = prototype.IsA(UsdGeom.Xformable) and not UsdGeom.Xformable(prototype).GetOrderedXformOps()
        if not stands or says_visibility(prototype, self.source) or prototype.IsA(UsdGeom.PointInstancer):
            return None
        if is_shape(prototype):
            return None if children else [prototype] if self._is_drawn(prototype) else []
        return (
            children if children and all(is_shape(each) and self._joins(each) for each in children) else None
        )

    def _finish(self) -> None:
        source, document = self.source, self.writer.document
        first, last = source.frames
        sunfleck = self.scene.setdefault("sunfleck", {})
        sunfleck.update(
            version=1, fps=source.fps.numerator, fps_base=source.fps.denominator, frame_start=first, frame_end=last,
            light_units="spec",
        )  # fmt: skip
        take_render_settings(sunfleck, source, self.options, self.lenses, self.lost)
        if sunfleck.get("camera") in self.cameras:
            sunfleck["camera"] = self.nodes.of(self.cameras[sunfleck["camera"]])["name"]
        if self.shutter is not None and "shutter" not in sunfleck:
            opening, closing = self.shutter
            sunfleck.update(shutter=closing - opening, shutter_offset=opening)
        take_exposure(sunfleck, self.lenses)
        if self.lights:
            self.writer.extensions.add("KHR_lights_punctual")
            document["extensions"] = {"KHR_lights_punctual": {"lights": self.lights}}
        scene = {"name": source.path.stem, "nodes": self.nodes.roots, "extras": self.scene}
        document["scenes"] = [
            scene if self.nodes.roots else {key: value for key, value in scene.items() if key != "nodes"}
        ]
        for kind in [kind for kind, value in document.items() if value == []]:
            del document[kind]
        shown = (document.get("meshes"), document.get("cameras"), self.lights, ENVIRONMENT in self.scene, self.volumes.count)
        # Dropped prims are reported already.
        if not any(shown) and {loss.kind for loss in self.lost.list()} <= {"usd-missing"}:
            self.lost.add("usd-empty", "/", "the stage holds nothing to be seen")
