#!/usr/bin/env bash
# Blender's glTF export writes lamps 683 times as bright as surfaces that glow, in the mode that it calls physically based.
#
# Expected: glTF has lamps in candela and emission in cd/m2 ("nits"), and *Lighting Mode: Standard* promises "cd, lx, nt".
# A ball that glows with L has the intensity L * pi * r^2, and so has the lamp that gives the same light in Cycles.
# What happens: Blender 5.3.0 writes the lamp in candela, at 683 lumen to the watt, and the strength of the emission as
# it is, in W/(m2 sr). Whoever reads both by the specification sees neon, skies on cards and embers 683 times too dark
# against lamps. *Unitless* has both by the watt, as Cycles has, and says so nowhere in the file.
# Remedy: multiply `emissiveStrength` by 683 in the file, or export *Unitless* for a reader that takes watts.
# Versions: bpy 5.3.0 with numpy 2.5.5, bpy 5.0.1 has the same (PyPI). Source: measured here;
# https://github.com/KhronosGroup/glTF/tree/main/extensions/2.0/Khronos/KHR_materials_emissive_strength
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 numpy==2.5.5
cat >emission.py <<'END'
import json
import math
import os

import bpy
import numpy as np

RADIUS_M, RADIANCE = 0.1, 100.0


def lamp():
    """A round lamp whose surface has that radiance."""
    made = bpy.data.lights.new("lamp", "POINT")
    made.energy = RADIANCE * math.pi * 4 * math.pi * RADIUS_M**2
    made.shadow_soft_size = RADIUS_M
    placed = bpy.data.objects.new("lamp", made)
    placed.location = (0, 0, 2)
    bpy.context.scene.collection.objects.link(placed)


def ball():
    """A black ball that glows."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=RADIUS_M, location=(0, 0, 2))
    material = bpy.data.materials.new("glows")
    material.use_nodes = True
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (0, 0, 0, 1)
    shader.inputs["Emission Color"].default_value = (1, 1, 1, 1)
    shader.inputs["Emission Strength"].default_value = RADIANCE
    bpy.context.object.data.materials.append(material)


def floor_and_file(add_light, mode):
    """Radiance of a floor beneath the light in Cycles, and the glTF document of the scene."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_plane_add(size=1)
    add_light()
    scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.camera.data.type, scene.camera.data.ortho_scale, scene.camera.location = "ORTHO", 0.02, (0, 0, 1)
    scene.collection.objects.link(scene.camera)
    scene.render.engine, scene.cycles.samples, scene.cycles.device = "CYCLES", 256, "CPU"
    scene.cycles.max_bounces, scene.cycles.use_denoising = 1, False
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.view_settings.view_transform = "Raw"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = os.path.abspath("floor.exr")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath, check_existing=False)
    path = os.path.abspath("light.gltf")
    bpy.ops.export_scene.gltf(filepath=path, export_format="GLTF_SEPARATE", export_lights=True,
                              export_import_convert_lighting_mode=mode)
    with open(path) as file:
        return np.array(image.pixels[:]).reshape(-1, 4)[:, 1].mean(), json.load(file)


for mode, factor in (("SPEC", 683), ("COMPAT", 1)):
    of_lamp, lamp_file = floor_and_file(lamp, mode)
    of_ball, ball_file = floor_and_file(ball, mode)
    intensity = lamp_file["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"]
    glows = next(each for each in ball_file["materials"] if each["name"] == "glows")
    strength = glows["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"]
    apart = intensity / (strength * math.pi * RADIUS_M**2)
    print("bpy", bpy.app.version_string, mode, "lamp / ball: %.3f in Cycles, %.2f in the file" % (of_lamp / of_ball, apart),
          flush=True)
    if abs(of_lamp / of_ball - 1) > 0.03 or abs(apart / factor - 1) > 0.001:
        raise SystemExit("this has changed")
END
venv/bin/python emission.py 2>&1 | grep "^bpy\|changed"
