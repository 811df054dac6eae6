"""UsdLux to the lights of glTF and `sunfleck_light`; `usd/lights.py` has the units, and Blender's."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from pxr import Usd, UsdGeom, UsdLux

from ...gltf.lights import LUMENS_PER_WATT
from ..lights import BLENDER_ANGLE, BLENDER_SUN
from .losses import Losses
from .places import codes_of
from .source import Source

NARROWEST_EDGE = 1e-6


@dataclass
class Lamp:
    """A light of glTF, its extras, and what of them changes: by field, codes and rows."""

    light: dict | None
    extras: dict
    carried: dict[str, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)


def read_lamp(prim: Usd.Prim, source: Source, lost: Losses) -> Lamp | None:
    """The light that a prim is; None if it is none that there is here."""
    kind = str(prim.GetTypeName())
    if kind in ("DistantLight", "SphereLight", "RectLight", "DiskLight"):
        return _Reader(prim, source, lost).read(kind)
    lost.add("usd-camera-or-light-type", prim.GetPath(), f"a {kind} is not carried")
    return None


class _Reader:
    def __init__(self, prim: Usd.Prim, source: Source, lost: Losses):
        self.prim, self.source, self.lost = prim, source, lost
        self.light = UsdLux.LightAPI(prim)
        names = ("intensity", "exposure", "color", "radius", "width", "height", "angle", "normalize")
        inputs = [prim.GetAttribute(f"inputs:{name}") for name in names]
        self.codes = codes_of([each for each in inputs if each], source.codes)
        # Blender's suns, as it writes and reads them.
        self.blenders = source.by_blender or source.for_blender

    def read(self, kind: str) -> Lamp:
        if kind == "DistantLight":
            return self._sun()
        if kind == "SphereLight":
            return self._sphere()
        return self._area(kind)

    def number(self, name: str, default: float) -> np.ndarray:
        """A row of one number for each code."""
        attribute = self.prim.GetAttribute(f"inputs:{name}")
        values = [attribute.Get(code) if attribute else None for code in self.codes.tolist()]
        numbers = [default if value is None else float(value) for value in values]
        return np.nan_to_num(np.array(numbers), nan=default, posinf=1e15, neginf=0.0)

    def radiance(self) -> np.ndarray:
        """Intensity, exposure and colour: three numbers a code."""
        attribute = self.light.GetColorAttr()
        colors = np.array([attribute.Get(code) for code in self.codes.tolist()], float)
        if self.light.GetEnableColorTemperatureAttr().Get() and self.light.GetColorTemperatureAttr().HasAuthoredValue():
            colors = colors * np.array(UsdLux.BlackbodyTemperatureAsRgb(self.light.GetColorTemperatureAttr().Get()))
        scale = self.number("intensity", 1.0) * np.exp2(np.clip(self.number("exposure", 0.0), -60, 60))
        return np.maximum(colors * scale[:, None], 0.0)

    def power(self, of_normalised: Callable[[np.ndarray], np.ndarray], area: np.ndarray) -> np.ndarray:
        """What the light emits; `area` is that of its surface in m2."""
        radiance = self.radiance()
        if not self.light.GetNormalizeAttr().Get(self.source.first):
            radiance = radiance * area[:, None]
        return of_normalised(radiance)

    def _sun(self) -> Lamp:
        degrees = self.number("angle", 0.53)
        angles = np.radians(degrees) / (BLENDER_ANGLE if self.blenders else 1.0)
        area = np.where(angles > 0, math.pi * np.sin(0.5 * angles) ** 2, 1.0)
        irradiance = self.power(lambda radiance: radiance / (BLENDER_SUN if self.blenders else 1.0), area)
        lamp = Lamp(self._light("directional", irradiance), {"angle": angles[0]} if angles.max() > 0 else {})
        self._carry(lamp, "strength_w_m2", irradiance)
        if angles.max() > 0:
            self._carry(lamp, "angle", angles[:, None])
        return lamp

    def _sphere(self) -> Lamp:
        radius = self.number("radius", 0.5) * self.source.metres
        intensity = self.power(lambda radiance: radiance / 4, 4 * math.pi * radius**2)
        is_point = bool(UsdLux.SphereLight(self.prim).GetTreatAsPointAttr().Get())
        lamp = Lamp(self._light("point", intensity), {} if is_point else {"radius": radius[0]})
        self._carry(lamp, "power_w", intensity * 4 * math.pi)
        if not is_point:
            self._carry(lamp, "radius", radius[:, None])
        angle = self.prim.GetAttribute("inputs:shaping:cone:angle")
        if angle and angle.HasAuthoredValue():
            self._shape(lamp, angle)
        return lamp

    def _shape(self, lamp: Lamp, angle: Usd.Attribute) -> None:
        softness = self.prim.GetAttribute("inputs:shaping:cone:softness")
        self.codes = codes_of([angle, softness] if softness else [angle], self.source.codes)
        outer = np.radians(self.number("shaping:cone:angle", 90.0))
        blend = np.clip(self.number("shaping:cone:softness", 0.0), 0.0, 1.0)
        if outer[0] > math.pi / 2:
            self.lost.add("usd-light-cone", self.prim.GetPath(), "a cone wider than a half space shines to all sides")
            return
        outer = np.clip(outer, 1e-4, math.pi / 2)
        inner = outer[0] * (1 - max(blend[0], NARROWEST_EDGE))
        lamp.light.update(type="spot", spot={"innerConeAngle": inner, "outerConeAngle": outer[0]})
        self._carry(lamp, "outer_angle", outer[:, None])
        self._carry(lamp, "blend", blend[:, None])

    def _area(self, kind: str) -> Lamp:
        is_disk = kind == "DiskLight"
        width = 2 * self.number("radius", 0.5) if is_disk else self.number("width", 1.0)
        height = width if is_disk else self.number("height", 1.0)
        # The prim's own scale counts, and so does the stage's unit.
        world = np.array(UsdGeom.Xformable(self.prim).ComputeLocalToWorldTransform(self.source.first))[:3, :3]
        scale = np.linalg.norm(np.cross(world[0], world[1])) * self.source.metres**2
        area = width * height * scale * (math.pi / 4 if is_disk else 1.0)
        power = self.power(lambda radiance: radiance * math.pi, area)
        brightest = max(power[0].max(), 0.0)
        extras = {
            "type": "area",
            "shape": "ellipse" if is_disk else "rectangle",
            "size": [width[0], height[0]],
            "power_w": brightest,
            "color": (power[0] / brightest if brightest > 0 else np.ones(3)).tolist(),
        }
        lamp = Lamp(None, extras)
        self._carry(lamp, "power_w", power)
        self._carry(lamp, "width", width[:, None])
        self._carry(lamp, "height", height[:, None])
        return lamp

    def _light(self, kind: str, power: np.ndarray) -> dict:
        brightest = power[0].max()
        color = power[0] / brightest if brightest > 0 else np.ones(3)
        return {"type": kind, "color": color.tolist(), "intensity": float(brightest * LUMENS_PER_WATT)}

    def _carry(self, lamp: Lamp, name: str, rows: np.ndarray) -> None:
        if len(rows) > 1 and np.ptp(rows, axis=0).max() > 0:
            lamp.carried[name] = self.codes, rows
