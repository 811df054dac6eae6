"""Export of a glTF scene as a USD stage. Invariant: the target appears whole or not at all."""

import os
import shutil
import tempfile
from collections import Counter
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from pxr import Sdf, UsdUtils

from ..gltf.load import load
from ..gltf.nodes import Node
from ..gltf.scene import Gltf
from ..gltf.sky import read_sky
from ..errors import SceneError
from .cameras import write_camera
from .crowds import crowds, write_crowd
from .geometry import Geometry
from .lights import kind_of, shows_picture, write_light
from .materials import Materials
from .places import write_place
from .prims import Names, Prim
from .properties import say_leaf_id, write_properties
from .samples import Sampler
from .sky import sky_picture, write_sky
from .surroundings import write_fog, write_metadata, write_scene
from .textures import Textures
from .volumes import write_volume

ENDINGS = (".usd", ".usda", ".usdc", ".usdz")
MOST_SAMPLES = 30_000_000
"""Maximum number of samples, of about 100 bytes each during writing."""


@dataclass(frozen=True)
class ExportOptions:
    """Options of the export."""

    for_blender: bool = False
    point_instancer: bool = False
    samples_per_frame: int = 1
    frames: tuple[int, int] | None = None
    fps: Fraction | None = None
    program: str | None = None
    allowed: tuple[Path, ...] = ()
    """Folders beside the input's own from which files may be read."""


@dataclass(frozen=True)
class Exported:
    """Result of the export: prims by type, frames, and losses."""

    prims: dict[str, int]
    frames: range
    lost: list[str]


def export_usd(source: str | Path, target: str | Path, options: ExportOptions = ExportOptions()) -> Exported:
    """Writes `source`, a sequence, scene or glTF file, as the stage `target`. Raises `SceneError` or
    `OSError`."""
    source, target = Path(source), Path(target)
    if target.suffix.lower() not in ENDINGS:
        raise SceneError(f"{target}: is no stage: expected a name that ends in {', '.join(ENDINGS)}")
    if not target.parent.is_dir():
        raise SceneError(f"{target}: there is no folder {target.parent}")
    gltf = load(source, options.program, options.frames, options.fps, options.allowed)
    with tempfile.TemporaryDirectory(dir=target.parent, prefix=".sunfleck-usd-") as scratch:
        is_package = target.suffix.lower() == ".usdz"
        # The folder of textures has the stage's name, so that two stages in one folder do not conflict.
        name = "textures" if is_package else f"{target.stem}_textures"
        stage = Path(scratch) / (f"{target.stem}.usdc" if is_package else target.name)
        export = _Export(gltf, options, Textures(gltf.container, Path(scratch) / name, name), source.name)
        export.folder = None if is_package else target.parent
        exported = export.write(stage)
        if is_package:
            package = Path(scratch) / target.name
            if not UsdUtils.CreateNewUsdzPackage(Sdf.AssetPath(str(stage)), str(package)):
                raise SceneError(f"{target}: the package could not be made")
            stage = package
        elif (Path(scratch) / name).is_dir():
            _replace_folder(Path(scratch) / name, target.parent / name)
        os.replace(stage, target)
    return exported


def _replace_folder(made: Path, wanted: Path) -> None:
    """Moves files to their place; files with other names stay."""
    wanted.mkdir(exist_ok=True)
    for file in made.iterdir():
        os.replace(file, wanted / file.name)
    shutil.rmtree(made)


