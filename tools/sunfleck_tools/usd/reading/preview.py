"""Material of glTF from the inputs of UsdPreviewSurface.

Source: https://openusd.org/release/spec_usdpreviewsurface.html. In goes a network, out come the material's
fields and their animation. Invariant: every authored input is honoured or reported.
"""

from dataclasses import dataclass, field

import numpy as np
from pxr import Usd

from .bakes import Bakery
from .colors import within
from .networks import Fed, Network
from .numbers import numbers_in
from .places import codes_of

SMALLEST = 1e-6


@dataclass
class Looks:
    """Material of glTF with extensions, and its animated fields by path: codes and rows."""

    material: dict
    changing: dict[str, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)
    shows_colors: bool = False
    """Whether the mesh's own colours multiply the base colour."""


class Preview:
    """One surface."""

    def __init__(self, network: Network, bakery: Bakery, codes: np.ndarray):
        self.network, self.bakery, self.codes = network, bakery, codes

    def read(self, looks: Looks, extras: dict) -> None:
        """Sets the fields of a material; `extras` are those that the export stored."""
        self._read_base(looks, extras)
        self._read_metal(looks)
        self._read_emission(looks)
        normal = self.bakery.normal(self.network.fed("normal"))
        if normal is not None:
            looks.material["normalTexture"] = {**normal, "scale": extras.get("normal_scale", 1.0)}
        self._read_reflection(looks)
        self._read_coat(looks)
        for name, rest in (("displacement", 0.0), ("occlusion", 1.0)):
            found = self.network.fed(name)
            if found.texture is not None or found.changing is not None or found.numbers[0] != rest:
                self.network.say(name)

    def _read_base(self, looks: Looks, extras: dict) -> None:
        color, opacity = self.network.fed("diffuseColor"), self.network.fed("opacity")
        factor, texture = self.bakery.color(color, opacity)
        pbr = looks.material.setdefault("pbrMetallicRoughness", {})
        pbr["baseColorFactor"] = factor
        if texture is not None:
            pbr["baseColorTexture"] = texture
        looks.shows_colors = color.is_of_mesh or opacity.is_of_mesh
        threshold = self.network.number("opacityThreshold")
        if threshold > 0:
            looks.material.update(alphaMode="MASK", alphaCutoff=threshold)
        elif (
            opacity.texture is not None
            or opacity.is_of_mesh
            or factor[3] < 1
            or extras.get("alpha_mode") == "BLEND"
        ):
            looks.material["alphaMode"] = "BLEND"
        self._read_changing_base(looks, color, opacity)

    def _read_changing_base(self, looks: Looks, color: Fed, opacity: Fed) -> None:
        if color.changing is None and opacity.changing is None:
            return
        factor = looks.material["pbrMetallicRoughness"]["baseColorFactor"]
        codes, (colors, shares) = self._rows([(color, factor[:3]), (opacity, factor[3:])])
        rows = self._shares(np.concatenate([colors, shares], axis=1), "diffuseColor")
        if rows[:, 3].min() < 1:
            looks.material.setdefault("alphaMode", "BLEND")
        looks.changing["pbrMetallicRoughness/baseColorFactor"] = codes, rows

    def _read_metal(self, looks: Looks) -> None:
        pbr, inputs = looks.material["pbrMetallicRoughness"], {"roughness": self.network.fed("roughness")}
        if not self._is_specular():
            inputs["metallic"] = self.network.fed("metallic")
        # glTF has roughness in green and metallic in blue.
        factors, texture = self.bakery.shares({1 + slot: fed for slot, fed in enumerate(inputs.values())})
        pbr["roughnessFactor"], pbr["metallicFactor"] = factors[1], factors.get(2, 0.0)
        if texture is not None:
            pbr["metallicRoughnessTexture"] = texture
        for name, fed in inputs.items():
            if fed.changing is not None:
                codes, (rows,) = self._rows([(fed, [pbr[f"{name}Factor"]])])
                looks.changing[f"pbrMetallicRoughness/{name}Factor"] = codes, self._shares(rows, name)

    def _read_emission(self, looks: Looks) -> None:
        fed = self.network.fed("emissiveColor")
        factor, texture = self.bakery.emission(fed)
        codes, rows = self.codes[:1], np.array([factor])
        if fed.changing is not None:
            codes, (rows,) = self._rows([(fed, factor)])
            rows = np.maximum(rows, 0)
        strength = max(float(rows.max()), 1.0)
        if max(factor) > 0 or rows.max() > 0:
            looks.material["emissiveFactor"] = [each / strength for each in factor]
        if texture is not None:
            looks.material["emissiveTexture"] = texture
        if strength > 1:
            _extend(looks, "KHR_materials_emissive_strength", {"emissiveStrength": strength})
        if fed.changing is not None:
            looks.changing["emissiveFactor"] = codes, rows / strength

    def _is_specular(self) -> bool:
        return self.network.number("useSpecularWorkflow") > 0.5

    def _read_reflection(self, looks: Looks) -> None:
        """Reflectance along the normal, from the index or given explicitly."""
        if self._is_specular():
            fed = self.network.fed("specularColor")
            color = self.bakery.flat(fed)
            if fed.changing is not None:
                self.network.say("specularColor that changes over time")
            # An index of 0 in KHR_materials_ior leaves the specular colour alone.
            _extend(looks, "KHR_materials_ior", {"ior": 0.0})
            factors = [min(max(each, 0.0), 1.0) for each in color]
            _extend(looks, "KHR_materials_specular", {"specularColorFactor": factors})
            return
        index = max(self.network.number("ior"), 1.0)
        if index == 1:
            # No reflection.
            _extend(looks, "KHR_materials_specular", {"specularFactor": 0.0})
        elif abs(index - 1.5) > SMALLEST:
            _extend(looks, "KHR_materials_ior", {"ior": index})

    def _read_coat(self, looks: Looks) -> None:
        coat, rough = self.network.fed("clearcoat"), self.network.fed("clearcoatRoughness")
        if coat.changing is not None or rough.changing is not None:
            self.network.say("a clearcoat that changes over time")
        if coat.texture is None and coat.numbers[0] <= 0:
            return
        # The extension has red for one and green for the other, in textures that may be the same.
        factors, texture = self.bakery.shares({0: coat, 1: rough})
        values: dict = {"clearcoatFactor": factors[0], "clearcoatRoughnessFactor": factors[1]}
        if texture is not None:
            values.update(clearcoatTexture=texture, clearcoatRoughnessTexture=texture)
        _extend(looks, "KHR_materials_clearcoat", values)

    def _shares(self, rows: np.ndarray, name: str) -> np.ndarray:
        """Animated rows, clamped to 0 to 1."""
        return within(rows, self.network.shader.GetPrim(), name, self.network.lost)

    def _rows(self, inputs: list[tuple[Fed, list[float]]]) -> tuple[np.ndarray, list[np.ndarray]]:
        """Values of inputs at all codes at which any changes; for constant ones those given."""
        attributes: list[Usd.Attribute] = [fed.changing for fed, _ in inputs if fed.changing is not None]
        codes = codes_of(attributes, self.codes)
        found = []
        for fed, still in inputs:
            rows = np.tile(np.array(still, float), (len(codes), 1))
            if fed.changing is not None:
                for row, code in enumerate(codes.tolist()):
                    numbers = numbers_in(fed.changing.Get(code), len(still))
                    rows[row] = rows[max(row - 1, 0)] if numbers is None else numbers
            found.append(rows)
        return codes, found


def _extend(looks: Looks, extension: str, value: dict) -> None:
    looks.material.setdefault("extensions", {}).setdefault(extension, {}).update(value)
