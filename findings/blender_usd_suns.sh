#!/usr/bin/env bash
# Blender reads suns of USD four times as bright and twice as wide as UsdLux has them, and writes them the other way.
#
# Expected: a `DistantLight` of intensity 10 with `normalize` gives 10 to a surface that faces it, and `angle` is its
# whole diameter, as in Blender. What happens: Blender 5.3.0 imports it as a sun of strength 40 with a diameter of 1
# degree for 0.5, so without `normalize` it is 16 times as bright. It exports a sun of strength 4 and 2 degrees with
# intensity 1 and 1 degree. Lamps are right: a `RectLight` of radiance 10 gives what it should. So suns and lamps change
# against each other on the way from or to any other program; a round trip through Blender shows nothing.
# Remedy: strength / 4 and angle / 2 after import; intensity * 4 and angle * 2 in what was exported.
# Versions: bpy 5.3.0 with numpy 2.5.5, bpy 5.0.1 has the same (PyPI). Source: measured here;
# https://openusd.org/release/user_guides/schemas/usdLux/DistantLight.html (angle, normalize)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 numpy==2.5.5
cat >suns.py <<'END'
import math
import os
import re

import bpy
import numpy as np

STAGE = """#usda 1.0
(
    metersPerUnit = 1
    upAxis = "Z"
)
def %s "light" {
    float inputs:intensity = 10
    float inputs:angle = %g
    float inputs:width = 0.1
    float inputs:height = 0.1
    bool inputs:normalize = %d
    double3 xformOp:translate = (0, 0, 2)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
"""


def irradiance(kind, angle_deg, normalize):
    """What a floor gets of a light of a USD stage that is straight above it, by Cycles."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    with open("light.usda", "w") as file:
        file.write(STAGE % (kind, angle_deg, normalize))
    bpy.ops.wm.usd_import(filepath=os.path.abspath("light.usda"))
    bpy.ops.mesh.primitive_plane_add(size=1)
    floor = bpy.data.materials.new("floor")
    floor.use_nodes = True
    nodes = floor.node_tree.nodes
    nodes.clear()
    diffuse, output = nodes.new("ShaderNodeBsdfDiffuse"), nodes.new("ShaderNodeOutputMaterial")
    diffuse.inputs["Color"].default_value = (1, 1, 1, 1)
    floor.node_tree.links.new(diffuse.outputs[0], output.inputs["Surface"])
    bpy.context.object.data.materials.append(floor)
    scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.camera.data.type, scene.camera.data.ortho_scale, scene.camera.location = "ORTHO", 0.02, (0, 0, 1)
    scene.collection.objects.link(scene.camera)
    scene.render.engine, scene.cycles.samples, scene.cycles.device = "CYCLES", 64, "CPU"
    scene.cycles.max_bounces, scene.cycles.use_denoising = 0, False
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.view_settings.view_transform = "Raw"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = os.path.abspath("floor.exr")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath, check_existing=False)
    return np.array(image.pixels[:]).reshape(-1, 4)[:, 1].mean() * math.pi


def disc(angle_deg):
    """The solid angle of a sun as a flat surface sees it."""
    return math.pi * math.sin(math.radians(angle_deg / 2)) ** 2


for name, light, true, factor in [
    ("RectLight of radiance 10", ("RectLight", 0, 0), 10 * 0.1**2 / 2**2, 1),
    ("DistantLight, normalized", ("DistantLight", 0.5, 1), 10, 4),
    ("DistantLight of 0.5 degrees", ("DistantLight", 0.5, 0), 10 * disc(0.5), 16),
    ("DistantLight of 10 degrees", ("DistantLight", 10, 0), 10 * disc(10), 16),
]:
    found = irradiance(*light)
    print("bpy", bpy.app.version_string, name, "gives %.3g times what it should" % (found / true), flush=True)
    if abs(found / true - factor) > 0.01 * factor:
        raise SystemExit("this has changed")

bpy.ops.wm.read_factory_settings(use_empty=True)
sun = bpy.data.lights.new("sun", "SUN")
sun.energy, sun.angle = 4, math.radians(2)
bpy.context.scene.collection.objects.link(bpy.data.objects.new("sun", sun))
bpy.ops.wm.usd_export(filepath=os.path.abspath("sun.usda"))
with open("sun.usda") as file:
    written = [float(number) for number in re.findall(r"inputs:(?:angle|intensity) = ([\d.]+)", file.read())]
print("bpy", bpy.app.version_string, "writes a sun of strength 4 and 2 degrees as (angle, intensity)", written)
raise SystemExit(0 if np.allclose(written, [1, 1]) else "this has changed")
END
venv/bin/python suns.py 2>&1 | grep "^bpy\|changed"
