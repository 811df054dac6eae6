"""Lights at a moment, for other renderers.

Invariant: a lamp's placement has rotation and position only; the node's scale is included in its size.
"""

import math
from dataclasses import dataclass

import numpy as np

from ..gltf.lights import LightSource


@dataclass
class Sun:
    """Irradiance in W/m^2 on a plane that faces it, from a disc seen under an angle (0: parallel light)."""

    to_sun: np.ndarray
    irradiance: np.ndarray
    angle_rad: float


@dataclass
class Lamp:
    """A `point` or `spot` of `power` in W/sr, perhaps with a radius, or a `rectangle` or `disc` of `power`
    in W; it emits along -z."""

    kind: str
    world_from_lamp: np.ndarray
    power: np.ndarray
    radius_m: float = 0.0
    size_m: tuple[float, float] = (0.0, 0.0)
    outer_rad: float = 0.0
    blend: float = 0.0


def read_light(source: LightSource, world_from_node: np.ndarray, time_s: np.ndarray) -> Sun | Lamp:
    """Light of a node."""
    node, gltf, ours = source.node, source.gltf, source.ours

    def changed(field: str) -> np.ndarray | None:
        control = gltf.control(node.name, f"sunfleck_light.{field}")
        return None if control is None else control.at(time_s)[0]

    def number(field: str, still: float) -> float:
        found = changed(field)
        return still if found is None else float(found[0])

    def power(field: str, carried_per_unit: float) -> np.ndarray:
        found = changed(field)
        if found is None:
            return source.power()
        # A scalar multiplies the light's colour.
        return found / carried_per_unit * (source.color() if len(found) == 1 else 1.0)

    scales = np.linalg.norm(world_from_node[:3, :3], axis=0)
    place = world_from_node.copy()
    place[:3, :3] /= scales
    kind = source.kind
    if kind == "directional":
        said = ours.member("strength_w_m2")
        irradiance = power("strength_w_m2", 1.0)
        if said is not None and changed("strength_w_m2") is None:
            irradiance = source.color() * said.number(0.0)
        return Sun(place[:3, 2], irradiance, number("angle", ours.number_at("angle", 0.0, 0.0, math.pi)))
    if kind in ("point", "spot"):
        lamp = Lamp(
            kind, place, power("power_w", 4 * math.pi), number("radius", ours.number_at("radius", 0.0, 0.0))
        )
        if kind == "spot":
            outer, blend = source.cone()
            lamp.outer_rad, lamp.blend = number("outer_angle", outer), number("blend", blend)
        return lamp
    assert kind is not None, "whoever asks has seen a light"
    width, height = source.size()
    size = number("width", width) * scales[0], number("height", height) * scales[1]
    return Lamp(kind, place, power("power_w", 1.0), size_m=size)
