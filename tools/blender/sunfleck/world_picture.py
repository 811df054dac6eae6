"""World of any nodes as an equirectangular picture, rendered by Cycles in an empty scene.

In go a world, a frame and a path, out comes an EXR beside it. Invariant: +Y is in its centre and +X to the right,
sunfleck's orientation; radiances are in linear Rec. 709.
"""

import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path

import bpy
import mathutils

from . import keys
from .materials import bake, colours, dependence, fingerprint
from .materials.images import texels_of
from .evaluated.geometry import digest

SAMPLES = 16
MOST_TEXELS = 2048 * 1024


@dataclass(frozen=True)
class View:
    """All directions, or a square around one, `angle` across."""

    size: tuple = (1024, 512)
    samples: int = SAMPLES
    towards: tuple = (0.0, 1.0, 0.0)
    angle: float | None = None


def key_of(world, frame, view=View()):
    """Key that changes whenever the result may."""
    how = repr((view, colours.working_space(), bpy.app.version)).encode()
    return digest(fingerprint.of_tree(world.node_tree, frame), how).hex()


def is_known(world, kept):
    """Whether a result is in the cache: of keyed nodes and films no key tells what Cycles has at the frame."""
    return kept.is_file() and not keys.changes(world) and not dependence.is_of_film(world, dependence.OF_SEVERAL_FILES)


def beside(world, frame, path):
    """Name of the file; renderings of the same nodes are cached."""
    kept = bake.folder() / f"{key_of(world, frame)}.exr"
    if not is_known(world, kept):
        with tempfile.TemporaryDirectory(dir=bake.folder()) as folder:
            made = Path(folder) / "world.exr"
            render(world, frame, made)
            made.replace(kept)
    target = path.with_name(f"{path.stem}_sky.exr")
    shutil.copyfile(kept, target)
    return target.name


def pixels(world, frame, view):
    """Radiances, (rows from the bottom, columns, 3)."""
    with tempfile.TemporaryDirectory(dir=bake.folder()) as folder:
        target = Path(folder) / "world.exr"
        render(world, frame, target, view)
        image = bpy.data.images.load(str(target))
        found = texels_of(image)[..., :3]
        bpy.data.images.remove(image)
    return found


def is_black(image):
    """Whether a picture is black all over; only those are looked at that are soon read."""
    return image.size[0] * image.size[1] <= MOST_TEXELS and not texels_of(image)[..., :3].any()


def is_black_file(path):
    image = bpy.data.images.load(str(path))
    try:
        return is_black(image)
    finally:
        bpy.data.images.remove(image)


def render(world, frame, target, view=View()):
    scene = bpy.data.scenes.new("sunfleck world")
    data = bpy.data.cameras.new("sunfleck world")
    eye = bpy.data.objects.new("sunfleck world", data)
    shown = world.copy()
    try:
        scene.collection.objects.link(eye)
        scene.camera, scene.world = eye, shown
        # Films show their picture of the frame.
        whole, part = divmod(frame, 1.0)
        scene.frame_current, scene.frame_subframe = int(whole), part
        # What lights nothing needs no map of where it is bright: two fifths of the time.
        shown.cycles.sampling_method = "NONE"
        eye.rotation_euler = mathutils.Vector(view.towards).to_track_quat("-Z", "Y").to_euler()
        if view.angle is None:
            data.type, data.panorama_type = "PANO", "EQUIRECTANGULAR"
        else:
            data.angle = view.angle
        settings = scene.render
        settings.engine, settings.resolution_percentage, settings.filepath = "CYCLES", 100, str(target)
        settings.resolution_x, settings.resolution_y = view.size
        file, cycles = settings.image_settings, scene.cycles
        file.file_format, file.color_mode, file.color_depth = "OPEN_EXR", "RGB", "32"
        cycles.samples, cycles.use_denoising, cycles.use_adaptive_sampling = view.samples, False, False
        cycles.pixel_filter_type = "BOX"
        # By its name alone a scene is rendered at the frame of the window's.
        with bpy.context.temp_override(scene=scene):
            bpy.ops.render.render(write_still=True)
        in_rec709(target)
    finally:
        bpy.data.objects.remove(eye)
        bpy.data.cameras.remove(data)
        bpy.data.scenes.remove(scene)
        bpy.data.worlds.remove(shown)


def in_rec709(target):
    """Converts the file to Rec. 709: Blender writes its working space, with an attribute that readers may
    ignore."""
    if colours.working_space() == "Linear Rec.709":
        return
    image = bpy.data.images.load(str(target))
    found = texels_of(image)
    found[..., :3] = colours.rec709(found[..., :3].reshape(-1, 3)).reshape(found[..., :3].shape)
    bpy.data.images.remove(image)
    made = bpy.data.images.new("sunfleck world", *found.shape[1::-1], float_buffer=True, is_data=True)
    made.pixels.foreach_set(found.ravel())
    made.file_format, made.filepath_raw = "OPEN_EXR", str(target)
    made.save()
    bpy.data.images.remove(made)
