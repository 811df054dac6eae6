#!/usr/bin/env bash
# Blender draws the old fog when its OpenVDB file has been written anew, until it is restarted.
#
# Expected: a file is read when it is loaded. After a simulation has run again and written the same names, importing the
# file, giving its path once more, `grids.unload()`, or a new .blend shows the new fog. What happens: Blender 5.3.0
# keeps what it has read for as long as it runs, by the path alone. A cube of 2 m of density 1 that is written anew with
# density 3 is drawn with 1, and a cube of 1 m as one of 2 m: in Cycles, by *Import OpenVDB* in a new file, without a
# user of the old fog. The time of the file does not matter, and there is no button to reload. Nothing is said. So a
# session in which one tunes a simulation shows a mixture of its runs, and a render from the command line another one.
# Remedy: restart Blender, or write each run to a folder of its own (another name by a link is enough).
# Versions: bpy 5.3.0 with numpy 2.5.5, bpy 5.0.1 has the same (PyPI). Source: measured here;
# https://wiki.blender.org/wiki/Source/Objects/Volume (there what has no users is freed at once)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 numpy==2.5.5
cat >anew.py <<'END'
import os

import bpy
import numpy as np

bpy.utils.expose_bundled_modules()
import openvdb

VOXEL_M, VIEW_M, PIXELS = 0.125, 4.0, 32


def write(path, voxels, density):
    """A cube of even fog."""
    grid = openvdb.FloatGrid()
    grid.fill((0, 0, 0), (voxels - 1,) * 3, density)
    grid.name, grid.transform = "density", openvdb.createLinearTransform(voxelSize=VOXEL_M)
    if os.path.exists(path):
        os.remove(path)
    openvdb.write(path, grids=[grid])


def render(path):
    """The mass of the fog in the file, as Cycles draws it from above in a new scene: each unit glows with 1 W/m3."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    bpy.ops.object.volume_import(filepath=os.path.abspath(path))
    glow = bpy.data.materials.new("glow")
    glow.use_nodes = True
    nodes = glow.node_tree.nodes
    nodes.clear()
    density, emission, output = map(nodes.new, ("ShaderNodeAttribute", "ShaderNodeEmission", "ShaderNodeOutputMaterial"))
    density.attribute_name = "density"
    glow.node_tree.links.new(density.outputs["Fac"], emission.inputs["Strength"])
    glow.node_tree.links.new(emission.outputs[0], output.inputs["Volume"])
    bpy.context.object.data.materials.append(glow)
    scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.camera.data.type, scene.camera.data.ortho_scale, scene.camera.location = "ORTHO", VIEW_M, (1, 1, 9)
    scene.collection.objects.link(scene.camera)
    scene.render.engine, scene.cycles.samples, scene.cycles.device = "CYCLES", 32, "CPU"
    scene.cycles.use_denoising = False
    scene.render.resolution_x = scene.render.resolution_y = PIXELS
    scene.view_settings.view_transform = "Raw"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = os.path.abspath("fog.exr")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath, check_existing=False)
    return np.array(image.pixels[:]).reshape(-1, 4)[:, 0].mean() * VIEW_M**2


for voxels, density in [(16, 1.0), (16, 3.0), (8, 1.0)]:
    write("fog.vdb", voxels, density)
    os.link("fog.vdb", f"fog_{voxels}_{density}.vdb")
    found = [render("fog.vdb"), render(f"fog_{voxels}_{density}.vdb")]
    true = density * (voxels * VOXEL_M) ** 3
    print("bpy", bpy.app.version_string, "mass of the fog in the file: %g, as drawn: %.1f, by another name: %.1f"
          % (true, *found), flush=True)
    if abs(found[0] - 8) > 0.3 or abs(found[1] / true - 1) > 0.05:
        raise SystemExit("this has changed")
END
venv/bin/python anew.py 2>&1 | grep "^bpy\|changed"
