#!/usr/bin/env bash
# Gold of USD's specular workflow is black in Blender: it reflects 4 % of what it should.
#
# Expected: with `useSpecularWorkflow` the `specularColor` of a `UsdPreviewSurface` is what is reflected at normal
# incidence, and metals are materials of a black `diffuseColor` and a bright `specularColor`. Gold of (1, 0.77, 0.34) is
# gold, as it is by `metallic` = 1 and that `diffuseColor`. What happens: Blender 5.3.0 makes *Specular Tint* of it, which
# multiplies what a material of `ior` 1.5 reflects, 0.04. Gold reflects 0.040 0.031 0.014. Plastic of 0.04 is at 0.0016,
# 25 times too dark as well. Where nothing is said `specularColor` is 0, and Blender reflects 0.04. Nothing is said.
# Remedy: for metals *Metallic* at 1 and `specularColor` as *Base Color*; else *Specular IOR Level* at specular / 0.08
# with a white tint.
# Versions: bpy 5.3.0 with numpy 2.5.5, bpy 5.0.1 has the same (PyPI). Source: measured here;
# https://openusd.org/release/spec_usdpreviewsurface.html (useSpecularWorkflow, specularColor)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 numpy==2.5.5
cat >metal.py <<'END'
import os

import bpy
import numpy as np

STAGE = """#usda 1.0
(
    metersPerUnit = 1
    upAxis = "Z"
)
def Mesh "plate" (
    prepend apiSchemas = ["MaterialBindingAPI"]
)
{
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
    rel material:binding = </material>
}
def Material "material"
{
    token outputs:surface.connect = </material/surface.outputs:surface>
    def Shader "surface"
    {
        uniform token info:id = "UsdPreviewSurface"
        float inputs:roughness = 0.1
        %s
        token outputs:surface
    }
}
"""
SPECULAR = "color3f inputs:diffuseColor = (0, 0, 0)\n int inputs:useSpecularWorkflow = 1\n"


def reflected(inputs):
    """What a plate shows from above under a white world, by Cycles."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    with open("plate.usda", "w") as file:
        file.write(STAGE % inputs)
    bpy.ops.wm.usd_import(filepath=os.path.abspath("plate.usda"))
    scene.world = bpy.data.worlds.new("white")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
    scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.camera.data.type, scene.camera.data.ortho_scale, scene.camera.location = "ORTHO", 1, (0, 0, 1)
    scene.collection.objects.link(scene.camera)
    scene.render.engine, scene.cycles.samples, scene.cycles.device = "CYCLES", 256, "CPU"
    scene.cycles.use_denoising = False
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.view_settings.view_transform = "Raw"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = os.path.abspath("plate.exr")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath, check_existing=False)
    return np.array(image.pixels[:]).reshape(-1, 4)[:, :3].mean(axis=0)


for name, inputs, wanted in [
    ("gold by metallic", "color3f inputs:diffuseColor = (1, 0.77, 0.34)\n float inputs:metallic = 1", (1, 0.77, 0.34)),
    ("gold by specularColor", SPECULAR + "color3f inputs:specularColor = (1, 0.77, 0.34)", (0.04, 0.0308, 0.0136)),
    ("plastic of 0.04", SPECULAR + "color3f inputs:specularColor = (0.04, 0.04, 0.04)", (0.0016, 0.0016, 0.0016)),
    ("specularColor left out", SPECULAR, (0.04, 0.04, 0.04)),
]:
    found = reflected(inputs)
    print("bpy", bpy.app.version_string, name, "reflects %.4f %.4f %.4f" % tuple(found), flush=True)
    if any(abs(a - b) > 0.0002 + 0.02 * b for a, b in zip(found, wanted)):
        raise SystemExit("this has changed")
END
venv/bin/python metal.py 2>&1 | grep "^bpy\|changed"
