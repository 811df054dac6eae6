"""Materials of a stage as materials of glTF. Invariant: each is written once for each order of texture
coordinates."""

import copy
import json
import math

import numpy as np
from pxr import Usd, UsdShade

from ...gltf.writer import GlbWriter
from ..materials import NOT_CARRIED, OURS
from .bakes import Bakery
from .colors import GREY
from .losses import Losses
from .networks import Network
from .preview import Looks, Preview
from .properties import custom_data
from .shaders import PREVIEW, surface_of
from .source import Source
from .textures import Textures

OTHER_SHARES = ("transmission", "mirror", "filter_color")
"""Fields of `sunfleck_material` that are shares, beside the base colour."""
UNBOUND = "displayColor"
"""Name of the material of meshes without one."""
SINGLE_PRECISION = 1e-6
"""Tolerance of a sum of rounded shares."""


class Surfaces:
    """Writes materials."""

    def __init__(self, writer: GlbWriter, source: Source, lost: Losses):
        self.writer, self.source, self.lost = writer, source, lost
        self.textures = Textures(lost, source.codes)
        self.bakery = Bakery(writer, self.textures, lost)
        self._written: dict[tuple, int] = {}
        self._known: dict[str, int] = {}
        self._looks_of: dict[int, Looks] = {}
        self._tinted: dict[tuple[int, tuple[float, ...]], int] = {}

    def number(
        self,
        prim: Usd.Prim | None,
        layers: list[str],
        colors: np.ndarray | None = None,
        glow: tuple[float, ...] | None = None,
    ) -> int | None:
        """Index of the glTF material for one of the stage; without one, for a mesh's own `colors` (rows of
        RGB or RGBA).

        `glow` is the radiance of a mesh that is a light.
        """
        if prim is None:
            return None if self.source.by_us else self._add(_glowing(_unbound(colors), glow))
        same = prim.GetPrimInPrototype() if prim.IsInstanceProxy() else prim
        key = str(same.GetPath()), tuple(layers), glow
        if key not in self._written:
            self._written[key] = self._add(_glowing(self._looks(prim, layers), glow))
        return self._written[key]

    def tinted(self, number: int | None, color: tuple[float, ...]) -> int | None:
        """Material with a mesh's colours, times an instance's RGB and opacity."""
        if number is None:
            return None
        key = number, color
        if key not in self._tinted:
            looks = copy.deepcopy(self._looks_of[number])
            base = looks.material["pbrMetallicRoughness"]["baseColorFactor"]
            tint = [1.0, 1.0, 1.0] if math.isnan(color[0]) else list(color[:3])
            is_unbound = looks.material.get("name") == UNBOUND and not math.isnan(color[0])
            rgb = tint if is_unbound else [one * other for one, other in zip(base, tint)]
            looks.material["pbrMetallicRoughness"]["baseColorFactor"] = [*rgb, base[3] * color[3]]
            if color[3] < 1:
                looks.material.setdefault("alphaMode", "BLEND")
            self._tinted[key] = self._add(looks)
        return self._tinted[key]

    def _add(self, looks: Looks) -> int:
        self.writer.extensions.update(looks.material.get("extensions", ()))
        # Instances refer to copies of their own.
        changing = {path: (codes.tolist(), rows.tolist()) for path, (codes, rows) in looks.changing.items()}
        text = json.dumps([looks.material, changing], sort_keys=True)
        if text not in self._known:
            self._looks_of[len(self.writer.document.get("materials", ()))] = copy.deepcopy(looks)
            number = self._known[text] = self.writer.add("materials", looks.material)
            for path, (codes, rows) in looks.changing.items():
                self.writer.animate_value(f"/materials/{number}/{path}", self.source.seconds(codes), rows)
        return self._known[text]

    def _looks(self, prim: Usd.Prim, layers: list[str]) -> Looks:
        name = prim.GetAttribute("userProperties:blender:data_name").Get() if self.source.by_blender else None
        extras = custom_data(prim)
        looks = Looks({"name": name or prim.GetName(), "doubleSided": True})
        _keep(looks.material, extras)
        shader, kind, dialect = surface_of(UsdShade.Material(prim))
        if shader is None or dialect is None:
            what = f"has a surface `{kind}` that is not known" if shader else "has no surface"
            self.lost.add("usd-material", prim, f"{what}, and is grey here")
            looks.material["pbrMetallicRoughness"] = {"baseColorFactor": [*GREY, 1.0], "metallicFactor": 0.0}
            return looks
        if not dialect.is_exact:
            what = "is approximated by colour, roughness, metal, emission, opacity and coat"
            self.lost.add("usd-material-approximated", prim, f"its surface `{kind}` {what}")
        material = UsdShade.Material(prim)
        for what, source in (
            ("volume", material.ComputeVolumeSource()),
            ("displacement", material.ComputeDisplacementSource()),
        ):
            if source[0]:
                self.lost.add("usd-material-input", prim, f"its {what} is not carried")
        network = Network(shader, dialect, self.textures, layers)
        Preview(network, self.bakery, self.source.codes).read(looks, extras if dialect is PREVIEW else {})
        _keep_shares(
            looks.material["pbrMetallicRoughness"]["baseColorFactor"], extras.get("sunfleck_material")
        )
        return looks


def _unbound(colors: np.ndarray | None) -> Looks:
    """Material of a mesh without one."""
    base = GREY if colors is None else (1.0,) * 3
    pbr = {"baseColorFactor": [*base, 1.0], "metallicFactor": 0.0}
    material = {"name": UNBOUND, "doubleSided": True, "pbrMetallicRoughness": pbr}
    if colors is not None and colors.shape[1] == 4:
        material["alphaMode"] = "BLEND"
    return Looks(material)


def _glowing(looks: Looks, glow: tuple[float, ...] | None) -> Looks:
    """The same with a light's radiance, unless the material itself emits, which is then visible
    (`materialSyncMode`)."""
    material = looks.material
    shines = "emissiveFactor" in material or "emissiveTexture" in material
    if glow is None or shines or max(glow) <= 0:
        return looks
    strength = max(*glow, 1.0)
    material["emissiveFactor"] = [each / strength for each in glow]
    if strength > 1:
        material.setdefault("extensions", {})["KHR_materials_emissive_strength"] = {
            "emissiveStrength": strength
        }
    return looks


def _keep(material: dict, extras: dict) -> None:
    """Restores the extras that the export stored beside a material."""
    kept = {key: extras[key] for key in OURS if key in extras}
    if kept:
        material["extras"] = kept
    for name in NOT_CARRIED:
        # Their textures have indices of another file.
        said = extras.get(name)
        given = said if isinstance(said, dict) else {}
        numbers = {key: value for key, value in given.items() if not isinstance(value, dict)}
        if numbers:
            material.setdefault("extensions", {})[name] = numbers


def _keep_shares(base: list[float], ours: object) -> None:
    """Rounds a base colour down until its sum with the other shares is at most 1.

    A stage has colours in single precision, and custom data in double, so a sum of 1 may have grown above
    it.
    """
    others = [ours[name] for name in OTHER_SHARES if name in ours] if isinstance(ours, dict) else []
    for channel in range(3):
        # The renderer refuses values that are not numbers.
        shares = [each[channel % len(each)] if isinstance(each, list) and each else each for each in others]
        if all(isinstance(each, (int, float)) for each in shares):
            room = 1.0 - math.fsum(shares)
            base[channel] = room if room < base[channel] < room + SINGLE_PRECISION else base[channel]
