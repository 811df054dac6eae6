"""Lights as UsdLux, all normalized: their power does not depend on their size.

UsdLux has a radiance `intensity * color`, divided by the light's area where `normalize` is on. So a
Lambertian light of P watts has the intensity P / pi. A sphere of I W/sr, which emits 4 pi I, has 4 I, and
a sun its irradiance. See https://openusd.org/release/user_guides/schemas/usdLux/usdLux_toc.html. Blender
5.0 agrees except for suns: it reads four times the intensity as W/m2, and twice the disc's angle.
`for_blender` writes its values.
"""

import math

import numpy as np
from pxr import Gf, Vt

from ..gltf.lights import LightSource
from ..gltf.nodes import Node
from ..gltf.scene import Control, Gltf
from .prims import Prim, Types, vectors
from .samples import Sampler, thinned

PRIMS = {
    "directional": "DistantLight", "point": "SphereLight", "spot": "SphereLight", "disc": "DiskLight", "rectangle": "RectLight",
}  # fmt: skip
POINT_RADIUS = 1e-3
BLENDER_SUN, BLENDER_ANGLE = 0.25, 0.5


def kind_of(node: Node, gltf: Gltf) -> str | None:
    """Type of prim for a node's light."""
    kind = LightSource(node, gltf).kind
    return None if kind is None else PRIMS[kind]


def shows_picture(node: Node) -> bool:
    """Whether a sun's disc has non-uniform radiance."""
    light = node.extras.group("sunfleck_light")
    return any(light.member(field) is not None for field in ("image", "fractal", "limb_darkening"))


def write_light(prim: Prim, kind: str, node: Node, gltf: Gltf, sampler: Sampler, for_blender: bool) -> None:
    """Writes the light of a node."""
    _Light(prim, node, gltf, sampler, for_blender).write(kind)


class _Light:
    def __init__(self, prim: Prim, node: Node, gltf: Gltf, sampler: Sampler, for_blender: bool):
        self.prim, self.sampler, self.for_blender = prim, sampler, for_blender
        self.source = LightSource(node, gltf)
        self.ours = self.source.ours

    def _control(self, field: str) -> Control | None:
        return self.source.gltf.control(self.source.node.name, f"sunfleck_light.{field}")

    def write(self, kind: str) -> None:
        self.prim.set("inputs:normalize", Types.Bool, True)
        if kind == "DistantLight":
            self._sun()
        elif kind == "SphereLight":
            self._sphere()
        else:
            self._area(kind)
        if self.ours.raw:
            self.prim.remember({"sunfleck_light": self.ours.raw})

    def _sun(self) -> None:
        irradiance = self.source.power()
        scale = BLENDER_SUN if self.for_blender else 1.0
        first = self._power("strength_w_m2", irradiance, 1.0, scale)
        angle = self.ours.number_at("angle", 0.0, 0.0, math.pi)
        turn = BLENDER_ANGLE if self.for_blender else 1.0
        self._number("inputs:angle", "angle", angle, lambda values: np.degrees(values) * turn)
        self.prim.remember({"irradiance_w_per_m2": first.tolist(), "angular_diameter_rad": angle})

    def _sphere(self) -> None:
        intensity = self.source.power()
        first = self._power("power_w", intensity, 4 * math.pi, 4.0)
        radius = self.ours.number_at("radius", 0.0, 0.0)
        if radius == 0 and self._control("radius") is None:
            self.prim.set("treatAsPoint", Types.Bool, True)
            self.prim.set("inputs:radius", Types.Float, POINT_RADIUS)
        else:
            self._number("inputs:radius", "radius", radius)
        if self.source.kind == "spot":
            outer, blend = self.source.cone()
            self.prim.apply("ShapingAPI")
            self._number("inputs:shaping:cone:angle", "outer_angle", outer, np.degrees)
            self._number("inputs:shaping:cone:softness", "blend", blend)
        self.prim.remember({"intensity_w_per_sr": first.tolist()})

    def _area(self, kind: str) -> None:
        first = self._power("power_w", self.source.power(), 1.0, 1 / math.pi)
        width, height = self.source.size()
        if kind == "RectLight":
            self._number("inputs:width", "width", width)
            self._number("inputs:height", "height", height)
        else:
            self._number("inputs:radius", "width", width, lambda values: 0.5 * values)
            if width != height and width > 0:
                self.prim.set("xformOp:scale:ellipse", Types.Float3, Gf.Vec3f(1.0, height / width, 1.0))
                said = self.prim.spec.attributes.get("xformOpOrder")
                order = Vt.TokenArray([*((said and said.default) or []), "xformOp:scale:ellipse"])
                if said:
                    said.default = order
                else:
                    self.prim.set("xformOpOrder", Types.TokenArray, order, uniform=True)
        self.prim.remember({"power_w": first.tolist()})

    def _power(
        self, field: str, still: np.ndarray, carried_per_unit: float, intensity_per_unit: float
    ) -> np.ndarray:
        """Writes intensity and colour; returns the first value."""
        control = self._control(field)
        codes, rows = self.sampler.frames[:1], still[None]
        if control is not None:
            # A scalar multiplies the light's colour.
            color = 1.0 if control.axis is None else self.source.color()
            at = lambda times_s: control.at(times_s) / carried_per_unit * color
            codes, rows = self.sampler.rows(control.curve, at)
        brightest = rows.max(axis=1)
        colors = np.where(
            brightest[:, None] > 0, rows / np.where(brightest > 0, brightest, 1.0)[:, None], 1.0
        )
        self.prim.animate("inputs:intensity", Types.Float, codes, (brightest * intensity_per_unit).tolist())
        self.prim.animate("inputs:color", Types.Color3f, *_made(codes, colors))
        return rows[0]

    def _number(self, name: str, field: str, still: float, convert=lambda values: values) -> None:
        codes, numbers = self.sampler.numbers(self._control(field), still)
        self.prim.animate(name, Types.Float, codes, convert(numbers).tolist())


def _made(codes, colors):
    codes, colors = thinned(codes, colors)
    return codes, vectors(Vt.Vec3fArray, colors)
