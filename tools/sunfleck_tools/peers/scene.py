"""Scene at one moment, for other renderers.

It has triangles in the world, lights, a camera and a box of fog. Invariant: other features are refused if
they would change the light, and reported if they change surfaces.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import SceneError
from ..gltf.deformation import Bending
from ..gltf.lights import LightSource
from ..gltf.load import load
from ..gltf.meshes import Meshes, Primitive
from ..gltf.nodes import Node
from ..gltf.scene import Gltf
from ..gltf.values import Value
from .lamps import Lamp, Sun, read_light
from .pictures import PeerSky, Texture, read_background, read_texture

DEFAULT_SIZE = (960, 540)
FOG_GROWTH = np.diag([1 + 3e-5] * 3 + [1.0])
"""Enlarges a fog box so that a ground in its face is inside: rays of other renderers that hit the face
first would continue below the ground."""
THINNING = ("height_falloff", "scale_height")
SURFACE_BEYOND = ("normalTexture", "emissiveTexture")


@dataclass
class Surface:
    """Triangles in world space with one Lambert reflectance, and perhaps a texture that multiplies it
    (with `uvs` by vertex); `material` is the file's index."""

    positions: np.ndarray
    triangles: np.ndarray
    uvs: np.ndarray
    reflectance: list[float]
    texture: Texture | None
    material: int | None


@dataclass
class Fog:
    """Fog in the image of the cube [-1, 1]^3, homogeneous or from a grid in its own space; extinction per
    metre."""

    world_from_cube: np.ndarray
    density_per_m: list[float]
    albedo: list[float]
    anisotropy: float
    # OpenVDB file and grid.
    grid: tuple[Path, str] | None = None
    # Grid of colours that multiply albedo.
    albedo_grid: str | None = None


@dataclass
class PeerScene:
    """All that is rendered; without a sky the background is black."""

    surfaces: list[Surface]
    suns: list[Sun]
    lamps: list[Lamp]
    world_from_camera: np.ndarray
    fov_y_rad: float
    fog: Fog | None
    sky: PeerSky | None
    size: tuple[int, int]
    notes: list[str]
    # Number of scatterings beyond direct light and single scattering.
    bounces: int = 0


def read_scene(
    source: Path, frame: float | None = None, program: str | None = None, allowed: Sequence[Path] = ()
) -> PeerScene:
    """Reads an input of the renderer (`load`) at a frame, by default the first. Raises `SceneError`."""
    gltf = load(source, program, allowed=allowed)
    return _Reader(gltf, gltf.settings.first if frame is None else frame).scene()


