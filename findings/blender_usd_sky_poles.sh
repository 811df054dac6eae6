#!/usr/bin/env bash
# Blender's USD import lays skies on their side: the zenith of a `DomeLight_1` is at the horizon where z is up.
#
# Expected: the top of the picture of a `DomeLight_1` is where `poleAxis` says, by default along the up axis of the
# stage. With z up the middle of the picture is towards -y, what is left of it towards +x. What happens: Blender 5.3.0
# turns the picture about its pole, and leaves that along y. Of a stage with z up its top is towards +y, its middle
# towards +x, and what should be at the horizon towards +x is straight below, so that a setting sun may light from
# under the ground. "Y", "scene" with y up, and the older `DomeLight`, whose pole is y always, are right. Nothing is
# said.
# Remedy: `rotation` of the *Mapping* node of the world at 0 0 90 degrees for such a light without transform; or a
# `DomeLight` with `xformOp:rotateX` = 90 in its place.
# Versions: bpy 5.3.0 with numpy 2.5.5, bpy 5.0.1 has the same (PyPI). Source: measured here;
# https://openusd.org/release/user_guides/schemas/usdLux/DomeLight_1.html (poleAxis)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 numpy==2.5.5
cat >poles.py <<'END'
import math
import os

import bpy
import numpy as np

STAGE = """#usda 1.0
(
    metersPerUnit = 1
    upAxis = "%s"
)
def %s "sky"
{
    asset inputs:texture:file = @./sky.exr@
    token inputs:texture:format = "latlong"
    %s
}
"""
WIDTH, HEIGHT = 128, 64
# Places in the picture, from left and top in parts of it: its middle, half way to the left edge, and next to the top.
MARKS = {"middle": (0.5, 0.5), "left": (0.25, 0.5), "top": (0.5, 0.05)}


def picture(path):
    """A sky with a mark of one colour for each."""
    texels = np.zeros((HEIGHT, WIDTH, 4), np.float32)
    texels[..., 3] = 1
    for channel, (u, v) in enumerate(MARKS.values()):
        texels[int(v * HEIGHT) - 1 : int(v * HEIGHT) + 1, int(u * WIDTH) - 1 : int(u * WIDTH) + 1, channel] = 1000
    image = bpy.data.images.new("sky", WIDTH, HEIGHT, float_buffer=True)
    image.pixels = texels[::-1].ravel()
    image.filepath_raw, image.file_format = os.path.abspath(path), "OPEN_EXR"
    image.save()


def directions(up, kind, pole):
    """Where the marks are in the world of Blender, as a panoramic camera that looks along y sees them."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("world")
    with open("stage.usda", "w") as file:
        file.write(STAGE % (up, kind, pole))
    bpy.ops.wm.usd_import(filepath=os.path.abspath("stage.usda"))
    camera = bpy.data.cameras.new("camera")
    camera.type, camera.panorama_type = "PANO", "EQUIRECTANGULAR"
    scene.camera = bpy.data.objects.new("camera", camera)
    scene.camera.rotation_euler = (math.pi / 2, 0, 0)
    scene.collection.objects.link(scene.camera)
    scene.render.engine, scene.cycles.samples, scene.cycles.device = "CYCLES", 16, "CPU"
    scene.cycles.use_denoising = False
    scene.render.resolution_x, scene.render.resolution_y = WIDTH, HEIGHT
    scene.view_settings.view_transform = "Raw"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = os.path.abspath("seen.exr")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath, check_existing=False)
    seen = np.array(image.pixels[:]).reshape(HEIGHT, WIDTH, 4)[::-1, :, :3]
    longitude = ((np.arange(WIDTH) + 0.5) / WIDTH - 0.5) * 2 * math.pi
    latitude = (0.5 - (np.arange(HEIGHT) + 0.5) / HEIGHT) * math.pi
    longitude, latitude = np.meshgrid(longitude, latitude)
    towards = np.stack([np.sin(longitude) * np.cos(latitude), np.cos(longitude) * np.cos(latitude), np.sin(latitude)], -1)
    means = [(towards * seen[..., [channel]]).sum((0, 1)) for channel in range(3)]
    return [mean / np.linalg.norm(mean) for mean in means]


picture("sky.exr")
MINUS_Y, X, Z = (0, -1, 0), (1, 0, 0), (0, 0, 1)
TURNED = 'float xformOp:rotateX = 90\n uniform token[] xformOpOrder = ["xformOp:rotateX"]'
SIDE = ((1, 0, 0), (0, 0, -1), (0, 1, 0))
for name, light, true, wanted in [
    ("DomeLight, y up", ("Y", "DomeLight", ""), (MINUS_Y, X, Z), (MINUS_Y, X, Z)),
    ("DomeLight, z up", ("Z", "DomeLight", ""), (Z, X, (0, 1, 0)), (Z, X, (0, 1, 0))),
    ("DomeLight_1, y up", ("Y", "DomeLight_1", ""), (MINUS_Y, X, Z), (MINUS_Y, X, Z)),
    ("DomeLight_1, z up", ("Z", "DomeLight_1", ""), (MINUS_Y, X, Z), SIDE),
    ("DomeLight_1 of pole Z, z up", ("Z", "DomeLight_1", 'uniform token poleAxis = "Z"'), (MINUS_Y, X, Z), SIDE),
    ("DomeLight turned about x, z up", ("Z", "DomeLight", TURNED), (MINUS_Y, X, Z), (MINUS_Y, X, Z)),
]:
    found = directions(*light)
    print("bpy", bpy.app.version_string, name + ":",
          "; ".join("%s %.1f %.1f %.1f" % (mark, *place) for mark, place in zip(MARKS, found)), "true:", true, flush=True)
    if max(np.abs(place - np.array(other)).max() for place, other in zip(found, wanted)) > 0.25:
        raise SystemExit("this has changed")
END
venv/bin/python poles.py 2>&1 | grep "^bpy\|changed"
