"""Cycles, as the module `bpy`: no bounces, which is direct light and single scattering."""

import tempfile
import time
from pathlib import Path

import bpy
import mathutils
import numpy

from ..errors import SceneError
from .lamps import Lamp, Sun
from .pictures import Picture, PeerSky
from .scene import PeerScene

# A near clipping distance so small that the fog it cuts off has no visible effect.
NEAR_M = 1e-4
# From glTF's axes (Y up) to Blender's (Z up).
BLENDER_FROM_GLTF = numpy.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]], float)


def version() -> str:
    """Version of Blender."""
    return bpy.app.version_string


def select(denoiser: str | None = None) -> None:
    """Accepts any installation, which has both kinds: plain, and with a denoiser."""


def build(scene: PeerScene, denoiser: str | None = None):
    """Blender scene with its render settings; `denoiser` is Blender's name for one."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    made = bpy.context.scene
    folder = Path(tempfile.mkdtemp())
    for index, surface in enumerate(scene.surfaces):
        points = surface.positions @ BLENDER_FROM_GLTF[:3, :3].T
        picture = surface.texture and image_of(surface.texture.picture, folder)
        material = matte(surface.reflectance, picture, surface.texture)
        add_mesh(made, f"surface_{index}", points, surface.triangles, material, surface.uvs)
    if scene.sky is not None:
        add_sky(made, scene.sky, folder)
    if scene.fog is not None:
        add_fog(made, scene.fog)
    for sun in scene.suns:
        add_sun(made, sun)
    for lamp in scene.lamps:
        add_lamp(made, lamp)
    add_camera(made, scene)
    settings(made, scene.size, scene.bounces)
    if denoiser is not None:
        # Blender's defaults: guided by albedo and normals, prefiltered accurately.
        made.cycles.use_denoising, made.cycles.denoiser = True, denoiser
    return made


def write(made, samples: int, seed: int, target: Path) -> None:
    """Renders a file with a number of samples a pixel."""
    made.cycles.samples, made.cycles.seed = samples, seed
    made.render.filepath = str(target)
    bpy.ops.render.render(write_still=True)


def prepare(scene: PeerScene, denoiser: str | None = None):
    """Builds the scene; returns a function that renders it (`renders`)."""
    return renders(build(scene, denoiser))


def renders(made):
    """Function that renders Blender's scene with a number of samples a pixel, and returns the picture and
    CPU seconds."""
    target = Path(tempfile.mkdtemp()) / "picture.exr"

    def render(samples: int, seed: int):
        started = time.process_time()
        write(made, samples, seed, target)
        seconds = time.process_time() - started
        return pixels_of(target), seconds

    # Builds the tree, which `use_persistent_data` keeps.
    render(1, 99)
    return render


def pixels_of(path: Path):
    """Colours of a picture, rows from the top."""
    image = bpy.data.images.load(str(path), check_existing=False)
    width, height = image.size
    found = numpy.array(image.pixels[:], float).reshape(height, width, -1)[::-1, :, :3]
    bpy.data.images.remove(image)
    return found


def settings(made, size, bounces=0):
    render, cycles = made.render, made.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y = size
    render.resolution_percentage = 100
    render.use_persistent_data = True
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_depth = "32"
    render.image_settings.color_mode = "RGBA"
    cycles.device = "CPU"
    cycles.use_adaptive_sampling = cycles.use_denoising = cycles.use_auto_tile = False
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 1.0
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    # Otherwise surfaces lit indirectly would be blurred.
    cycles.blur_glossy = 0.0
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = bounces
    cycles.transmission_bounces = cycles.volume_bounces = bounces
    cycles.transparent_max_bounces = 64


def add_mesh(made, name, points, triangles, material, uvs=None):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points.tolist(), [], triangles.tolist())
    if uvs is not None:
        # From the lower left corner.
        corners = numpy.asarray(uvs, numpy.float32)[triangles.ravel()] * [1, -1] + [0, 1]
        mesh.uv_layers.new(name="uv").data.foreach_set("uv", corners.astype(numpy.float32).ravel())
    mesh.materials.append(material)
    made.collection.objects.link(bpy.data.objects.new(name, mesh))


def nodes_of(name):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    material.node_tree.nodes.clear()
    return material, material.node_tree.nodes, material.node_tree.links


def image_of(picture: Picture, folder: Path):
    image = bpy.data.images.load(str(picture.file(folder, f"image_{len(bpy.data.images)}")))
    if 0 in image.size:
        raise SceneError("Blender cannot read a picture of the scene")
    image.colorspace_settings.name = "Linear Rec.709" if picture.ending in (".exr", ".hdr") else "sRGB"
    # A texture's alpha is not used.
    image.alpha_mode = "CHANNEL_PACKED"
    return image


def scaled(nodes, links, output, factors):
    """Colour times three factors."""
    times = nodes.new("ShaderNodeVectorMath")
    times.operation = "MULTIPLY"
    links.new(output, times.inputs[0])
    times.inputs[1].default_value = [float(each) for each in factors]
    return times.outputs[0]


def matte(reflectance, image=None, texture=None):
    material, nodes, links = nodes_of("matte")
    surface, out = nodes.new("ShaderNodeBsdfDiffuse"), nodes.new("ShaderNodeOutputMaterial")
    surface.inputs["Color"].default_value = (*reflectance, 1.0)
    if image is not None:
        read = nodes.new("ShaderNodeTexImage")
        read.image = image
        read.extension = {"repeat": "REPEAT", "clamp": "EXTEND", "mirror": "MIRROR"}[texture.wrap]
        links.new(scaled(nodes, links, read.outputs["Color"], reflectance), surface.inputs["Color"])
    surface.inputs["Roughness"].default_value = 0.0
    links.new(surface.outputs[0], out.inputs["Surface"])
    return material


def add_fog(made, fog):
    material, nodes, links = nodes_of("fog")
    scatter, absorb = nodes.new("ShaderNodeVolumeScatter"), nodes.new("ShaderNodeVolumeAbsorption")
    both, out = nodes.new("ShaderNodeAddShader"), nodes.new("ShaderNodeOutputMaterial")
    for node in (scatter, absorb):
        # Scattering is density * colour, absorption density * (1 - colour).
        node.inputs["Density"].default_value = fog.density_per_m[0]
        if fog.grid is not None:
            links.new(density_of_grid(nodes, links, fog), node.inputs["Density"])
        node.inputs["Color"].default_value = (*fog.albedo, 1.0)
        if fog.albedo_grid is not None:
            read = nodes.new("ShaderNodeAttribute")
            read.attribute_name = fog.albedo_grid
            links.new(scaled(nodes, links, read.outputs["Color"], fog.albedo), node.inputs["Color"])
        links.new(node.outputs[0], both.inputs[0 if node is scatter else 1])
    scatter.inputs["Anisotropy"].default_value = fog.anisotropy
    links.new(both.outputs[0], out.inputs["Volume"])
    if fog.grid is not None:
        add_volume(made, fog, material)
        return
    corners = numpy.array([[x, y, z, 1] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    points = (corners @ (BLENDER_FROM_GLTF @ fog.world_from_cube).T)[:, :3]
    quads = numpy.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    add_mesh(made, "fog", points, quads, material)


def density_of_grid(nodes, links, fog):
    read, times = nodes.new("ShaderNodeAttribute"), nodes.new("ShaderNodeMath")
    read.attribute_name, times.operation = fog.grid[1], "MULTIPLY"
    times.inputs[1].default_value = fog.density_per_m[0]
    links.new(next(each for each in read.outputs if each.name in ("Fac", "Factor")), times.inputs[0])
    return times.outputs[0]


def add_volume(made, fog, material):
    data = bpy.data.volumes.new("fog")
    # Densities are those of the world, and not rounded to halves.
    data.filepath, data.render.space, data.render.precision = str(fog.grid[0]), "WORLD", "FULL"
    if not data.grids.load() or fog.grid[1] not in {grid.name for grid in data.grids}:
        raise SceneError(f"{fog.grid[0]}: Blender finds no grid `{fog.grid[1]}` in it")
    data.materials.append(material)
    thing = bpy.data.objects.new("fog", data)
    thing.matrix_world = mathutils.Matrix((BLENDER_FROM_GLTF @ fog.world_from_cube).tolist())
    made.collection.objects.link(thing)


def add_sky(made, sky: PeerSky, folder: Path):
    world = made.world = bpy.data.worlds.new("sky")
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    nodes.clear()
    shown, out = nodes.new("ShaderNodeBackground"), nodes.new("ShaderNodeOutputWorld")
    shown.inputs["Color"].default_value = (*sky.radiance.tolist(), 1.0)
    if sky.picture is not None:
        read, place, along = (
            nodes.new(kind)
            for kind in ("ShaderNodeTexEnvironment", "ShaderNodeMapping", "ShaderNodeTexCoord")
        )
        read.image = image_of(sky.picture, folder)
        # Blender's pictures have +x in the centre, and its mapping rotates directions.
        place.inputs["Rotation"].default_value = (0.0, 0.0, -0.5 * numpy.pi - sky.rotation_rad)
        links.new(along.outputs["Generated"], place.inputs["Vector"])
        links.new(place.outputs["Vector"], read.inputs["Vector"])
        links.new(scaled(nodes, links, read.outputs["Color"], sky.radiance), shown.inputs["Color"])
    links.new(shown.outputs[0], out.inputs["Surface"])
    lit = world.cycles_visibility
    lit.diffuse = lit.glossy = lit.transmission = sky.lights != "nothing"
    lit.scatter = sky.lights == "surfaces_and_fog"


def add_sun(made, described: Sun):
    light = bpy.data.lights.new("sun", "SUN")
    light.angle = described.angle_rad
    colour(light, described.irradiance)
    towards = mathutils.Vector((BLENDER_FROM_GLTF[:3, :3] @ described.to_sun).tolist())
    add_light(made, light).matrix_world = towards.to_track_quat("Z", "Y").to_matrix().to_4x4()


def add_lamp(made, described: Lamp):
    light = bpy.data.lights.new(
        described.kind, {"point": "POINT", "spot": "SPOT"}.get(described.kind, "AREA")
    )
    if light.type == "AREA":
        light.shape = "RECTANGLE" if described.kind == "rectangle" else "ELLIPSE"
        light.size, light.size_y = described.size_m
        colour(light, described.power)
    else:
        light.shadow_soft_size = described.radius_m
        # Soft falloff would dim a lamp at close range.
        light.use_soft_falloff = False
        colour(light, described.power * 4 * numpy.pi)
    if light.type == "SPOT":
        light.spot_size, light.spot_blend = 2 * described.outer_rad, described.blend
    add_light(made, light).matrix_world = mathutils.Matrix(
        (BLENDER_FROM_GLTF @ described.world_from_lamp).tolist()
    )


def colour(light, power):
    light.energy = float(power.max()) or 1.0
    light.color = (power / light.energy).tolist()


def add_light(made, light):
    thing = bpy.data.objects.new(light.name, light)
    thing.visible_camera = False
    made.collection.objects.link(thing)
    return thing


def add_camera(made, scene):
    data = bpy.data.cameras.new("camera")
    data.sensor_fit = "VERTICAL"
    data.angle_y = scene.fov_y_rad
    data.clip_start, data.clip_end = NEAR_M, 1e6
    camera = bpy.data.objects.new("camera", data)
    camera.matrix_world = mathutils.Matrix((BLENDER_FROM_GLTF @ scene.world_from_camera).tolist())
    made.collection.objects.link(camera)
    made.camera = camera