class _Reader:
    def __init__(self, gltf: Gltf, frame: float):
        self.gltf = gltf
        self.notes: list[str] = [*gltf.warnings]
        self.time_s = gltf.settings.seconds(np.array([frame]))
        self.materials = gltf.document.items("materials")

    def scene(self) -> PeerScene:
        meshes = Meshes(self.gltf, self.notes)
        parts: dict[int | None, list[tuple[np.ndarray, Primitive]]] = {}
        lights, cameras, fogs = [], [], []
        for node in self.gltf.nodes:
            world_from_node = node.world_from_node(self.time_s)[0]
            if (found := meshes.of(node)) is not None and self._is_visible(node):
                bending = Bending(self.gltf, node, found[1])
                place = np.eye(4) if bending.is_skinned else world_from_node
                for primitive in found[1].primitives:
                    points = bending.positions(primitive, self.time_s)[0] @ place[:3, :3].T + place[:3, 3]
                    parts.setdefault(primitive.material, []).append((points, primitive))
            source = LightSource(node, self.gltf)
            if source.kind is not None:
                lights.append(read_light(source, world_from_node, self.time_s))
            elif source.ours.raw:
                source.ours.fail(
                    "other renderers get no light of its type: expected `area`, or a light of glTF beside it"
                )
            if node.source.member("camera") is not None:
                cameras.append((node, world_from_node))
            if (fog := node.extras.member("sunfleck_fog_volume")) is not None:
                fogs.append(self._fog(node, fog, world_from_node))
        sky = read_background(self.gltf)
        if not (lights or sky) or len(fogs) > 1 or self.gltf.extras.member("sunfleck_fog") is not None:
            raise SceneError(
                f"{self.gltf.document.file}: other renderers get one or more lights and at most one box of "
                "fog"
            )
        world_from_camera, fov_y_rad = self._camera(cameras)
        return PeerScene(
            surfaces=[self._surface(material, pieces) for material, pieces in parts.items()],
            suns=[light for light in lights if isinstance(light, Sun)],
            lamps=[light for light in lights if isinstance(light, Lamp)],
            world_from_camera=world_from_camera,
            fov_y_rad=fov_y_rad,
            fog=fogs[0] if fogs else None,
            sky=sky,
            size=self.gltf.settings.size if all(self.gltf.settings.size) else DEFAULT_SIZE,
            notes=list(dict.fromkeys(self.notes)),
        )

    def _is_visible(self, node: Node) -> bool:
        return all(
            above.is_shown if above.shown is None else above.shown.at(self.time_s)[0, 0] >= 0.5 for above in node.upwards
        )

    def _fog(self, node: Node, fog: Value, world_from_cube: np.ndarray) -> Fog:
        vdb, grid = fog.member("vdb"), None
        if vdb is not None:
            path = self.gltf.container.beside(vdb)
            if not path.is_file():
                vdb.fail(f"leads to {path}, which is no file: other renderers get no sequences of grids")
            grid = path, fog.text_at("grid", "density")
        if fog.member("emission_grid") is not None:
            fog.fail("other renderers get grids of density and albedo alone")
        if fog.text_at("shape", "box") != "box" or any(fog.number_at(name, 0.0) > 0 for name in THINNING):
            fog.fail("other renderers get fog that fills a box evenly")

        def channels(field: str, still: list[float]) -> list[float]:
            control = self.gltf.control(node.name, f"sunfleck_fog_volume.{field}")
            return still if control is None else np.broadcast_to(control.at(self.time_s)[0], 3).tolist()

        albedo, anisotropy = fog.member("albedo"), fog.number_at("anisotropy", 0.0, -1.0, 1.0)
        return Fog(
            world_from_cube if grid else world_from_cube @ FOG_GROWTH,
            channels("density", fog.need("density").channels()),
            channels("albedo", [1.0] * 3 if albedo is None else albedo.channels()),
            channels("anisotropy", [anisotropy])[0],
            grid,
            fog.text_at("albedo_grid", "") or None,
        )

    def _camera(self, cameras: list[tuple[Node, np.ndarray]]) -> tuple[np.ndarray, float]:
        named = self.gltf.settings.camera
        chosen = [entry for entry in cameras if not named or entry[0].name == named]
        if not chosen:
            raise SceneError(
                f"{self.gltf.document.file}: there is no camera" + (f" `{named}`" if named else "")
            )
        node, world_from_camera = chosen[0]
        described = self.gltf.document.items("cameras")
        source = node.source.need("camera").item_of(described, "camera")
        ours = source.extras.group("sunfleck_camera")
        if source.text_at("type") != "perspective" or any(
            ours.member(name) is not None for name in ("shift", "fstop")
        ):
            source.fail("other renderers get a pinhole camera: perspective, without a shift or an aperture")
        yfov = self.gltf.control(node.name, "sunfleck_camera.yfov")
        still = source.need("perspective").need("yfov").number(1e-6, 3.14)
        return world_from_camera, still if yfov is None else float(yfov.at(self.time_s)[0, 0])

    def _surface(self, material: int | None, pieces: list[tuple[np.ndarray, Primitive]]) -> Surface:
        reflectance, texture = self._reflectance(material)
        first, triangles, uvs = 0, [], []
        for points, primitive in pieces:
            triangles.append(primitive.triangles.astype(np.uint32) + np.uint32(first))
            first += len(points)
            found = None if texture is None else primitive.uvs.get(texture.layer)
            uvs.append(np.zeros((len(points), 2)) if texture is None or found is None else texture.placed(found))
        positions = np.concatenate([points for points, _ in pieces])
        return Surface(positions, np.concatenate(triangles), np.concatenate(uvs), reflectance, texture, material)

    def _reflectance(self, material: int | None) -> tuple[list[float], Texture | None]:
        if material is None:
            return [1.0] * 3, None
        source = self.materials[material]
        shading = source.group("pbrMetallicRoughness")
        beyond = [name for name in SURFACE_BEYOND if source.member(name) is not None]
        beyond += ["emissiveFactor"] if any(source.numbers_at("emissiveFactor", 0.0, 0.0, 0.0)) else []
        beyond += sorted(name for name in source.group("extensions").raw if not self._is_matte(name, source))
        beyond += [name for name in ("sunfleck_leaf", "sunfleck_material") if source.extras.member(name) is not None]
        beyond += ["metallicFactor"] if shading.number_at("metallicFactor", 1.0) > 0 else []
        beyond += ["alphaMode"] if source.text_at("alphaMode", "OPAQUE") != "OPAQUE" else []
        if beyond:
            self.notes.append(
                f"{source.path}: other renderers get a matte surface of its base colour, without "
                f"{', '.join(beyond)}"
            )
        info = shading.member("baseColorTexture")
        texture = None if info is None else read_texture(self.gltf, info)
        return shading.numbers_at("baseColorFactor", 1.0, 1.0, 1.0, 1.0)[:3], texture

    def _is_matte(self, extension: str, source: Value) -> bool:
        """True for an extension that adds no gloss."""
        found = source.extension(extension)
        if extension != "KHR_materials_specular" or found is None:
            return False
        return found.number_at("specularFactor", 1.0) == 0.0
