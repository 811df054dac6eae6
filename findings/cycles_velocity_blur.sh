#!/usr/bin/env bash
# Cycles blurs a mesh by its attribute `velocity`, although the mesh does not move.
#
# Expected: motion blur follows where vertices are at the ends of the shutter, as they are known: a still mesh
# is sharp. What happens: with a point attribute named `velocity` Cycles of Blender 5.3.0 blurs by that alone,
# so a still quad whose attribute says 24 m/s is smeared over a metre in one frame at 24 frames a second.
# Remedy: name other vectors otherwise, and remove a stale `velocity` of a simulation from a mesh that is baked.
# Source: https://projects.blender.org/blender/blender (intern/cycles/blender/mesh.cpp)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 numpy
cat >blur.py <<'END'
import sys

import bpy
import numpy as np


def columns(has_velocity):
    """The mean of each column of a picture of a still, glowing quad."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    mesh = bpy.data.meshes.new("quad")
    mesh.from_pydata([(-0.5, -0.5, 0), (0.5, -0.5, 0), (0.5, 0.5, 0), (-0.5, 0.5, 0)], [], [(0, 1, 2, 3)])
    if has_velocity:
        attribute = mesh.attributes.new("velocity", "FLOAT_VECTOR", "POINT")
        attribute.data.foreach_set("vector", [24.0, 0.0, 0.0] * 4)
    material = bpy.data.materials.new("glow")
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    emission, output = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeOutputMaterial")
    material.node_tree.links.new(emission.outputs[0], output.inputs["Surface"])
    mesh.materials.append(material)
    scene.collection.objects.link(bpy.data.objects.new("quad", mesh))
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.ortho_scale, camera.location = "ORTHO", 4.0, (0, 0, 5)
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.engine, scene.cycles.samples, scene.cycles.device = "CYCLES", 16, "CPU"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.fps = 64, 16, 24
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0
    scene.view_settings.view_transform = "Raw"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = sys.argv[1]
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(sys.argv[1])
    pixels = np.array(image.pixels[:]).reshape(image.size[1], image.size[0], 4)
    return pixels[:, :, 0].mean(0)


lit = [int((columns(has) > 0.02).sum()) for has in (False, True)]
print("bpy", bpy.app.version_string, "columns that the quad touches: still", lit[0], "with `velocity`", lit[1])
raise SystemExit(0 if lit[0] <= 18 and lit[1] >= 28 else 1)
END
venv/bin/python blur.py "$folder/quad.exr" 2>&1 | grep "^bpy"
