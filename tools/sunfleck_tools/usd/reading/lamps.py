"""UsdLux lights as lights of glTF with `sunfleck_light`; `usd/lights.py` explains the units, and Blender's.

A light's radiance is intensity * 2^exposure * colour, divided by its area in the world where `normalize`
is on (https://openusd.org/release/api/usd_lux_page_front.html). That area is in units of the stage. A
sphere has radiance * area / 4 in W/sr, an area light pi * radiance * area in W, both with the area in m2.
So both the prim's whole transform and the stage's unit count.
"""

import math
from dataclasses import dataclass, field

import numpy as np
from pxr import Usd, UsdLux

from ...gltf.lights import LUMENS_PER_WATT
from ..lights import BLENDER_ANGLE, BLENDER_SUN
from .lamp_inputs import LampInputs
from .lamp_sizes import ball_area, instance_linears, moving_scales
from .losses import Losses
from .places import codes_of
from .properties import custom_data
from .source import Source

NARROWEST_EDGE = 1e-6
WIDEST_SUN = math.radians(179.0)
"""Maximum full angle: the renderer's limit, below 180 degrees."""
SMALLEST_AREA = 1e-30
"""Minimum area in stage units squared: a normalized light without area still has its power."""
EVEN = 1e-4
"""Tolerance of the axes of a sphere."""
ON_DISC = ("image", "fractal", "limb_darkening", "picture_rotation")
"""Fields of the radiance on a sun's disc."""


@dataclass
class Lamp:
    """glTF light with extras, and its animated fields: codes and rows."""

    light: dict | None
    extras: dict
    carried: dict[str, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)


def kept_of_lamp(prim: Usd.Prim, has_disc: bool, lost: Losses) -> dict:
    """Fields of `sunfleck_light` that UsdLux has no attributes for, from the custom data of `export-usd`."""
    kept = custom_data(prim).get("sunfleck_light")
    if not isinstance(kept, dict):
        return {}
    fields = {name: kept[name] for name in ON_DISC if has_disc and name in kept}
    if "image" in fields and not str(fields["image"]).startswith("data:"):
        lost.add("usd-light-input", prim, "its picture is a file beside another: it is not carried")
        del fields["image"]
    if kept.get("visible_to_camera") is True:
        fields["visible_to_camera"] = True
    return fields


def read_lamp(prim: Usd.Prim, source: Source, still: np.ndarray, lost: Losses) -> Lamp | None:
    """Light of a prim; None if its kind is not supported.

    `still` is the linear part of the transform to the world at the first frame, in metres, in which
    instances of one prim differ.
    """
    kind = str(prim.GetTypeName())
    reader = _Reader(prim, source, still, lost)
    if kind == "DistantLight":
        lamp = reader.sun()
    elif kind in ("SphereLight", "CylinderLight"):
        lamp = reader.ball(is_cylinder=kind == "CylinderLight")
    elif kind in ("RectLight", "DiskLight"):
        lamp = reader.area(is_disk=kind == "DiskLight")
    else:
        lost.add("usd-camera-or-light-type", prim, f"a {kind or 'light without a type'} is not carried")
        return None
    reader.inputs.say_the_rest(kind)
    return lamp


