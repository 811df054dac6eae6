#!/usr/bin/env bash
# A rough clear coat of Blender's Principled BSDF is up to 3 % darker in Cycles of 5.3.0 than in that of 5.0.1.
#
# Expected: one file without textures, lights or volumes has one colour in both. Under a white world a matte base of
# 0.8 with a coat shows its albedo.
# What happens: with a coat of roughness 1 that is 0.803 from above in 5.0.1 and 0.780 in 5.3.0; of roughness 0.3 seen
# at 80 degrees 0.855 and 0.834; of roughness 0.03 from above 0.808 in both. A shot that is half rendered by each
# changes where things have rough coats.
# Remedy: render a shot by one version, and compare another renderer with the version that the studio uses.
# Versions: bpy 5.0.1 with numpy 1.26.4, bpy 5.3.0 with numpy 2.5.5 (PyPI). Source: measured here.
# Needs python3.11 and python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
cat >coats.py <<'END'
import math
import sys

import bpy
import numpy as np


def albedo(roughness, angle_deg):
    """Share of an even white light that a matte base of 0.8 with a clear coat sends to the camera."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("white")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
    bpy.ops.mesh.primitive_plane_add(size=2000)
    material = bpy.data.materials.new("coated")
    material.use_nodes = True
    inputs = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED").inputs
    inputs["Base Color"].default_value = (0.8, 0.8, 0.8, 1)
    inputs["Specular IOR Level"].default_value = 0.0
    inputs["Coat Weight"].default_value, inputs["Coat Roughness"].default_value = 1.0, roughness
    bpy.context.object.data.materials.append(material)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", 1.0
    angle = math.radians(angle_deg)
    camera.location, camera.rotation_euler = (50 * math.sin(angle), 0, 50 * math.cos(angle)), (0, angle, 0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.engine, scene.cycles.samples, scene.cycles.device = "CYCLES", 4096, "CPU"
    scene.cycles.use_denoising = False
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.view_settings.view_transform = "Raw"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = f"{sys.argv[1]}/coat.exr"
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    return np.array(image.pixels[:]).reshape(-1, 4)[:, :3].mean()


wanted = iter(map(float, sys.argv[2:]))
for roughness, angle_deg in [(0.03, 0), (0.3, 80), (1.0, 0)]:
    found = albedo(roughness, angle_deg)
    print("bpy", bpy.app.version_string, "coat of roughness", roughness, "at", angle_deg, "degrees: %.3f" % found, flush=True)
    if abs(found - next(wanted)) > 0.003:
        raise SystemExit("this has changed")
END
python3.11 -m venv before
before/bin/pip install --quiet bpy==5.0.1 numpy==1.26.4
before/bin/python coats.py "$folder" 0.808 0.855 0.803 2>&1 | grep "^bpy\|changed"
python3.13 -m venv after
after/bin/pip install --quiet bpy==5.3.0 numpy==2.5.5
after/bin/python coats.py "$folder" 0.808 0.834 0.780 2>&1 | grep "^bpy\|changed"
