#!/usr/bin/env bash
# A bulb of 1 cm in a USD stage in centimetres is a ball of 1 m in Blender, and 10,000 times as bright.
#
# Expected: with `metersPerUnit = 0.01`, which is what counts where nothing is said, and which Maya, Houdini's and
# Omniverse's stages have, lamps shrink with all the rest. Radiance is the same, so a floor 10 m below a bulb has the
# same light as in a stage in metres. What happens: Blender 5.3.0 scales the objects by 0.01 and leaves `radius` of a
# `SphereLight` as it is. Cycles scales lamps with an area by their objects, but not the radius of points and spots. So a
# bulb is 100 times as wide and has 10,000 times the area and the light, and shadows are 100 times as soft. A
# `RectLight` of the same stage is right, so that the two no longer fit. `xformOp:scale` of a bulb goes the same way.
# Nothing is said.
# Remedy: after import multiply `shadow_soft_size` of points and spots by the scale of their objects in the world.
# Versions: bpy 5.3.0 with numpy 2.5.5, bpy 5.0.1 has the same (PyPI). Source: measured here;
# https://openusd.org/release/api/class_usd_lux_sphere_light.html (radius);
# https://openusd.org/release/api/group___usd_geom_linear_units__group.html (0.01 where nothing is said)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 numpy==2.5.5
cat >bulbs.py <<'END'
import math
import os

import bpy
import numpy as np

STAGE = """#usda 1.0
(
    metersPerUnit = %g
    upAxis = "Z"
)
def %s "lamp" {
    float inputs:intensity = 10
    float inputs:%s = %g
    float inputs:%s = %g
    double3 xformOp:translate = (0, 0, %g)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
"""


def irradiance(stage):
    """What a floor gets of a lamp of a USD stage that is 10 m above it, by Cycles."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    with open("lamp.usda", "w") as file:
        file.write(stage)
    bpy.ops.wm.usd_import(filepath=os.path.abspath("lamp.usda"))
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
    scene.render.engine, scene.cycles.samples, scene.cycles.device = "CYCLES", 256, "CPU"
    scene.cycles.max_bounces, scene.cycles.use_denoising = 0, False
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.view_settings.view_transform = "Raw"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = os.path.abspath("floor.exr")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath, check_existing=False)
    return np.array(image.pixels[:]).reshape(-1, 4)[:, 1].mean() * math.pi


# Kind, its sizes in metres, area that the floor sees in m2; how many times too bright it is in centimetres.
for kind, (first, one), (second, two), area, factor in [
    ("RectLight", ("width", 0.02), ("height", 0.02), 0.02**2, 1),
    ("SphereLight", ("radius", 0.01), ("exposure", 0), math.pi * 0.01**2, 10000),
    ("SphereLight", ("radius", 0.01), ("shaping:cone:angle", 60), math.pi * 0.01**2, 10000),
]:
    for metres, wanted in [(1, 1), (0.01, factor)]:
        lengths = [size / metres if name in ("width", "height", "radius") else size
                   for name, size in [(first, one), (second, two)]]
        true = 10 * area / 10**2
        found = irradiance(STAGE % (metres, kind, first, lengths[0], second, lengths[1], 10 / metres)) / true
        print("bpy", bpy.app.version_string, kind, second, "with", metres,
              "m to the unit gives %.4g times what it should" % found, flush=True)
        if abs(found / wanted - 1) > 0.03:
            raise SystemExit("this has changed")
END
venv/bin/python bulbs.py 2>&1 | grep "^bpy\|changed"
