#!/usr/bin/env bash
# Between the texels of an 8-bit sRGB picture Cycles is darker than glTF 2.0 asks for, and than the same in floats.
#
# Expected: light is smoothed. By glTF 2.0 (3.9.2, "Metallic-Roughness Material") texels of base colours should be
# decoded before they are interpolated. Half way between black and white is 0.5, whatever the picture is kept in.
# What happens: Cycles mixes the codes and decodes what comes out. Half way is 0.214 of white for 8 bits, and 0.5 for
# floats. A pattern of 8x8 squares that is smoothed over is 8 % darker in the mean than in viewers of the same glTF.
# Remedy: keep such pictures in floats, or many texels to a pixel; whoever compares renderers should do likewise.
# Versions: bpy 5.0.1 with numpy 1.26.4, bpy 5.3.0 with numpy 2.5.5 (PyPI). Source: measured here; the specification.
# Needs python3.11 and python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
cat >halfway.py <<'END'
import sys

import bpy
import numpy as np


def halfway(is_float):
    """Radiance half way between a black and a white texel of a picture that emits."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    picture = bpy.data.images.new("two", 2, 2, float_buffer=is_float)
    picture.pixels = [0, 0, 0, 1, 1, 1, 1, 1] * 2
    picture.pack()
    bpy.ops.mesh.primitive_plane_add(size=2)
    material = bpy.data.materials.new("emits")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    texture, emission, output = (nodes.new("ShaderNode" + kind) for kind in ("TexImage", "Emission", "OutputMaterial"))
    texture.image, texture.extension = picture, "EXTEND"
    links.new(texture.outputs["Color"], emission.inputs["Color"])
    links.new(emission.outputs["Emission"], output.inputs["Surface"])
    bpy.context.object.data.materials.append(material)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.ortho_scale, camera.location = "ORTHO", 0.02, (0, 0, 5)
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.engine, scene.cycles.samples, scene.cycles.device = "CYCLES", 64, "CPU"
    scene.cycles.use_denoising = False
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.view_settings.view_transform = "Raw"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = f"{sys.argv[1]}/halfway.exr"
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    return np.array(image.pixels[:]).reshape(-1, 4)[:, :3].mean()


for name, is_float, wanted in [("8 bits", False, 0.214), ("floats", True, 0.5)]:
    found = halfway(is_float)
    print("bpy", bpy.app.version_string, name, "half way: %.3f" % found, flush=True)
    if abs(found - wanted) > 0.003:
        raise SystemExit("this has changed")
END
python3.11 -m venv before
before/bin/pip install --quiet bpy==5.0.1 numpy==1.26.4
before/bin/python halfway.py "$folder" 2>&1 | grep "^bpy\|changed"
python3.13 -m venv after
after/bin/pip install --quiet bpy==5.3.0 numpy==2.5.5
after/bin/python halfway.py "$folder" 2>&1 | grep "^bpy\|changed"
