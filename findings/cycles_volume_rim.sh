#!/usr/bin/env bash
# Cycles of Blender 5.0.1 loses half a voxel of every OpenVDB grid that has fog up to its rim; that of 5.3.0 loses none.
#
# Expected: density is interpolated between the middles of voxels and falls to the background beyond the outermost, so
# a cube of n even voxels of 0.125 m has n * 0.125 m of fog along an axis, whatever renders it.
# What happens: light through cubes of 12, 16, 20 and 24 voxels tells 11.5, 15.5, 19.5 and 23.5 voxels in 5.0.1, and
# 12, 16, 20 and 24 in 5.3.0. A shot that is half rendered by each changes by 4 % in a cube of 12 voxels.
# Remedy: leave a rim of zeros about the fog where pictures of both are compared.
# Versions: bpy 5.0.1 with numpy 1.26.4, bpy 5.3.0 with numpy 2.5.5 (PyPI). Source: measured here.
# Needs python3.11 and python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
cat >rim.py <<'END'
import glob
import math
import sys

import bpy

sys.path += glob.glob(sys.prefix + "/lib/python*/site-packages/bpy/*/python/lib/python*/site-packages")
import numpy as np
import openvdb

SIDE_M = 0.125


def length_m(voxels):
    """Metres of density 1 that a ray meets along an axis of a cube, by what Cycles lets through."""
    grid = openvdb.FloatGrid()
    grid.copyFromArray(np.ones((voxels,) * 3, np.float32))
    grid.name = "density"
    grid.transform = openvdb.createLinearTransform(voxelSize=SIDE_M)
    path = f"{sys.argv[1]}/cube{voxels}.vdb"
    openvdb.write(path, grids=[grid])
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    data = bpy.data.volumes.new("cube")
    data.filepath = path
    material = bpy.data.materials.new("absorbs")
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    shader, output = nodes.new("ShaderNodeVolumePrincipled"), nodes.new("ShaderNodeOutputMaterial")
    shader.inputs["Color"].default_value = (0, 0, 0, 1)
    shader.inputs["Density"].default_value = 1.0
    material.node_tree.links.new(shader.outputs[0], output.inputs["Volume"])
    data.materials.append(material)
    cube = bpy.data.objects.new("cube", data)
    cube.location = (-0.5 * SIDE_M * (voxels - 1),) * 3
    scene.collection.objects.link(cube)
    scene.world = bpy.data.worlds.new("white")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.ortho_scale, camera.location = "ORTHO", 0.2, (0.03, 0.04, 9)
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.engine, scene.cycles.samples, scene.cycles.device = "CYCLES", 1024, "CPU"
    scene.render.resolution_x = scene.render.resolution_y = 8
    # Small steps: what is left is no matter of theirs.
    scene.cycles.volume_biased, scene.cycles.volume_step_rate = True, 0.05
    scene.view_settings.view_transform = "Raw"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = f"{sys.argv[1]}/cube.exr"
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    return -math.log(np.array(image.pixels[:]).reshape(8, 8, 4)[..., 1].mean())


lost = float(sys.argv[2])
for voxels in (12, 16, 20, 24):
    found = length_m(voxels) / SIDE_M
    print("bpy", bpy.app.version_string, "of", voxels, "voxels Cycles has %.2f" % found, flush=True)
    if abs(found - (voxels - lost)) > 0.1:
        raise SystemExit("this has changed")
END
python3.11 -m venv before
before/bin/pip install --quiet bpy==5.0.1 numpy==1.26.4
before/bin/python rim.py "$folder" 0.5 2>&1 | grep "^bpy\|changed"
python3.13 -m venv today
today/bin/pip install --quiet bpy==5.3.0 numpy==2.5.5
today/bin/python rim.py "$folder" 0.0 2>&1 | grep "^bpy\|changed"
