#!/usr/bin/env bash
# Of a USD volume of several files Blender keeps one, which may not be the fog; names and places of fields are lost.
#
# Expected: each field of a UsdVol `Volume` is a prim with its own file, grid and transform, and the name by which
# shaders know it is that of the relationship, `field:density`, whatever the grid in the file is called. Fog of 1 m
# with a density of 1 lets exp(-1) = 0.368 of the light through, where its field is. What happens: Blender 5.3.0 gives
# the volume object the file of one field. With `temperature` in a second file that is the one, the density is gone,
# and with it the fog. `field:density` that is a grid `smoke` is a grid `smoke`: what wants `density`, as materials do
# by default, has none. What moves a field, 5 m to the right here, moves an empty beside the fog. One file whose grids
# are named as the relationships, without transforms, is right. Nothing is said.
# Remedy: before import one file with all grids, under the names of the relationships; transforms at the `Volume`.
# Versions: bpy 5.3.0 with numpy 2.5.5, usd-core 26.11; bpy 5.0.1 has the same (PyPI). Source: measured here;
# https://openusd.org/release/api/usd_vol_page_front.html (fields, their names and their transforms)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 numpy==2.5.5
python3.13 -m venv usd
usd/bin/pip install --quiet usd-core==26.11
cat >write.py <<'END'
from pxr import Usd, UsdGeom, UsdVol


def write(name, fields):
    """A volume: relationship, file, grid, and how far to the right its field is."""
    stage = Usd.Stage.CreateNew(name + ".usda")
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.SetStageMetersPerUnit(stage, 1)
    volume = UsdVol.Volume.Define(stage, "/fog")
    for relationship, file, grid, x in fields:
        field = UsdVol.OpenVDBAsset.Define(stage, "/fog/" + relationship)
        field.CreateFilePathAttr("./%s.vdb" % file)
        field.CreateFieldNameAttr(grid)
        if x:
            field.AddTranslateOp().Set((x, 0, 0))
        volume.CreateFieldRelationship(relationship, field.GetPath())
    stage.Save()


write("as_it_is", [("density", "density", "density", 0)])
write("two_grids", [("density", "both", "density", 0), ("temperature", "both", "temperature", 0)])
write("two_files", [("density", "density", "density", 0), ("temperature", "temperature", "temperature", 0)])
write("named_otherwise", [("density", "smoke", "smoke", 0)])
write("moved", [("density", "density", "density", 5)])
END
cat >look.py <<'END'
import os

import bpy

bpy.utils.expose_bundled_modules()
import numpy as np
import openvdb

VOXEL_M = 0.1


def grid(name, value):
    """A cube of 1 m."""
    made = openvdb.FloatGrid()
    made.copyFromArray(np.full((10, 10, 10), value, np.float32))
    made.name, made.gridClass = name, openvdb.GridClass.FOG_VOLUME
    made.transform = openvdb.createLinearTransform(VOXEL_M)
    return made


def absorbing():
    """A material that absorbs by `density`."""
    material = bpy.data.materials.new("fog")
    tree = material.node_tree
    tree.nodes.clear()
    fog, density, out = (tree.nodes.new(kind) for kind in (
        "ShaderNodeVolumeAbsorption", "ShaderNodeAttribute", "ShaderNodeOutputMaterial"))
    fog.inputs["Color"].default_value = (0, 0, 0, 1)
    density.attribute_name = "density"
    tree.links.new(density.outputs["Fac"], fog.inputs["Density"])
    tree.links.new(fog.outputs[0], out.inputs["Volume"])
    return material


def let_through(x):
    """Light of a white sky that comes straight up at x, at the middle of the fog in y."""
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", 2048, False
    scene.cycles.use_adaptive_sampling = False
    scene.render.resolution_x = scene.render.resolution_y = 1
    scene.render.image_settings.file_format, scene.render.filepath = "OPEN_EXR", os.path.abspath("out.exr")
    scene.world = bpy.data.worlds.new("white")
    scene.world.node_tree.nodes["Background"].inputs[0].default_value = (1, 1, 1, 1)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.ortho_scale, camera.location = "ORTHO", 0.01, (x, 0.45, 5)
    scene.collection.objects.link(camera)
    scene.camera = camera
    bpy.ops.render.render(write_still=True)
    picture = bpy.data.images.load(scene.render.filepath, check_existing=False)
    return picture.pixels[0]


openvdb.write("density.vdb", grids=[grid("density", 1.0)])
openvdb.write("temperature.vdb", grids=[grid("temperature", 300.0)])
openvdb.write("smoke.vdb", grids=[grid("smoke", 1.0)])
openvdb.write("both.vdb", grids=[grid("density", 1.0), grid("temperature", 300.0)])
for name, wanted_grids, wanted in [
    ("as_it_is", ["density"], (0.368, 1.0)), ("two_grids", ["density", "temperature"], (0.368, 1.0)),
    ("two_files", ["temperature"], (1.0, 1.0)), ("named_otherwise", ["smoke"], (1.0, 1.0)),
    ("moved", ["density"], (0.368, 1.0)),
]:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.usd_import(filepath=name + ".usda")
    volume, = bpy.data.volumes
    volume.materials.clear()
    volume.materials.append(absorbing())
    volume.grids.load()
    grids = sorted(each.name for each in volume.grids)
    found = [let_through(x) for x in (0.45, 5.45)]
    print("bpy", bpy.app.version_string, name + ": grids", *grids, "lets through %.3f, 5 m to the right %.3f" % tuple(found),
          flush=True)
    if grids != wanted_grids or not np.allclose(found, wanted, atol=0.05):
        raise SystemExit("this has changed")
END
usd/bin/python write.py
venv/bin/python look.py 2>&1 | grep "^bpy\|changed\|Error\|[Ww]arn"
