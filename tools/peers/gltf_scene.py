"""The parts of a still .glb file that the renderers beside us need: triangles, sun, camera, fog."""

import json
import struct
from dataclasses import dataclass
from pathlib import Path

import numpy

LUMENS_PER_WATT = 683.0
COMPONENTS = {5121: numpy.uint8, 5123: numpy.uint16, 5125: numpy.uint32, 5126: numpy.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


@dataclass
class Surface:
    """Triangles in world space that share a Lambert reflectance."""

    positions: numpy.ndarray
    triangles: numpy.ndarray
    reflectance: list


@dataclass
class Fog:
    """The image of the cube [-1, 1]^3, filled evenly."""

    world_from_cube: numpy.ndarray
    density_per_m: list
    albedo: list
    anisotropy: float


@dataclass
class Scene:
    surfaces: list
    to_sun: numpy.ndarray
    irradiance: numpy.ndarray
    world_from_camera: numpy.ndarray
    fov_y_rad: float
    fog: Fog
    size: tuple


def load(path: Path) -> Scene:
    """Reads a file whose nodes stand still, with one sun, one camera and one box of fog."""
    data = path.read_bytes()
    (length,) = struct.unpack("<I", data[12:16])
    document = json.loads(data[20 : 20 + length])
    buffer = data[28 + length :]

    def accessor(index):
        described = document["accessors"][index]
        view = document["bufferViews"][described["bufferView"]]
        width = WIDTHS[described["type"]]
        start = view.get("byteOffset", 0) + described.get("byteOffset", 0)
        kind = COMPONENTS[described["componentType"]]
        values = numpy.frombuffer(buffer, kind, described["count"] * width, start)
        return values.reshape(-1, width)

    surfaces = {}
    found = {}

    def visit(index, world_from_parent):
        node = document["nodes"][index]
        if not {"translation", "rotation", "scale"}.isdisjoint(node):
            raise SystemExit(f"{path}: nodes[{index}] has no matrix; such files are not read here")
        local = numpy.array(node.get("matrix", numpy.eye(4).ravel()), float).reshape(4, 4).T
        world = world_from_parent @ local
        if "mesh" in node:
            for primitive in document["meshes"][node["mesh"]]["primitives"]:
                points = accessor(primitive["attributes"]["POSITION"]).astype(float)
                points = points @ world[:3, :3].T + world[:3, 3]
                triangles = accessor(primitive["indices"]).reshape(-1, 3)
                surfaces.setdefault(primitive["material"], []).append((points, triangles))
        extensions = node.get("extensions", {})
        if "KHR_lights_punctual" in extensions:
            found["sun"] = (world, extensions["KHR_lights_punctual"]["light"])
        if "camera" in node:
            found["camera"] = (world, node["camera"])
        if "sunfleck_fog_volume" in node.get("extras", {}):
            found["fog"] = (world, node["extras"]["sunfleck_fog_volume"])
        for child in node.get("children", []):
            visit(child, world)

    scene = document["scenes"][document.get("scene", 0)]
    for root in scene["nodes"]:
        visit(root, numpy.eye(4))

    world, number = found["sun"]
    light = document["extensions"]["KHR_lights_punctual"]["lights"][number]
    irradiance = numpy.array(light.get("color", [1.0, 1.0, 1.0])) * light["intensity"] / LUMENS_PER_WATT
    world_from_camera, number = found["camera"]
    world_from_cube, fog = found["fog"]
    density = fog["density"]
    resolution = scene.get("extras", {}).get("sunfleck", {}).get("resolution", [960, 540])
    return Scene(
        surfaces=[merged(parts, document["materials"][index]) for index, parts in surfaces.items()],
        to_sun=world[:3, 2] / numpy.linalg.norm(world[:3, 2]),
        irradiance=irradiance,
        world_from_camera=world_from_camera,
        fov_y_rad=document["cameras"][number]["perspective"]["yfov"],
        fog=Fog(
            world_from_cube,
            density if isinstance(density, list) else [density] * 3,
            fog["albedo"] if isinstance(fog["albedo"], list) else [fog["albedo"]] * 3,
            fog["anisotropy"],
        ),
        size=tuple(resolution),
    )


def merged(parts, material) -> Surface:
    """All triangles of a material in one mesh."""
    first, triangles = 0, []
    for points, own in parts:
        triangles.append(own.astype(numpy.uint32) + first)
        first += len(points)
    reflectance = material["pbrMetallicRoughness"].get("baseColorFactor", [1.0, 1.0, 1.0, 1.0])[:3]
    return Surface(numpy.concatenate([points for points, _ in parts]), numpy.concatenate(triangles), reflectance)
