#!/usr/bin/env bash
# Cycles draws an OpenVDB grid whose voxels follow a camera's frustum as a straight box in another place.
#
# Expected: grids of a frustum, as Houdini and Nuke make them for fog in front of a camera, are drawn where they are:
# this one is from -0.28 to 0.28 m across. Blender's bounding box and its *Volume to Mesh* have it there.
# What happens: Cycles of Blender 5.3.0 drops the frustum, keeps the size of a voxel, and draws 8 voxels of 0.25 m from
# voxel 0 on: from -0.25 to 2.00 m with their rim. Nothing is said, and the viewport's box shows nothing of it.
# Remedy: resample to a grid with a linear transform before Blender reads it.
# Versions: bpy 5.3.0 with numpy 2.5.5, bpy 5.0.1 draws that box too (PyPI). Source: measured here;
# https://www.openvdb.org/documentation/doxygen/transformsAndMaps.html (frustum transforms)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 numpy==2.5.5
cat >frustum.py <<'END'
import glob
import os
import sys

import bpy

sys.path += glob.glob(sys.prefix + "/lib/python*/site-packages/bpy/*/python/lib/python*/site-packages")
import numpy as np
import openvdb

WIDTH_M, PIXELS = 5.0, 100

grid = openvdb.FloatGrid()
grid.copyFromArray(np.full((8, 8, 8), 4.0, np.float32))
grid.name = "density"
# Twice as wide at the far end as at the near one.
grid.transform = openvdb.createFrustumTransform((0, 0, 0), (7, 7, 7), 0.5, 6.0, 0.25)
openvdb.write("frustum.vdb", grids=[grid])

bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
data = bpy.data.volumes.new("frustum")
data.filepath = os.path.abspath("frustum.vdb")
material = bpy.data.materials.new("absorbs")
material.use_nodes = True
nodes = material.node_tree.nodes
nodes.clear()
shader, output = nodes.new("ShaderNodeVolumePrincipled"), nodes.new("ShaderNodeOutputMaterial")
shader.inputs["Color"].default_value = (0, 0, 0, 1)
shader.inputs["Density"].default_value = 1.0
material.node_tree.links.new(shader.outputs[0], output.inputs["Volume"])
data.materials.append(material)
frustum = bpy.data.objects.new("frustum", data)
scene.collection.objects.link(frustum)
scene.world = bpy.data.worlds.new("white")
scene.world.use_nodes = True
scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
scene.camera.data.type, scene.camera.data.ortho_scale, scene.camera.location = "ORTHO", WIDTH_M, (0, 0, 9)
scene.collection.objects.link(scene.camera)
scene.render.engine, scene.cycles.samples, scene.cycles.device = "CYCLES", 64, "CPU"
scene.cycles.use_denoising = False
scene.render.resolution_x = scene.render.resolution_y = PIXELS
scene.view_settings.view_transform = "Raw"
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.filepath = os.path.abspath("frustum.exr")
bpy.ops.render.render(write_still=True)
image = bpy.data.images.load(scene.render.filepath)
darkest = np.array(image.pixels[:]).reshape(PIXELS, PIXELS, 4)[..., 1].min(axis=0)
dark = (np.nonzero(darkest < 0.5)[0][[0, -1]] + [0, 1]) * WIDTH_M / PIXELS - WIDTH_M / 2

mesh = bpy.data.objects.new("mesh", bpy.data.meshes.new("mesh"))
scene.collection.objects.link(mesh)
modifier = mesh.modifiers.new("surface", "VOLUME_TO_MESH")
modifier.object, modifier.threshold = frustum, 2.0
surface = mesh.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
across = [vertex.co.x for vertex in surface.vertices]
found = np.array([*dark, min(across), max(across)])
print("bpy", bpy.app.version_string, "Cycles: %.2f to %.2f m; Volume to Mesh: %.2f to %.2f m" % tuple(found))
raise SystemExit(0 if np.allclose(found, [-0.25, 2.0, -0.28, 0.28], atol=0.06) else "this has changed")
END
venv/bin/python frustum.py 2>&1 | grep "^bpy\|changed"
