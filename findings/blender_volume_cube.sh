#!/usr/bin/env bash
# Fog of Blender's *Volume Cube* is thicker than from *Min* to *Max*, and cubes side by side have a seam twice as dense.
#
# Expected: with *Min* at -1 and *Max* at 1 the fog is 2 m thick, whatever the resolution, as the manual calls these
# the bounds of the voxels, and has the background beyond them: a density of 0.5 lets exp(-1) = 0.368 of the light
# through. Two cubes, from -2 to 0 and from 0 to 2, are one bank. What happens: Blender 5.3.0 puts the middles of the
# first and last voxel there, and Cycles draws voxels whole, so that half a voxel of fog lies beyond on each side. At
# 32 voxels, the default, it is 2.065 m thick, at 8 voxels 2.286 m. Where two cubes meet, both are there for the width
# of a voxel, so the bank has a dark line through it, or a bright one with light in it; more voxels make the line
# thinner, not fainter. Nothing is said.
# Remedy: *Min* and *Max* moved inwards by (Max - Min) / (2 * Resolution) each.
# Versions: bpy 5.3.0 (PyPI). Source: measured here;
# https://docs.blender.org/manual/en/latest/modeling/geometry_nodes/volume/primitives/volume_cube.html (Min, Max)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0
cat >cube.py <<'END'
import math
import os

import bpy

DENSITY = 0.5


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


def bank(left, right, voxels, inwards=0):
    """A cube of fog from left to right, and from -1 to 1 in y and z."""
    thing = bpy.data.objects.new("fog", bpy.data.meshes.new("fog"))
    bpy.context.scene.collection.objects.link(thing)
    tree = bpy.data.node_groups.new("fog", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    cube, paint, out = (tree.nodes.new(kind) for kind in (
        "GeometryNodeVolumeCube", "GeometryNodeSetMaterial", "NodeGroupOutput"))
    cube.inputs["Density"].default_value = DENSITY
    cube.inputs["Min"].default_value = [at + inwards for at in (left, -1, -1)]
    cube.inputs["Max"].default_value = [at - inwards for at in (right, 1, 1)]
    for axis in "XYZ":
        cube.inputs["Resolution " + axis].default_value = voxels
    paint.inputs["Material"].default_value = absorbing()
    tree.links.new(cube.outputs[0], paint.inputs[0])
    tree.links.new(paint.outputs[0], out.inputs[0])
    thing.modifiers.new("fog", "NODES").node_group = tree


def thickness(x):
    """Metres of fog that light of a white sky has come through, straight up at x."""
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", 16384, False
    scene.cycles.use_adaptive_sampling = False
    scene.render.resolution_x = scene.render.resolution_y = 1
    scene.render.image_settings.file_format, scene.render.filepath = "OPEN_EXR", os.path.abspath("out.exr")
    scene.render.image_settings.color_depth = "32"
    scene.world = bpy.data.worlds.new("white")
    scene.world.node_tree.nodes["Background"].inputs[0].default_value = (1, 1, 1, 1)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.ortho_scale, camera.location = "ORTHO", 0.001, (x, 0.02, 5)
    scene.collection.objects.link(camera)
    scene.camera = camera
    bpy.ops.render.render(write_still=True)
    return -math.log(bpy.data.images.load(scene.render.filepath, check_existing=False).pixels[0]) / DENSITY


for name, banks, x, wanted in [
    ("8 voxels", [(-1, 1, 8)], 0.1, 2 * 8 / 7), ("32 voxels", [(-1, 1, 32)], 0.1, 2 * 32 / 31),
    ("32 voxels, moved inwards", [(-1, 1, 32, 1 / 32)], 0.1, 2),
    ("two side by side, at 1 m", [(-2, 0, 32), (0, 2, 32)], 1, 2 * 32 / 31),
    ("two side by side, where they meet", [(-2, 0, 32), (0, 2, 32)], 0, 4 * 32 / 31),
]:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    for each in banks:
        bank(*each)
    found = thickness(x)
    print("bpy", bpy.app.version_string, name + ": %.3f m of fog for 2 m" % found, flush=True)
    if abs(found - wanted) > 0.02 * wanted:
        raise SystemExit("this has changed")
END
venv/bin/python cube.py 2>&1 | grep "^bpy\|changed\|Error"
