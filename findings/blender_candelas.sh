#!/usr/bin/env bash
# In one Blender scene 1000 candela from an IES file are 3.84 times as bright as 1000 candela from glTF.
#
# Expected: a candela is a candela; lamps of both files light a wall alike. What happens: Cycles takes a watt of an
# IES file for 177.83 lumen, those of daylight (D65), and Blender's glTF import takes it for 683, those of green at
# 555 nm. On a white wall at 2 m the one gives 5.623 W/sr, the other 1.464.
# Remedy: *Strength* of the IES texture at 0.2604 = 177.83 / 683, with the lamp's power at 1 W; all is then by 683.
# Versions: bpy 5.3.0 with numpy 2.5.5, bpy 5.0.1 has the same (PyPI). Source: measured here;
# https://projects.blender.org/blender/blender (intern/cycles/util/ies.cpp);
# https://github.com/KhronosGroup/glTF/tree/main/extensions/2.0/Khronos/KHR_lights_punctual
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 numpy==2.5.5
cat >lamp.ies <<'END'
IESNA:LM-63-2002
[TEST] 1000 candela in all directions
TILT=NONE
1 -1 1 3 1 1 2 0 0 0
1 1 0
0 90 180
0
1000 1000 1000
END
cat >lamp.gltf <<'END'
{"asset": {"version": "2.0"}, "extensionsUsed": ["KHR_lights_punctual"],
 "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 1000}]}},
 "nodes": [{"translation": [0, 2, 0], "extensions": {"KHR_lights_punctual": {"light": 0}}}],
 "scenes": [{"nodes": [0]}], "scene": 0}
END
cat >candelas.py <<'END'
import math
import os

import bpy
import numpy as np


def of_ies(strength):
    """A point lamp that shines as the IES file says."""
    lamp = bpy.data.lights.new("lamp", "POINT")
    lamp.energy, lamp.shadow_soft_size, lamp.use_nodes = 1, 0, True
    texture = lamp.node_tree.nodes.new("ShaderNodeTexIES")
    texture.mode, texture.filepath = "EXTERNAL", os.path.abspath("lamp.ies")
    texture.inputs["Strength"].default_value = strength
    emission = next(node for node in lamp.node_tree.nodes if node.type == "EMISSION")
    lamp.node_tree.links.new(texture.outputs[0], emission.inputs["Strength"])
    placed = bpy.data.objects.new("lamp", lamp)
    placed.location = (0, 0, 2)
    bpy.context.scene.collection.objects.link(placed)


def intensity_w_per_sr(add_lamp):
    """Radiant intensity of a lamp 2 m above a white, matte floor, by the light of the floor in Cycles."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_plane_add(size=1)
    floor = bpy.data.materials.new("floor")
    floor.use_nodes = True
    nodes = floor.node_tree.nodes
    nodes.clear()
    diffuse, output = nodes.new("ShaderNodeBsdfDiffuse"), nodes.new("ShaderNodeOutputMaterial")
    diffuse.inputs["Color"].default_value = (1, 1, 1, 1)
    floor.node_tree.links.new(diffuse.outputs[0], output.inputs["Surface"])
    bpy.context.object.data.materials.append(floor)
    add_lamp()
    scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.camera.data.type, scene.camera.data.ortho_scale, scene.camera.location = "ORTHO", 0.02, (0, 0, 1)
    scene.collection.objects.link(scene.camera)
    scene.render.engine, scene.cycles.samples, scene.cycles.device = "CYCLES", 16, "CPU"
    scene.cycles.max_bounces, scene.cycles.use_denoising = 0, False
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.view_settings.view_transform = "Raw"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = os.path.abspath("floor.exr")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath, check_existing=False)
    return np.array(image.pixels[:]).reshape(-1, 4)[:, 1].mean() * math.pi * 2**2


for name, add_lamp, wanted in [
    ("IES", lambda: of_ies(1), 1000 / 177.83),
    ("glTF", lambda: bpy.ops.import_scene.gltf(filepath="lamp.gltf"), 1000 / 683),
    ("IES at a strength of 0.2604", lambda: of_ies(177.83 / 683), 1000 / 683),
]:
    found = intensity_w_per_sr(add_lamp)
    print("bpy", bpy.app.version_string, "1000 cd of", name, "are %.3f W/sr" % found, flush=True)
    if abs(found - wanted) > 0.002 * wanted:
        raise SystemExit("this has changed")
END
venv/bin/python candelas.py 2>&1 | grep "^bpy\|changed"
