"""Lights of nodes: KHR_lights_punctual, and the renderer's `sunfleck_light`.

Invariant: powers are in W/m2 for suns, W/sr for points and spots, W for area lights, in the scene's light
units.
"""

import math

import numpy as np

from .nodes import Node
from .scene import Gltf
from .values import Value

LUMENS_PER_WATT = 683.0
ROUND = ("disk", "disc", "ellipse")


class LightSource:
    """Light of a node, if it has one (`kind` is not `None`)."""

    def __init__(self, node: Node, gltf: Gltf):
        self.node, self.gltf = node, gltf
        self.ours = node.extras.group("sunfleck_light")
        reference = node.source.extension("KHR_lights_punctual")
        self.punctual: Value | None = None
        if reference is not None:
            lights = gltf.document.group("extensions").group("KHR_lights_punctual").items("lights")
            self.punctual = reference.need("light").item_of(lights, "light")

    @property
    def kind(self) -> str | None:
        """`directional`, `point`, `spot`, `disc` or `rectangle`."""
        if self.punctual is not None:
            kind = self.punctual.text_at("type")
            if kind not in ("directional", "point", "spot"):
                self.punctual.fail(f"`{kind}` is no type of light")
            return kind
        if self.ours.text_at("type") != "area":
            return None
        return "disc" if self.ours.text_at("shape", "rectangle") in ROUND else "rectangle"

    def color(self) -> np.ndarray:
        """Colour of the light, white by default."""
        color = (self.punctual or self.ours).member("color")
        return np.array([1.0] * 3 if color is None else color.channels())

    def power(self) -> np.ndarray:
        """Power as in the file."""
        if self.punctual is None:
            return self.ours.need("power_w").number(0.0) * self.color()
        units = self.gltf.settings.light_units
        raw = 1.0 if self.kind == "directional" else 1 / (4 * math.pi)
        watts = {"spec": 1 / LUMENS_PER_WATT, "compat": 1.0, "raw": raw}
        if units not in watts:
            self.gltf.extras.group("sunfleck").fail(f"`{units}` are no light units: spec, compat or raw")
        return self.color() * (self.punctual.number_at("intensity", 1.0, 0.0) * watts[units])

    def cone(self) -> tuple[float, float]:
        """Half angle of a spot, and the fraction of it over which it fades."""
        assert self.punctual is not None, "a spot is a light of KHR_lights_punctual"
        spot = self.punctual.group("spot")
        outer = spot.number_at("outerConeAngle", math.pi / 4, 1e-9, math.pi / 2 + 1e-6)
        return outer, 1.0 - spot.number_at("innerConeAngle", 0.0, 0.0, outer) / outer

    def size(self) -> tuple[float, float]:
        """Width and height of an area light."""
        size = self.ours.need("size")
        width, height = size.numbers(2) if isinstance(size.raw, list) else [size.number()] * 2
        return width, height