class _Reader:
    def __init__(self, prim: Usd.Prim, source: Source, still: np.ndarray, lost: Losses):
        self.prim, self.source, self.still, self.lost = prim, source, still, lost
        self.inputs = LampInputs(prim, lost)
        self.codes = codes_of([*self.inputs.attributes(), *moving_scales(prim)], source.codes)
        # Blender's conventions, both in writing and reading: units of suns; and areas that intensity is divided
        # by are in m2, whatever the stage's unit.
        self.blenders = source.by_blender or source.for_blender
        self.area_unit = source.metres**2 if self.blenders else 1.0

    def number(self, name: str, default: float) -> np.ndarray:
        """Values of a scalar input, one a code."""
        return self.inputs.numbers(name, default, self.codes)

    def linears(self) -> np.ndarray:
        """Linear part of the transform to the world in stage units, a matrix a code."""
        return instance_linears(self.prim, self.codes, self.still / self.source.metres)

    def radiance(self, size: np.ndarray) -> np.ndarray:
        """Radiance, three numbers a code, W/(m2 sr); `size` is what `normalize` divides by."""
        radiance = self.inputs.radiance(self.codes)
        if self.prim.GetAttribute("inputs:normalize").Get(self.source.first):
            radiance = radiance / size[:, None]
        return radiance

    def sun(self) -> Lamp:
        """Sun: irradiance on a facing plane is radiance times pi sin2(half its angle)."""
        angles = np.radians(np.clip(self.number("angle", 0.53), 0, 360)) / (
            BLENDER_ANGLE if self.blenders else 1.0
        )
        squares = np.sin(0.5 * np.minimum(angles, 2 * math.pi)) ** 2
        size = math.pi * np.where(angles > math.pi, 2 - squares, squares)
        size = np.where(angles > 0, size, 1.0)
        irradiance = self.radiance(size) * np.where(angles > math.pi, math.pi, size)[:, None]
        irradiance = irradiance / (BLENDER_SUN if self.blenders else 1.0)
        if angles.max() > WIDEST_SUN:
            what = "a DistantLight wider than 179 degrees is one of 179 degrees"
            self.lost.add("usd-light-shape", self.prim, what)
            angles = np.minimum(angles, WIDEST_SUN)
        lamp = Lamp(self._light("directional", irradiance), {"angle": angles[0]} if angles.max() > 0 else {})
        self._carry(lamp, "strength_w_m2", irradiance)
        if angles.max() > 0:
            self._carry(lamp, "angle", angles[:, None])
        return lamp

    def ball(self, is_cylinder: bool) -> Lamp:
        """Sphere. An ellipsoid or a cylinder becomes the sphere of equal area, which emits the same power."""
        stage_area = np.maximum(self._cylinder_area() if is_cylinder else self._sphere_area(), SMALLEST_AREA)
        area = stage_area * self.source.metres**2
        # The mean projected area of a convex body is a quarter of its surface (Cauchy).
        intensity = self.radiance(stage_area * self.area_unit) * area[:, None] / 4
        radius = np.where(stage_area > SMALLEST_AREA, np.sqrt(area / (4 * math.pi)), 0.0)
        is_point = bool(UsdLux.SphereLight(self.prim).GetTreatAsPointAttr().Get()) and not is_cylinder
        lamp = Lamp(self._light("point", intensity), {} if is_point else {"radius": radius[0]})
        self._carry(lamp, "power_w", intensity * 4 * math.pi)
        if not is_point:
            self._carry(lamp, "radius", radius[:, None])
        if self.inputs.has_cone():
            self._shape(lamp)
        return lamp

    def _sphere_area(self) -> np.ndarray:
        """Area of a sphere in the world, stage units squared, one a code."""
        axes = self.linears() * np.maximum(self.number("radius", 0.5), 0)[:, None, None]
        halves = np.linalg.svd(axes, compute_uv=False)
        if (np.ptp(halves, axis=1) > EVEN * halves.max(axis=1)).any():
            self.lost.add("usd-light-shape", self.prim, "a sphere that is stretched is one of the same area")
        return ball_area(halves)

    def _cylinder_area(self) -> np.ndarray:
        """Area of a cylinder along x without caps; its ends count as circles of their mean radius."""
        world = self.linears()
        along = np.linalg.norm(world[:, :, 0], axis=1) * np.maximum(self.number("length", 1.0), 0)
        radii = np.maximum(self.number("radius", 0.5), 0)
        around = 0.5 * np.linalg.norm(world[:, :, 1:], axis=1).sum(axis=1) * radii
        self.lost.add("usd-light-shape", self.prim, "a CylinderLight is a sphere of the same area")
        return 2 * math.pi * around * along

    def _shape(self, lamp: Lamp) -> None:
        self.codes = codes_of(self.inputs.cone_attributes(), self.source.codes)
        outer = np.radians(self.number("shaping:cone:angle", 90.0))
        softness = np.clip(self.number("shaping:cone:softness", 0.0), 0.0, 1.0)
        if outer[0] > math.pi / 2:
            if outer[0] < math.pi - 1e-6:
                what = "a cone wider than a half space shines to all sides"
                self.lost.add("usd-light-cone", self.prim, what)
            return
        outer = np.clip(outer, 1e-4, math.pi / 2)
        blend = softness if self.source.by_us or self.source.by_blender else _blend(outer, softness)
        inner = outer[0] * (1 - max(blend[0], NARROWEST_EDGE))
        assert lamp.light is not None, "a cone is asked for of lights of KHR_lights_punctual"
        lamp.light.update(type="spot", spot={"innerConeAngle": inner, "outerConeAngle": outer[0]})
        self._carry(lamp, "outer_angle", outer[:, None])
        self._carry(lamp, "blend", blend[:, None])

    def area(self, is_disk: bool) -> Lamp:
        """Rectangle or disc: its power is pi times radiance times area. The renderer scales its sides with
        the node."""
        width = np.maximum(2 * self.number("radius", 0.5) if is_disk else self.number("width", 1.0), 1e-9)
        height = width if is_disk else np.maximum(self.number("height", 1.0), 1e-9)
        world = self.linears()
        scale = np.linalg.norm(np.cross(world[:, :, 0], world[:, :, 1]), axis=1)
        stage_area = np.maximum(width * height * scale * (math.pi / 4 if is_disk else 1.0), SMALLEST_AREA)
        radiance = self.radiance(stage_area * self.area_unit)
        power = math.pi * radiance * stage_area[:, None] * self.source.metres**2
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


def _blend(outer: np.ndarray, softness: np.ndarray) -> np.ndarray:
    """Blend of the renderer: the share of 1 - cos(outer) over which a spot fades, so that it begins at
    UsdLux's (1 - softness) outer."""
    return (np.cos((1 - softness) * outer) - np.cos(outer)) / (1 - np.cos(outer))
