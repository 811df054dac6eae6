"""Lights in glTF's units: KHR_lights_punctual, an area light as a node with `sunfleck_light`.

In go evaluated lights, out come numbers. Invariant: one W/m2 or W/sr is 683 lux or candela ("spec"), as in
Blender's exporter.
"""

import math
from typing import Any

import bpy

from ..materials import closures, links, principled
from ..materials.colours import rec709
from ..materials.sources import BLACK, NotSimple

LUMENS_PER_WATT = 683.0
# Minimum full angle, radians.
NARROWEST_SPREAD = 0.01
Scale = tuple[float, float, float]


def power_w(light: bpy.types.Light, scale: Scale = (1.0, 1.0, 1.0)) -> float:
    """Blender's watts, or for a sun W/m2, of an equivalent normalized light: exposure and size included."""
    power: float = light.energy * 2.0**light.exposure
    if light.type == "AREA" and extent(light, scale) == 0.0:
        return 0.0
    return power if light.normalize else power * extent(light, scale)


def extent(light: bpy.types.Light, scale: Scale) -> float:
    """Factor on the power of a light that is not normalized: its area, m2, or for a sun the projected
    solid angle of its disc."""
    if light.type == "SUN":
        return math.pi * math.sin(0.5 * light.angle) ** 2 or 1.0
    if light.type == "AREA":
        width, height = area_size(light)
        shape = math.pi / 4.0 if light.shape in {"DISK", "ELLIPSE"} else 1.0
        return width * height * scale[0] * scale[1] * shape
    # A sphere's, also of a lamp with soft falloff, which is a disc that faces each lit point.
    return 4.0 * (math.pi * float(light.shadow_soft_size) ** 2 or 1.0)


def area_size(light: bpy.types.Light) -> tuple[float, float]:
    return light.size, light.size_y if light.shape in {"RECTANGLE", "ELLIPSE"} else light.size


def written_size(light: bpy.types.Light) -> list[float]:
    """Size of an area light; next to nothing in place of 0, where it emits nothing."""
    return [max(1e-6, side) for side in area_size(light)]


def spread(light: bpy.types.Light) -> float:
    """Full angle of the beam of an area light."""
    return max(NARROWEST_SPREAD, float(light.spread))


def color(light: bpy.types.Light) -> tuple[float, ...]:
    """Colour with temperature and nodes, in linear Rec. 709."""
    warmth = light.temperature_color if light.use_temperature else (1.0, 1.0, 1.0)
    factor = of_nodes(light) or (1.0, 1.0, 1.0)
    found: tuple[float, ...] = rec709(tuple(a * b * c for a, b, c in zip(light.color, warmth, factor)))
    return found


def of_nodes(light: bpy.types.Light) -> tuple[float, ...] | None:
    """Factor of a light's nodes: one Emission with a colour and a strength. None for anything else."""
    if not (light.use_nodes and light.node_tree):
        return (1.0, 1.0, 1.0)
    output = principled.output_of(light.node_tree)
    link = links.link_to(output.inputs["Surface"]) if output else None
    if link is None:
        return (0.0, 0.0, 0.0)
    try:
        surface = closures.read(link)
    except NotSimple:
        return None
    sources = [surface.sources.get(name) for name in ("emission", "emission_strength")]
    is_light = surface.sources["base"] == BLACK and None not in sources
    if surface.losses or not is_light or not all(source.is_constant() for source in sources):
        return None
    tint, strength = sources[0].factor, sources[1].number()
    return tuple(max(0.0, channel * strength) for channel in tint)


def punctual(light: bpy.types.Light, exposure: float = 1.0) -> dict[str, Any] | None:
    """glTF's light times `exposure`; None for area lights."""
    if light.type == "AREA":
        return None
    unit = LUMENS_PER_WATT if light.type == "SUN" else LUMENS_PER_WATT / (4.0 * math.pi)
    channels = [max(0.0, channel) for channel in color(light)]
    # glTF's colours are at most 1.
    largest = max(1.0, *channels)
    said = {
        "name": light.name,
        "color": [channel / largest for channel in channels],
        "intensity": max(0.0, power_w(light)) * largest * unit * exposure,
    }
    if light.type == "SPOT":
        outer = min(0.5 * light.spot_size, math.pi / 2.0)
        return {
            **said,
            "type": "spot",
            "spot": {"innerConeAngle": outer * (1.0 - light.spot_blend), "outerConeAngle": outer},
        }
    return {**said, "type": "directional" if light.type == "SUN" else "point"}