class _Export:
    """Stage under construction."""

    def __init__(self, gltf: Gltf, options: ExportOptions, textures: Textures, said: str):
        self.gltf, self.options, self.said = gltf, options, said
        self.sampler = Sampler(gltf.settings, options.samples_per_frame)
        samples = len(self.sampler.frames) * sum(len(node.curves) for node in gltf.nodes)
        if samples > MOST_SAMPLES:
            raise SceneError(
                f"{said}: would have {samples} time samples, of at most {MOST_SAMPLES}: export fewer --frames"
            )
        self.names = Names()
        self.lost: list[str] = [*gltf.warnings]
        self.layer = Sdf.Layer.CreateAnonymous(".usda")
        self.textures = textures
        # Folder of the stage; None for a package, which contains its files.
        self.folder: Path | None = None
        self.prims: Counter[str] = Counter()

    def write(self, path: Path) -> Exported:
        with Sdf.ChangeBlock():
            world = Prim.root(self.layer, "World", "Xform")
            self.names.new("World")
            library = Prim.root(self.layer, "_materials", specifier=Sdf.SpecifierClass)
            prototypes = Prim.root(self.layer, "_prototypes", specifier=Sdf.SpecifierClass)
            materials = Materials(self.gltf, self.names, library, self.textures, self.lost)
            self.geometry = Geometry(self.gltf, self.names, materials, prototypes, self.lost)
            self.world = world
            write_metadata(self.layer, self.gltf, "World", f"{self.said}, by sunfleck-tools")
            self.layer.customLayerData = {
                "sunfleck": {"for": "blender" if self.options.for_blender else "usd"}
            }
            sky = read_sky(self.gltf)
            picture = sky_picture(sky, self.textures)
            write_scene(world, self.gltf, self.sampler, picture)
            if write_sky(world, sky, picture, self.textures, self.names):
                self.prims["DomeLight"] += 1
            self._write_nodes()
        self.lost += [f"what changes `{target}` is not carried" for target in self.gltf.unused]
        if not self.layer.Export(str(path)):
            raise OSError(f"{path}: could not be written")
        settings = self.gltf.settings
        return Exported(dict(self.prims), settings.frames, list(dict.fromkeys(self.lost)))

    def _write_nodes(self) -> None:
        plain = {node.index for node in self.gltf.nodes if self._is_plain(node)}
        grouped = crowds(self.gltf.nodes, plain) if self.options.point_instancer else {}
        in_crowds = {node.index for each in grouped.values() for node in each}
        written: dict[int, Prim] = {-1: self.world}
        for node in self.gltf.nodes:
            if node.index in in_crowds or (
                node.extras.member("sunfleck_ctl") is not None and not node.children
            ):
                continue
            parent = self.world if node.parent is None else written[node.parent.index]
            written[node.index] = self._write_node(node, parent, node.index in plain)
        for index, nodes in grouped.items():
            holder = written[index]
            prim = self._child(
                holder, "leaves" if index < 0 else f"{holder.path.name}_leaves", "PointInstancer"
            )
            shapes = [self.geometry.prototype(node) for node in nodes]
            write_crowd(prim, nodes, shapes, self.sampler, self.names, self.options.for_blender)

    def _is_plain(self, node: Node) -> bool:
        """True if the node has only an undeformed mesh."""
        things = [node.source.member("camera"), kind_of(node, self.gltf)]
        things += [node.extras.member(name) for name in ("sunfleck_fog_volume", "sunfleck_object")]
        controlled = self.gltf.control(node.name, "sunfleck_node.visible") is not None
        controlled |= node.source.extension("KHR_node_visibility") is not None
        alone = not node.children and all(thing is None for thing in things) and not controlled
        return alone and self.geometry.meshes.of(node) is not None and self.geometry.bending(node) is None

    def _write_node(self, node: Node, parent: Prim, is_plain: bool) -> Prim:
        light = kind_of(node, self.gltf)
        has_camera = node.source.member("camera") is not None
        has_mesh = self.geometry.meshes.of(node) is not None
        has_fog = node.extras.member("sunfleck_fog_volume") is not None
        things = [light is not None, has_camera, has_mesh, has_fog, bool(node.children)]
        alone = sum(things) == 1
        kind = light if alone and light else "Camera" if alone and has_camera else "Xform"
        prim = self._child(parent, node.name, kind)
        prim.say_name(node.key)
        say_leaf_id(prim, node)
        rays = node.extras.group("sunfleck_object").raw
        write_properties(prim, "sunfleck_object", rays, node.name, self.gltf, self.sampler)
        write_place(prim, node, self.gltf, self.sampler, self.options.for_blender)
        if light:
            target = prim if alone else self._child(prim, f"{node.name}_light", light)
            write_light(target, light, node, self.gltf, self.sampler, self.options.for_blender)
            if shows_picture(node):
                self.lost.append(
                    "pictures on suns are kept as custom data alone: UsdLux has no word for them"
                )
        if has_camera:
            target = prim if alone else self._child(prim, f"{node.name}_camera", "Camera")
            write_camera(target, node, self.gltf, self.sampler, self.options.for_blender)
        if has_fog and node.extras.group("sunfleck_fog_volume").member("vdb") is not None:
            write_volume(prim, node, self.gltf, self.sampler, self.names, self.folder)
            self.prims["Volume"] += 1
        elif has_fog:
            write_fog(prim, node, self.gltf, self.sampler, self.names)
        if has_mesh:
            self._write_mesh(prim, node, alone)
        return prim

    def _write_mesh(self, prim: Prim, node: Node, alone: bool) -> None:
        bending = self.geometry.bending(node)
        if bending is not None:
            # Skinned vertices are in world space, whatever their node's transform.
            holder = self._child(self.world, f"{node.name}_skin", "Xform") if bending.is_skinned else prim
            if holder is not prim:
                holder.say_name(node.key)
            self.geometry.fill(holder, bending.mesh, bending, self.sampler)
            return
        instance = prim if alone else self._child(prim, f"{node.name}_shape", "Xform")
        instance.refer_to(self.geometry.prototype(node))
        instance.spec.instanceable = True

    def _child(self, parent: Prim, name: str, kind: str) -> Prim:
        self.prims[kind] += 1
        return parent.child(self.names.new(name), kind)
