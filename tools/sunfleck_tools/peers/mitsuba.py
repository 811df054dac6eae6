"""Mitsuba 3: `volpath`. A depth of two segments is direct light and single scattering; each further bounce
adds one."""

import time
from dataclasses import replace

import mitsuba as mi
import numpy

from ..errors import SceneError
from .mitsuba_grids import grid_fog
from .mitsuba_lights import lamp_emitter, sky_emitter, sun_emitter
from .mitsuba_pictures import colors
from .scene import Fog, PeerScene, Surface

# A near clipping distance so small that the fog it cuts off has no visible effect.
NEAR_M = 1e-4


def version() -> str:
    """Version of Mitsuba."""
    return str(mi.__version__)


def select(variant: str) -> None:
    """Raises `ImportError` if this installation lacks the variant or its compiler."""
    mi.set_variant(variant)


def prepare(scene: PeerScene, variant: str):
    """Builds the scene; returns a function that renders a number of samples a pixel, and returns the
    picture and CPU seconds."""
    select(variant)
    fog = None if scene.fog is None or scene.fog.grid else medium(scene.fog)
    if scene.fog is not None and scene.fog.grid:
        world_from_cube, fog = grid_fog(scene.fog)
        scene = replace(scene, fog=replace(scene.fog, world_from_cube=world_from_cube))
    # Mitsuba's cameras look along +Z, with +X to the left.
    turned = scene.world_from_camera @ numpy.diag([-1.0, 1.0, -1.0, 1.0])
    sensor = pinhole(mi.ScalarTransform4f(turned), float(numpy.degrees(scene.fov_y_rad)), scene.size)
    described = {
        "type": "scene",
        "integrator": {"type": "volpath", "max_depth": 2 + scene.bounces, "rr_depth": 100, "hide_emitters": True},
        "sensor": sensor,
    }
    if scene.sky is not None and scene.sky.lights == "surfaces" and scene.fog is not None:
        raise SceneError("Mitsuba gets no sky that lights surfaces and leaves fog dark")
    middle, radius = bounds(scene)
    emitters = [sun_emitter(sun, middle, radius) for sun in scene.suns] + [
        lamp_emitter(lamp) for lamp in scene.lamps
    ]
    described.update({f"light_{index}": emitter for index, emitter in enumerate(emitters)})
    if scene.fog is not None:
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
    lit = [] if scene.sky is None or scene.sky.lights == "nothing" else [scene.sky]
    parts = [mi.load_dict(described | {f"sky_{index}": sky_emitter(sky) for index, sky in enumerate(lit)})]
    if scene.sky is not None:
        # Lights are hidden and the sky is visible, so the sky is rendered in a separate, unlit scene.
        bare = {name: each for name, each in described.items() if not name.startswith("light_")}
        seen = {"type": "volpath", "max_depth": 1, "rr_depth": 100}
        parts.append(mi.load_dict(bare | {"integrator": seen, "sky": sky_emitter(scene.sky)}))

    def render(samples: int, seed: int):
        started = time.process_time()
        picture = sum(numpy.array(mi.render(part, spp=samples, seed=seed)) for part in parts)
        return picture, time.process_time() - started

    # Compiles the kernels.
    render(1, 99)
    return render


def pinhole(to_world, fov_y_deg: float, size: tuple[int, int]) -> dict:
    """Sensor with box-filtered pixels in linear RGB."""
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
    """Centre and radius of a sphere around surfaces, fog and camera."""
    points = [surface.positions for surface in scene.surfaces] + [scene.world_from_camera[None, :3, 3]]
    if scene.fog is not None:
        corners = numpy.array([[x, y, z, 1] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
        points.append((corners @ scene.fog.world_from_cube.T)[:, :3])
    low, high = (
        function([function(each, axis=0) for each in points], axis=0) for function in (numpy.min, numpy.max)
    )
    return 0.5 * (low + high), 0.5 * float(numpy.linalg.norm(high - low))


def medium(fog: Fog) -> dict:
    """Homogeneous fog."""
    return {
        "type": "homogeneous",
        "sigma_t": {"type": "rgb", "value": fog.density_per_m},
        "albedo": {"type": "rgb", "value": fog.albedo},
        "phase": {"type": "hg", "g": fog.anisotropy},
    }


def _reflectance(surface: Surface) -> dict:
    if surface.texture is None:
        return {"type": "rgb", "value": surface.reflectance}
    bitmap = mi.Bitmap(colors(surface.texture.picture) * numpy.array(surface.reflectance, numpy.float32))
    # Linear already.
    return {"type": "bitmap", "bitmap": bitmap, "raw": True, "wrap_mode": surface.texture.wrap}


def mesh(surface: Surface):
    """Triangles with flat normals, visible from both sides."""
    matte = {"type": "diffuse", "reflectance": _reflectance(surface)}
    properties = mi.Properties()
    properties["bsdf"] = mi.load_dict({"type": "twosided", "bsdf": matte})
    properties["face_normals"] = True
    counts = len(surface.positions), len(surface.triangles)
    built = mi.Mesh("mesh", *counts, props=properties, has_vertex_texcoords=surface.texture is not None)
    parameters = mi.traverse(built)
    parameters["vertex_positions"] = surface.positions.astype(numpy.float32).ravel()
    parameters["faces"] = surface.triangles.astype(numpy.uint32).ravel()
    if surface.texture is not None:
        parameters["vertex_texcoords"] = surface.uvs.astype(numpy.float32).ravel()
    parameters.update()
    return built
