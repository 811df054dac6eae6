"""Lights as Mitsuba's emitters. Lights without an equivalent are refused.

Mitsuba has no sun with a disc, so it becomes a distant disc. Its radiance is E / (pi sin^2(half angle)),
that of a sphere I / (pi r^2), that of a flat lamp P / (pi area). Mitsuba's spheres are black and cast
shadows, unlike Sunfleck's lamps: 28 of 5 cm take 1 % of each other's light.
"""

import mitsuba as mi
import numpy

from ..errors import SceneError
from .lamps import Lamp, Sun
from .mitsuba_pictures import colors
from .pictures import PeerSky

SUN_DISTANCE = 1e3
"""Distance in radii of the scene: the disc's direction is constant in the scene to a thousandth."""
HARDEST_BLEND = 1e-5
"""Minimum blend of Mitsuba's spots, whose two angles must differ; glTF's are in single precision."""
# Mitsuba's rectangles, discs and spots emit along +z.
TURNED = numpy.diag([-1.0, 1.0, -1.0, 1.0])


def sun_emitter(sun: Sun, middle: numpy.ndarray, radius: float) -> dict:
    """Sun for a scene within a sphere."""
    if sun.angle_rad == 0:
        return {
            "type": "directional",
            "direction": (-sun.to_sun).tolist(),
            "irradiance": _rgb(sun.irradiance),
        }
    distance, half = SUN_DISTANCE * radius, 0.5 * sun.angle_rad
    side = numpy.cross(sun.to_sun, numpy.eye(3)[numpy.abs(sun.to_sun).argmin()])
    side /= numpy.linalg.norm(side)
    place = numpy.eye(4)
    place[:3, :3] = (
        numpy.stack([side, numpy.cross(-sun.to_sun, side), -sun.to_sun], axis=1) * distance * numpy.tan(half)
    )
    place[:3, 3] = middle + distance * sun.to_sun
    return _shape("disk", place, sun.irradiance / (numpy.pi * numpy.sin(half) ** 2))


def lamp_emitter(lamp: Lamp) -> dict:
    """A lamp."""
    place = lamp.world_from_lamp @ TURNED
    if lamp.kind == "point" and lamp.radius_m == 0:
        return {"type": "point", "position": place[:3, 3].tolist(), "intensity": _rgb(lamp.power)}
    if lamp.kind == "point":
        sphere = place @ numpy.diag([lamp.radius_m] * 3 + [1.0])
        return _shape("sphere", sphere, lamp.power / (numpy.pi * lamp.radius_m**2))
    if lamp.kind == "spot":
        if lamp.radius_m > 0 or lamp.blend > HARDEST_BLEND:
            raise SceneError(
                "Mitsuba gets spots without a radius and without a blend: its own fade otherwise"
            )
        degrees = float(numpy.degrees(lamp.outer_rad))
        angles = {"cutoff_angle": degrees, "beam_width": degrees * (1 - HARDEST_BLEND)}
        return {
            "type": "spot",
            "to_world": mi.ScalarTransform4f(place),
            "intensity": _rgb(lamp.power),
            **angles,
        }
    width, height = lamp.size_m
    area = width * height * (1.0 if lamp.kind == "rectangle" else 0.25 * numpy.pi)
    scaled = place @ numpy.diag([0.5 * width, 0.5 * height, 1.0, 1.0])
    return _shape("rectangle" if lamp.kind == "rectangle" else "disk", scaled, lamp.power / (numpy.pi * area))


def sky_emitter(sky: PeerSky) -> dict:
    """Sky. Mitsuba's pictures have +z in the centre and -x to the right of it, half a turn from glTF's."""
    if sky.picture is None:
        return {"type": "constant", "radiance": _rgb(sky.radiance)}
    bitmap = mi.Bitmap(colors(sky.picture) * numpy.float32(sky.radiance))
    turn = 180.0 + float(numpy.degrees(sky.rotation_rad))
    return {"type": "envmap", "bitmap": bitmap, "to_world": mi.ScalarTransform4f().rotate([0, 1, 0], turn)}


def _shape(kind: str, place: numpy.ndarray, radiance: numpy.ndarray) -> dict:
    emitter = {"type": "area", "radiance": _rgb(radiance)}
    return {"type": kind, "to_world": mi.ScalarTransform4f(place), "emitter": emitter}


def _rgb(values: numpy.ndarray) -> dict:
    return {"type": "rgb", "value": numpy.asarray(values, float).tolist()}
