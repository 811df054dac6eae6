#!/usr/bin/env bash
# Blender's glTF import makes what is inside of glass too clear: a medium that should let 10 % through lets 41 %.
#
# Expected: by KHR_materials_volume light that has gone `attenuationDistance` has been multiplied by
# `attenuationColor`: absorption is -ln(colour) / distance. What happens: Blender 5.3.0 puts colour and 1 / distance
# into *Volume Absorption*, which absorbs (1 - colour) * density. Colours of 0.1, 0.5 and 0.9 let 0.41, 0.61 and 0.90
# of light through in Cycles, at that distance. The darker, the more too clear. Export and import undo each other,
# so that a round trip shows nothing.
# Remedy: with s = -ln(colour) set density to max(s) / distance, and the node's colour to 1 - s / max(s).
# Versions: bpy 5.3.0 with numpy 2.5.5, bpy 5.0.1 has the same (PyPI). Source: measured here;
# https://github.com/KhronosGroup/glTF/tree/main/extensions/2.0/Khronos/KHR_materials_volume (Attenuation)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 numpy==2.5.5
cat >absorption.py <<'END'
import json
import os

import bpy
import numpy as np

COLOR = np.array([0.1, 0.5, 0.9])
GLASS = {  # of the index of air: light goes straight on, and nothing is reflected
    "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0},
    "extensions": {
        "KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": 1.0},
        "KHR_materials_volume": {"thicknessFactor": 2, "attenuationDistance": 2, "attenuationColor": COLOR.tolist()},
    },
}


def through():
    """Share of a white sky that is seen through the cube."""
    scene = bpy.context.scene
    scene.render.filepath = os.path.abspath("cube.exr")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath, check_existing=False)
    return np.array(image.pixels[:]).reshape(-1, 4)[:, :3].mean(axis=0)


bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.mesh.primitive_cube_add(size=2)
bpy.context.object.data.materials.append(bpy.data.materials.new("glass"))
bpy.ops.export_scene.gltf(filepath=os.path.abspath("cube.gltf"), export_format="GLTF_SEPARATE")
with open("cube.gltf") as file:
    document = json.load(file)
document["materials"], document["extensionsUsed"] = [GLASS], list(GLASS["extensions"])
with open("cube.gltf", "w") as file:
    json.dump(document, file)

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_scene.gltf(filepath=os.path.abspath("cube.gltf"))
scene = bpy.context.scene
scene.world = bpy.data.worlds.new("white")
scene.world.use_nodes = True
scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
scene.camera.data.type, scene.camera.data.ortho_scale, scene.camera.location = "ORTHO", 0.2, (0, 0, 5)
scene.collection.objects.link(scene.camera)
scene.render.engine, scene.cycles.samples, scene.cycles.device = "CYCLES", 1024, "CPU"
scene.cycles.use_denoising = False
scene.render.resolution_x = scene.render.resolution_y = 8
scene.view_settings.view_transform = "Raw"
scene.render.image_settings.file_format = "OPEN_EXR"

imported = through()
nodes = bpy.data.materials[0].node_tree.nodes
absorbs = next(node for node in nodes if node.type == "VOLUME_ABSORPTION")
depth = -np.log(COLOR)
absorbs.inputs["Color"].default_value = (*(1 - depth / depth.max()), 1)
absorbs.inputs["Density"].default_value = depth.max() / 2
mended = through()
print("bpy", bpy.app.version_string, "asked for", COLOR, "imported", imported.round(3), "mended", mended.round(3))
as_before = np.allclose(imported, np.exp(COLOR - 1), atol=0.01) and np.allclose(mended, COLOR, atol=0.01)
raise SystemExit(0 if as_before else "this has changed")
END
venv/bin/python absorption.py 2>&1 | grep "^bpy\|changed"
