"""Materials of a stage to those of glTF: networks of UsdPreviewSurface, UsdUVTexture, UsdTransform2d and readers of primvars."""

from __future__ import annotations

import json
import math

import numpy as np
from pxr import Ar, Usd, UsdShade

from ...errors import SceneError
from ...gltf.writer import GlbWriter
from ..materials import NOT_CARRIED, OURS
from .losses import Losses
from .properties import custom_data
from .source import Source

WRAPS = {"repeat": 10497, "clamp": 33071, "mirror": 33648}
KINDS = {b"\x89PNG": "image/png", b"\xff\xd8\xff": "image/jpeg"}
MOST_BYTES = 2**29
"""Of one image's file."""
OTHER_SHARES = ("transmission", "mirror", "filter_color")
"""Of `sunfleck_material`, beside the base colour's."""
SINGLE_PRECISION = 1e-6
"""By which a sum of rounded shares may be off."""


class Surfaces:
    """Writes each material, for each order of texture coordinates, once."""

    def __init__(self, writer: GlbWriter, source: Source, lost: Losses):
        self.writer, self.source, self.lost = writer, source, lost
        self._written: dict[tuple[str, tuple[str, ...]], int] = {}
        self._known: dict[str, int] = {}
        self._images: dict[str, int] = {}

    def number(self, prim: Usd.Prim | None, layers: list[str]) -> int | None:
        """The glTF material of a material of the stage, None without one."""
        if prim is None:
            return None
        same = prim.GetPrimInPrototype() if prim.IsInstanceProxy() else prim
        key = str(same.GetPath()), tuple(layers)
        if key not in self._written:
            material = self._material(prim, layers)
            # Instances refer to copies of their own.
            text = json.dumps(material, sort_keys=True)
            if text not in self._known:
                self._known[text] = self.writer.add("materials", material)
            self._written[key] = self._known[text]
        return self._written[key]

    def _material(self, prim: Usd.Prim, layers: list[str]) -> dict:
        name = prim.GetAttribute("userProperties:blender:data_name").Get() if self.source.by_blender else None
        material = {"name": name or prim.GetName(), "doubleSided": True}
        extras = custom_data(prim)
        kept = {key: extras[key] for key in OURS if key in extras}
        if kept:
            material["extras"] = kept
        for name in NOT_CARRIED:
            # Textures of them have numbers of another file.
            said = extras.get(name)
            numbers = {key: value for key, value in said.items() if not isinstance(value, dict)} if isinstance(said, dict) else {}
            if numbers:
                self.extend(material, name, numbers)
        surface = UsdShade.Material(prim).ComputeSurfaceSource()[0]
        if not surface or surface.GetIdAttr().Get() != "UsdPreviewSurface":
            self.lost.add("usd-material", prim.GetPath(), "is no UsdPreviewSurface, and grey here")
            material["pbrMetallicRoughness"] = {"baseColorFactor": [0.18, 0.18, 0.18, 1.0], "metallicFactor": 0.0}
            return material
        reader = _Reader(self, surface, layers)
        reader.read(material, extras)
        _keep_shares(material["pbrMetallicRoughness"]["baseColorFactor"], extras.get("sunfleck_material"))
        return material

    def image(self, asset, place: str) -> int:
        """The image of a file."""
        resolved = asset.resolvedPath
        if not resolved:
            raise SceneError(f"{place}: there is no texture `{asset.path}`")
        if resolved not in self._images:
            opened = Ar.GetResolver().OpenAsset(Ar.ResolvedPath(resolved))
            if not opened or opened.GetSize() > MOST_BYTES:
                raise SceneError(f"{place}: the texture `{asset.path}` cannot be read")
            data = bytes(opened.GetBuffer())
            kind = next((kind for start, kind in KINDS.items() if data.startswith(start)), None)
            if kind is None:
                raise SceneError(f"{place}: the texture `{asset.path}` is neither PNG nor JPEG: convert it")
            name = resolved.replace("[", "/").rstrip("]").rpartition("/")[2].rpartition(".")[0]
            self._images[resolved] = self.writer.add("images", {"name": name, "mimeType": kind, "bufferView": self.writer.view(data)})
        return self._images[resolved]

    def extend(self, material: dict, extension: str, value: dict) -> None:
        """Adds an extension to a material."""
        self.writer.extensions.add(extension)
        material.setdefault("extensions", {})[extension] = value


