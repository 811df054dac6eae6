"""Mitsuba 3: `volpath` with two segments, which is direct light and single scattering."""

from __future__ import annotations

import time

import mitsuba as mi
import numpy

from .mitsuba_lights import lamp_emitter, sun_emitter
from .scene import Fog, PeerScene, Surface

# Cuts so little fog off in front of the camera that no figure shows it.
NEAR_M = 1e-4


def version() -> str:
    """Of Mitsuba."""
    return mi.__version__


def select(variant: str) -> None:
    """Raises `ImportError` if this installation has no such variant, or not what it is compiled by."""
    mi.set_variant(variant)


def prepare(scene: PeerScene, variant: str):
    """Builds the scene; what comes back renders so many samples a pixel, and returns the picture and CPU seconds."""
    select(variant)
    # Mitsuba's cameras look along +Z with +X to the left.
    turned = scene.world_from_camera @ numpy.diag([-1.0, 1.0, -1.0, 1.0])
    sensor = pinhole(mi.ScalarTransform4f(turned), float(numpy.degrees(scene.fov_y_rad)), scene.size)
    described = {
        "type": "scene",
        "integrator": {"type": "volpath", "max_depth": 2, "rr_depth": 100, "hide_emitters": True},
        "sensor": sensor,
    }
    middle, radius = bounds(scene)
    emitters = [sun_emitter(sun, middle, radius) for sun in scene.suns] + [lamp_emitter(lamp) for lamp in scene.lamps]
    described.update({f"light_{index}": emitter for index, emitter in enumerate(emitters)})
    if scene.fog is not None:
        fog = medium(scene.fog)
        described["fog_box"] = {
            "type": "cube",
            "to_world": mi.ScalarTransform4f(scene.fog.world_from_cube),
            "bsdf": {"type": "null"},
            "interior": fog,
        }
        cube_from_camera = numpy.linalg.inv(scene.fog.world_from_cube) @ scene.world_from_camera
        if numpy.abs(cube_from_camera[:3, 3]).max() <= 1.0:
            sensor["medium"] = fog
    for index, surface in enumerate(scene.surfaces):
        described[f"surface_{index}"] = mesh(surface)
    built = mi.load_dict(described)

    def render(samples: int, seed: int):
        started = time.process_time()
        picture = numpy.array(mi.render(built, spp=samples, seed=seed))
        return picture, time.process_time() - started

    # Compiles the kernels.
    render(1, 99)
    return render


def pinhole(to_world, fov_y_deg: float, size: tuple[int, int]) -> dict:
    """A sensor whose pixels are means over their area, in linear RGB."""
    return {
        "type": "perspective",
        "fov": fov_y_deg,
        "fov_axis": "y",
        "near_clip": NEAR_M,
        "to_world": to_world,
        "film": {
            "type": "hdrfilm",
            "width": size[0],
            "height": size[1],
            "rfilter": {"type": "box"},
            "component_format": "float32",
            "pixel_format": "rgb",
        },
        "sampler": {"type": "independent"},
    }


def bounds(scene: PeerScene) -> tuple[numpy.ndarray, float]:
    """Middle and radius of a sphere around surfaces, fog and camera."""
    points = [surface.positions for surface in scene.surfaces] + [scene.world_from_camera[None, :3, 3]]
    if scene.fog is not None:
        corners = numpy.array([[x, y, z, 1] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
        points.append((corners @ scene.fog.world_from_cube.T)[:, :3])
    low, high = (function([function(each, axis=0) for each in points], axis=0) for function in (numpy.min, numpy.max))
    return 0.5 * (low + high), 0.5 * float(numpy.linalg.norm(high - low))


def medium(fog: Fog) -> dict:
    """Fog that fills a shape evenly."""
    return {
        "type": "homogeneous",
        "sigma_t": {"type": "rgb", "value": fog.density_per_m},
        "albedo": {"type": "rgb", "value": fog.albedo},
        "phase": {"type": "hg", "g": fog.anisotropy},
    }


def mesh(surface: Surface):
    """Triangles with flat normals, seen from both sides."""
    matte = {"type": "diffuse", "reflectance": {"type": "rgb", "value": surface.reflectance}}
    properties = mi.Properties()
    properties["bsdf"] = mi.load_dict({"type": "twosided", "bsdf": matte})
    properties["face_normals"] = True
    built = mi.Mesh("mesh", len(surface.positions), len(surface.triangles), props=properties)
    parameters = mi.traverse(built)
    parameters["vertex_positions"] = surface.positions.astype(numpy.float32).ravel()
    parameters["faces"] = surface.triangles.astype(numpy.uint32).ravel()
    parameters.update()
    return built
