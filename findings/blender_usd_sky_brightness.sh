#!/usr/bin/env bash
# A sky loses its exposure on the way from USD into Blender, and its strength on the way out, if it has a picture.
#
# Expected: a `DomeLight` has the radiance of its picture, times `intensity`, times 2^`exposure`, as every light of
# UsdLux, and the strength of Blender's *Background* is its `intensity`. What happens: Blender 5.3.0 imports `intensity`
# and passes over `exposure`, for skies with a picture and of one colour alike: with 3 they are 8 times too dark, where
# lamps beside keep theirs. Of a sky that says neither colour nor picture, so a white one, the colour stays that of the
# world before. Blender exports a picture without any `intensity`, so that a strength of 2 or of 0.1 is 1; a sky of one
# colour has its strength. Nothing is said of any of it.
# Remedy: *Strength* times 2^exposure after import; `inputs:intensity` = *Strength* in what was exported.
# Versions: bpy 5.3.0 with numpy 2.5.5, bpy 5.0.1 has the same (PyPI). Source: measured here;
# https://openusd.org/release/api/class_usd_lux_light_a_p_i.html (exposure)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 numpy==2.5.5
cat >skies.py <<'END'
import os
import re

import bpy
import numpy as np

STAGE = """#usda 1.0
(
    metersPerUnit = 1
    upAxis = "Z"
)
def DomeLight "sky"
{
    float inputs:intensity = 2
    float inputs:exposure = %g
    %s
}
"""
PICTURE = "asset inputs:texture:file = @./even.exr@"


def new_scene():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.world = bpy.data.worlds.new("world")
    bpy.context.scene.world.use_nodes = True
    return bpy.context.scene


def seen():
    """Radiance of the sky, as Cycles draws it."""
    scene = bpy.context.scene
    scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(scene.camera)
    scene.render.engine, scene.cycles.samples, scene.cycles.device = "CYCLES", 4, "CPU"
    scene.cycles.use_denoising = False
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.view_settings.view_transform = "Raw"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = os.path.abspath("seen.exr")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath, check_existing=False)
    return np.array(image.pixels[:]).reshape(-1, 4)[:, :3].mean()


even = bpy.data.images.new("even", 64, 32, float_buffer=True)
even.pixels = np.ones(64 * 32 * 4, np.float32)
even.filepath_raw, even.file_format = os.path.abspath("even.exr"), "OPEN_EXR"
even.save()
for name, exposure, look, true, wanted in [
    ("a picture", 0, PICTURE, 2, 2), ("a picture", 3, PICTURE, 16, 2),
    ("one colour", 3, "color3f inputs:color = (1, 1, 1)", 16, 2),
    ("no word on its colour", 3, "", 16, 0.1),
]:
    new_scene()
    with open("sky.usda", "w") as file:
        file.write(STAGE % (exposure, look))
    bpy.ops.wm.usd_import(filepath=os.path.abspath("sky.usda"))
    found = seen()
    print("bpy", bpy.app.version_string, "reads a sky of", name, "with exposure %g: radiance %.2f, true: %g"
          % (exposure, found, true), flush=True)
    if abs(found - wanted) > 0.02:
        raise SystemExit("this has changed")

for name, strength, wanted in [("a picture", 2.0, None), ("a picture", 0.1, None), ("one colour", 2.0, 2.0)]:
    nodes = new_scene().world.node_tree.nodes
    background = nodes["Background"]
    background.inputs["Strength"].default_value = strength
    if name == "a picture":
        picture = nodes.new("ShaderNodeTexEnvironment")
        picture.image = bpy.data.images.load(os.path.abspath("even.exr"))
        bpy.context.scene.world.node_tree.links.new(picture.outputs["Color"], background.inputs["Color"])
    bpy.ops.wm.usd_export(filepath=os.path.abspath("written.usda"))
    with open("written.usda") as file:
        found = re.findall(r"inputs:(?:intensity|exposure) = ([\d.]+)", file.read())
    print("bpy", bpy.app.version_string, "writes a sky of", name, "of strength %g with intensity:" % strength,
          found[0] if found else "nothing, which is 1", flush=True)
    if found != ([] if wanted is None else ["%g" % wanted]):
        raise SystemExit("this has changed")
END
venv/bin/python skies.py 2>&1 | grep "^bpy\|changed"
