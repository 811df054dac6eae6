"""Disc of a Sky Texture as a sun, as a picture of the sky would blur half a degree over its texels.

In goes a world, out come the world without its disc, and the sun. Invariant: both together are the world;
a disc with an unusual mapping stays in it.
"""

import json
import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass

import bpy
import mathutils
import numpy

from . import world_picture
from .evaluated import places
from .evaluated.document import Document
from .evaluated.lights import LUMENS_PER_WATT
from .materials import bake, links

NAME = "sun of the sky"
# Pixels of a square picture around the disc, its width in disc diameters, and samples.
PIXELS, WIDTHS, SAMPLES = 64, 3.0, 64


@dataclass
class Sun:
    """Direction, full angle of the disc, and irradiance, W/m2."""

    towards: tuple[float, float, float]
    angle: float
    irradiance: tuple[float, float, float]


def disc_of(world: bpy.types.World | None) -> bpy.types.Node | None:
    """Node whose disc can be separated; None if there is none, or several."""
    discs = discs_in(world.node_tree) if world and world.node_tree else []
    if len(discs) != 1:
        return None
    vector = discs[0].inputs.get("Vector")
    return None if vector and links.link_to(vector) else discs[0]


def discs_in(tree: bpy.types.NodeTree) -> list[bpy.types.Node]:
    return [node for node in tree.nodes if node.type == "TEX_SKY" and has_disc(node)]


def has_disc(node: bpy.types.Node) -> bool:
    has_one = getattr(node, "sun_disc", False) and "SCATTERING" in node.sky_type
    return bool(has_one or node.sky_type == "NISHITA")


@contextmanager
def without_disc(world: bpy.types.World) -> Iterator[bpy.types.World]:
    """World without its disc, during a block."""
    disc = disc_of(world)
    if disc is None:
        yield world
        return
    copy = world.copy()
    try:
        copy.node_tree.nodes[disc.name].sun_disc = False
        yield copy
    finally:
        bpy.data.worlds.remove(copy)


def of(world: bpy.types.World | None, frame: float) -> Sun | None:
    """Sun in the sky at a frame; None without one. Results are cached by content."""
    disc = disc_of(world)
    if disc is None:
        return None
    kept = bake.folder() / f"{world_picture.key_of(world, frame)}.sun.json"
    if not world_picture.is_known(world, kept):
        found = looked_at(world, frame, disc)
        beside = kept.with_suffix(".tmp")
        beside.write_text(json.dumps(found and asdict(found)))
        beside.replace(kept)
    said = json.loads(kept.read_text())
    return Sun(**said) if said else None


def looked_at(world: bpy.types.World, frame: float, disc: bpy.types.Node) -> Sun | None:
    angle = min(disc.sun_size, math.radians(60.0))
    towards = mathutils.Vector((0.0, math.cos(disc.sun_elevation), math.sin(disc.sun_elevation)))
    towards.rotate(mathutils.Euler((0.0, 0.0, -disc.sun_rotation)))
    view = world_picture.View((PIXELS, PIXELS), SAMPLES, tuple(towards), WIDTHS * angle)
    with_disc = world_picture.pixels(world, frame, view)
    with without_disc(world) as rest:
        light = with_disc - world_picture.pixels(rest, frame, view)
    across = (numpy.arange(PIXELS) + 0.5) / PIXELS * 2.0 - 1.0
    x, y = numpy.meshgrid(*2 * [across * math.tan(0.5 * WIDTHS * angle)])
    # Solid angle of a pixel in a plane at distance 1, weighted by the cosine at a facing surface.
    solid_angle = (2.0 * math.tan(0.5 * WIDTHS * angle) / PIXELS) ** 2 / (1.0 + x**2 + y**2) ** 2
    irradiance = (numpy.maximum(light, 0.0) * solid_angle[..., None]).sum(axis=(0, 1))
    return Sun(tuple(towards), angle, tuple(irradiance.tolist())) if irradiance.max() > 0.0 else None


def add(document: Document, sun: Sun, exposure: float) -> None:
    """Adds the sun as a light of the file."""
    strength = exposure * max(sun.irradiance)
    color = [channel * exposure / strength for channel in sun.irradiance]
    light = {"name": NAME, "type": "directional", "color": color, "intensity": strength * LUMENS_PER_WATT}
    turn = (-mathutils.Vector(sun.towards)).to_track_quat("-Z", "Y").to_matrix().to_4x4()
    parts = places.parts(places.in_gltf(numpy.array(turn, float)[None], looks=True))
    said = {
        "angle": sun.angle, "strength_w_m2": strength, "visible_to_camera": True, "limb_darkening": 0.6,
    }
    document.add("nodes", {
        "name": NAME, "rotation": parts.rotation[0].tolist(), "extras": {"sunfleck_light": said},
        "extensions": {"KHR_lights_punctual": {"light": document.light(light)}},
    })
