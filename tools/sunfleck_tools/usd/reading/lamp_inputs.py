"""Inputs that all UsdLux lights have. Invariant: values are finite and not negative; other values and
unsupported inputs are reported."""

import numpy as np
from pxr import Sdf, Usd, UsdLux

from .losses import Losses
from .numbers import numbers_in
from .texels import PictureError, open_picture

BRIGHTEST = 1e15
COLDEST, HOTTEST = 1000.0, 10000.0
"""Range of UsdLux's colour temperatures, kelvin."""
RESTS = {
    "diffuse": 1.0, "specular": 1.0, "shaping:focus": 0.0, "shadow:enable": 1.0, "shadow:color": 0.0, "shadow:distance": -1.0,
}  # fmt: skip
"""Unsupported inputs, and their neutral values."""
NAMES = (
    "intensity", "exposure", "color", "radius", "length", "width", "height", "angle", "enableColorTemperature",
    "colorTemperature",
)  # fmt: skip
CONE = ("shaping:cone:angle", "shaping:cone:softness")
MEAN_SIZE = 256


def light_texels(asset: Sdf.AssetPath) -> np.ndarray:
    """Linear colours of a light's picture, finite and not below 0, reduced to be averaged. Raises `PictureError`."""
    picture = open_picture(asset.resolvedPath)
    size = (min(picture.size[0], MEAN_SIZE), min(picture.size[1], MEAN_SIZE))
    texels = picture.texels(size, picture.bits == 8 and picture.channels >= 3)[..., :3]
    return np.clip(np.nan_to_num(texels.astype(float), nan=0.0, posinf=65504.0), 0.0, BRIGHTEST)


class LampInputs:
    """The inputs of one light."""

    def __init__(self, prim: Usd.Prim, lost: Losses):
        self.prim, self.lost = prim, lost

    def attributes(self) -> list[Usd.Attribute]:
        """Attributes of a light's power or size."""
        return self._found(NAMES)

    def cone_attributes(self) -> list[Usd.Attribute]:
        """Attributes of its cone."""
        return self._found(CONE)

    def has_cone(self) -> bool:
        """Whether it has a cone."""
        return any(attribute.HasAuthoredValue() for attribute in self._found(CONE[:1]))

    def _found(self, names: tuple[str, ...]) -> list[Usd.Attribute]:
        return [each for each in (self.prim.GetAttribute(f"inputs:{name}") for name in names) if each]

    def numbers(self, name: str, default: float, codes: np.ndarray) -> np.ndarray:
        """Values of a scalar, one a code."""
        return np.clip(self._rows(name, (default,), codes)[:, 0], -BRIGHTEST, BRIGHTEST)

    def radiance(self, codes: np.ndarray) -> np.ndarray:
        """Radiance from intensity, exposure, colour, temperature and the mean of a picture: three numbers
        a code."""
        colors = self._rows("color", (1.0, 1.0, 1.0), codes)
        scale = self.numbers("intensity", 1.0, codes) * np.exp2(
            np.clip(self.numbers("exposure", 0.0, codes), -60, 60)
        )
        tints = np.array([self._temperature(code) for code in codes.tolist()])
        radiance = colors * tints * self._picture() * scale[:, None]
        if (radiance < 0).any():
            self.lost.add("usd-light-value", self.prim, "its light is below 0, and 0 is taken")
        return np.clip(radiance, 0, BRIGHTEST)

    def _rows(self, name: str, default: tuple[float, ...], codes: np.ndarray) -> np.ndarray:
        """Values of an input, as wide as its default, a row a code."""
        attribute = self.prim.GetAttribute(f"inputs:{name}")
        rows = []
        for code in codes.tolist():
            value = attribute.Get(code) if attribute else None
            numbers = default if value is None else numbers_in(value, len(default))
            if numbers is None:
                what = f"its {name} is not finite, or no number, and {default[0]:g} is taken"
                self.lost.add("usd-light-value", self.prim, what)
            rows.append(numbers or default)
        return np.array(rows)

    def _temperature(self, code: float) -> np.ndarray:
        light = UsdLux.LightAPI(self.prim)
        # Blender enables colour temperature without a value: the fallback of 6500 K is then white.
        if (
            not light.GetEnableColorTemperatureAttr().Get(code)
            or not light.GetColorTemperatureAttr().HasAuthoredValue()
        ):
            return np.ones(3)
        found = numbers_in(light.GetColorTemperatureAttr().Get(code), 1)
        if found is None:
            what = "its colorTemperature is not finite, and is passed over"
            self.lost.add("usd-light-value", self.prim, what)
            return np.ones(3)
        kelvin = found[0]
        if not COLDEST <= kelvin <= HOTTEST:
            said = f"its colorTemperature of {kelvin:g} K is taken as one from {COLDEST:g} to {HOTTEST:g} K"
            self.lost.add("usd-light-value", self.prim, said)
        return np.array(UsdLux.BlackbodyTemperatureAsRgb(min(max(kelvin, COLDEST), HOTTEST)))

    def _picture(self) -> np.ndarray:
        """Mean colour of a RectLight's picture."""
        attribute = self.prim.GetAttribute("inputs:texture:file")
        asset = attribute.Get() if attribute and self.prim.IsA(UsdLux.RectLight) else None
        if not isinstance(asset, Sdf.AssetPath) or not asset.path:
            return np.ones(3)
        try:
            texels = light_texels(asset)
        except PictureError as error:
            self.lost.add("usd-texture", self.prim, f"the picture `{asset.path}` is left out: {error}")
            return np.ones(3)
        self.lost.add("usd-light-input", self.prim, "its picture is carried as its mean colour alone")
        return texels.mean(axis=(0, 1))

    def say_the_rest(self, kind: str) -> None:
        """Reports unsupported inputs."""
        for name, rest in RESTS.items():
            attribute = self.prim.GetAttribute(f"inputs:{name}")
            value = attribute.Get() if attribute else None
            numbers = numbers_in(value, 3 if name == "shadow:color" else 1)
            if value is not None and (numbers is None or numbers[0] != rest or len(set(numbers)) > 1):
                self._say(f"its {name}")
        ies = self.prim.GetAttribute("inputs:shaping:ies:file")
        if ies and isinstance(ies.Get(), Sdf.AssetPath) and ies.Get().path:
            self._say("its IES profile")
        if kind not in ("SphereLight", "CylinderLight") and self.has_cone():
            self._say(f"the cone of a {kind}, which shines to all of its side,")
        if (
            self.prim.GetRelationship("light:filters")
            and self.prim.GetRelationship("light:filters").GetTargets()
        ):
            self._say("what filters it")
        for name in ("lightLink", "shadowLink"):
            api = Usd.CollectionAPI(self.prim, name)
            if api.GetIncludeRootAttr().Get() is False or (
                api.GetExcludesRel() and api.GetExcludesRel().GetTargets()
            ):
                self._say(f"its {name}, which leaves some things out,")

    def _say(self, what: str) -> None:
        self.lost.add("usd-light-input", self.prim, f"{what} is not carried")
