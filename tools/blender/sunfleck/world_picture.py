"""A world of any nodes as a picture of all directions: Cycles renders it, from where nothing else is.

In go a world and a path, out comes an EXR beside it. Invariant: its middle is +Y and its right +X, which is
how sunfleck reads pictures that are not turned; radiances are in linear Rec. 709.
"""

import math
import shutil
import tempfile
from pathlib import Path

import bpy
import numpy

from .materials import bake, colours, fingerprint
from .evaluated.geometry import digest

SIZE = (1024, 512)
SAMPLES = 16


def beside(world, path):
    """The name of the file; what was rendered of the same nodes is kept."""
    key = digest(
        fingerprint.of_tree(world.node_tree),
        repr((SIZE, SAMPLES, colours.working_space(), bpy.app.version)).encode(),
    )
    kept = bake.folder() / f"{key.hex()}.exr"
    if not kept.is_file():
        with tempfile.TemporaryDirectory(dir=bake.folder()) as folder:
            made = Path(folder) / "world.exr"
            render(world, made)
            made.replace(kept)
    target = path.with_name(f"{path.stem}_sky.exr")
    shutil.copyfile(kept, target)
    return target.name


def render(world, target):
    scene = bpy.data.scenes.new("sunfleck world")
    data = bpy.data.cameras.new("sunfleck world")
    eye = bpy.data.objects.new("sunfleck world", data)
    try:
        scene.collection.objects.link(eye)
        scene.camera, scene.world = eye, world
        eye.rotation_euler = (0.5 * math.pi, 0.0, 0.0)
        data.type, data.panorama_type = "PANO", "EQUIRECTANGULAR"
        settings = scene.render
        settings.engine, settings.resolution_percentage, settings.filepath = "CYCLES", 100, str(target)
        settings.resolution_x, settings.resolution_y = SIZE
        (
            settings.image_settings.file_format,
            settings.image_settings.color_mode,
            settings.image_settings.color_depth,
        ) = "OPEN_EXR", "RGB", "32"
        scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.use_adaptive_sampling = (
            SAMPLES,
            False,
            False,
        )
        scene.cycles.pixel_filter_type = "BOX"
        bpy.ops.render.render(write_still=True, scene=scene.name)
        in_rec709(target)
    finally:
        bpy.data.objects.remove(eye)
        bpy.data.cameras.remove(data)
        bpy.data.scenes.remove(scene)


def in_rec709(target):
    """Blender writes the working space, and says so in the file; whoever reads the file
    need not know that."""
    if colours.working_space() == "Linear Rec.709":
        return
    image = bpy.data.images.load(str(target))
    pixels = numpy.empty(SIZE[0] * SIZE[1] * 4, "f4")
    image.pixels.foreach_get(pixels)
    pixels = pixels.reshape(-1, 4)
    pixels[:, :3] = colours.rec709(pixels[:, :3])
    bpy.data.images.remove(image)
    made = bpy.data.images.new("sunfleck world", *SIZE, float_buffer=True, is_data=True)
    made.pixels.foreach_set(pixels.ravel())
    made.file_format, made.filepath_raw = "OPEN_EXR", str(target)
    made.save()
    bpy.data.images.remove(made)