def _keep_shares(base: list[float], ours: object) -> None:
    """Rounds a base colour down so far that it does not add up to more than 1 with the other shares of the light.

    A stage has colours in single precision, and custom data in double: what added up to 1 may have come to lie above it.
    """
    others = [ours[name] for name in OTHER_SHARES if name in ours] if isinstance(ours, dict) else []
    for channel in range(3):
        # What is no number is for the renderer to refuse.
        shares = [each[channel % len(each)] if isinstance(each, list) and each else each for each in others]
        if all(isinstance(each, (int, float)) for each in shares):
            room = 1.0 - math.fsum(shares)
            base[channel] = room if room < base[channel] < room + SINGLE_PRECISION else base[channel]


class _Reader:
    """One network."""

    def __init__(self, surfaces: Surfaces, surface: UsdShade.Shader, layers: list[str]):
        self.surfaces, self.surface, self.layers = surfaces, surface, layers
        self.code = surfaces.source.first

    def read(self, material: dict, extras: dict) -> None:
        color, color_map = self._input("diffuseColor", [0.18] * 3)
        opacity, opacity_map = self._input("opacity", [1.0])
        metallic, metallic_map = self._input("metallic", [0.0])
        roughness, rough_map = self._input("roughness", [0.5])
        both = rough_map or metallic_map
        pbr = {
            "baseColorFactor": [*(min(max(each, 0.0), 1.0) for each in color), opacity[0]],
            "metallicFactor": metallic[0],
            "roughnessFactor": roughness[0],
        }
        if color_map is not None:
            pbr["baseColorTexture"] = color_map
        if both is not None:
            pbr["metallicRoughnessTexture"] = both
        material["pbrMetallicRoughness"] = pbr
        threshold = self._input("opacityThreshold", [0.0])[0][0]
        if threshold > 0:
            material.update(alphaMode="MASK", alphaCutoff=threshold)
        elif opacity_map is not None or opacity[0] < 1 or extras.get("alpha_mode") == "BLEND":
            material["alphaMode"] = "BLEND"
        if opacity_map is not None and opacity_map != color_map:
            self._lost("opacity from another texture than the colour's")
        self._read_rest(material, extras)

    def _read_rest(self, material: dict, extras: dict) -> None:
        _, normal_map = self._input("normal", [0.0, 0.0, 1.0])
        if normal_map is not None:
            material["normalTexture"] = {**normal_map, "scale": extras.get("normal_scale", 1.0)}
        emission, emission_map = self._input("emissiveColor", [0.0] * 3)
        strength = max(max(emission), 1.0)
        if max(emission) > 0:
            material["emissiveFactor"] = [max(each, 0.0) / strength for each in emission]
        if emission_map is not None:
            material["emissiveTexture"] = emission_map
        if strength > 1:
            self.surfaces.extend(material, "KHR_materials_emissive_strength", {"emissiveStrength": strength})
        index = max(self._input("ior", [1.5])[0][0], 1.0)
        if index == 1:
            # Reflects nothing.
            self.surfaces.extend(material, "KHR_materials_specular", {"specularFactor": 0.0})
        elif abs(index - 1.5) > 1e-6:
            self.surfaces.extend(material, "KHR_materials_ior", {"ior": index})
        if self._input("useSpecularWorkflow", [0])[0][0]:
            self._lost("specularColor")
        coat = self._input("clearcoat", [0.0])[0][0]
        if coat > 0:
            rough = self._input("clearcoatRoughness", [0.01])[0][0]
            values = {"clearcoatFactor": coat, "clearcoatRoughnessFactor": rough}
            self.surfaces.extend(material, "KHR_materials_clearcoat", values)

    def _lost(self, what: str) -> None:
        self.surfaces.lost.add("usd-material-input", self.surface.GetPath(), f"{what} is not carried")

    def _input(self, name: str, default: list[float]) -> tuple[list[float], dict | None]:
        """Numbers, and the texture that they multiply."""
        found = self.surface.GetInput(name)
        attributes = found.GetValueProducingAttributes() if found else []
        if not attributes:
            return default, None
        producer = UsdShade.Shader(attributes[0].GetPrim())
        if UsdShade.Utils.GetType(attributes[0].GetName()) == UsdShade.AttributeType.Output:
            if producer.GetIdAttr().Get() != "UsdUVTexture":
                self._lost(f"{name} from a {producer.GetIdAttr().Get()}")
                return default, None
            return self._texture(producer, attributes[0].GetName().rpartition(":")[2], len(default))
        value = attributes[0].Get(self.code)
        numbers = _shortest(value if hasattr(value, "__len__") else [value or 0])
        if len(numbers) != len(default) or not all(math.isfinite(each) for each in numbers):
            raise SceneError(f"{attributes[0].GetPath()}: expected {len(default)} finite numbers, found {value}")
        return numbers, None

    def _texture(self, shader: UsdShade.Shader, output: str, width: int) -> tuple[list[float], dict]:
        def get(name: str, default):
            found = shader.GetInput(name)
            value = found.Get(self.code) if found else None
            return default if value is None else value

        asset = get("file", None)
        if asset is None:
            raise SceneError(f"{shader.GetPath()}: has no file")
        wraps = {f"wrap{axis}": WRAPS.get(get(f"wrap{axis}", "repeat"), WRAPS["repeat"]) for axis in "ST"}
        samplers = self.surfaces.writer.document.setdefault("samplers", [])
        if wraps not in samplers:
            samplers.append(wraps)
        texture = {"source": self.surfaces.image(asset, str(shader.GetPath())), "sampler": samplers.index(wraps)}
        textures = self.surfaces.writer.document.setdefault("textures", [])
        if texture not in textures:
            textures.append(texture)
        scale = _shortest(get("scale", [1.0] * 4))
        info = {"index": textures.index(texture), **self._coordinates(shader)}
        first = "rgba".find(output) if len(output) == 1 else 0
        return scale[first : first + width], info

    def _coordinates(self, shader: UsdShade.Shader) -> dict:
        """Which texture coordinates, moved how."""
        connected = _before(shader, "st")
        moved = None
        if connected and connected.GetIdAttr().Get() == "UsdTransform2d":
            moved = self._moved(connected)
            connected = _before(connected, "in")
        layer = 0
        if connected and connected.GetInput("varname"):
            producers = connected.GetInput("varname").GetValueProducingAttributes()
            name = str(producers[0].Get(self.code)) if producers else ""
            if name in self.layers:
                layer = self.layers.index(name)
            elif self.layers:
                self._lost(f"a texture by the coordinates `{name}`, which the mesh does not have,")
        info: dict = {"texCoord": layer}
        if moved is not None:
            self.surfaces.writer.extensions.add("KHR_texture_transform")
            info["extensions"] = {"KHR_texture_transform": moved}
        return info

    def _moved(self, shader: UsdShade.Shader) -> dict:
        """The reverse of what export writes."""

        def get(name: str, default):
            found = shader.GetInput(name)
            value = found.Get(self.code) if found else None
            return default if value is None else value

        angle = math.radians(float(get("rotation", 0.0)))
        wide, high = (float(each) for each in get("scale", (1.0, 1.0)))
        x, y = (float(each) for each in get("translation", (0.0, 0.0)))
        offset = [x - high * math.sin(angle), 1 - y - high * math.cos(angle)]
        return {"offset": np.round(offset, 7).tolist(), "rotation": angle, "scale": [wide, high]}


def _shortest(numbers) -> list[float]:
    """What was written, not what single precision made of it."""
    return [float(str(np.float32(each))) for each in numbers]


def _before(shader: UsdShade.Shader, name: str) -> UsdShade.Shader | None:
    """What an input is connected to."""
    found = shader.GetInput(name)
    attributes = found.GetValueProducingAttributes() if found else []
    return UsdShade.Shader(attributes[0].GetPrim()) if attributes else None
