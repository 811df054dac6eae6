#!/usr/bin/env bash
# Meshes that openvdb's Python makes of grids are inside out: a drop is a bubble, and a glTF of it is not seen.
#
# Expected: `convertToQuads` and `convertToPolygons` list the corners of a face counter-clockwise as seen from outside,
# as OBJ, glTF, PLY and Blender have them and as no documentation of the two says otherwise. The volume that the faces
# of a ball of 2 m hold is then 33.5 m3. What happens: that volume is -33.1 m3, every quad and every triangle faces
# inwards, of level sets and of fog at a threshold alike; only a grid that its transform mirrors comes out right. What
# is made of it is not seen where viewers cull faces, and Cycles takes water of it for air in water: a ray at 1 m from
# the middle of the ball meets the floor below at 2.2 m, where water bends it to 0.33. `createLevelSetFromPolygons`
# does not look at the order, so that a round trip shows nothing. Blender's own modifier *Volume to Mesh* is right.
# Nothing is said.
# Remedy: `quads[:, ::-1]` and `triangles[:, ::-1]` before use, where the transform does not mirror.
# Versions: bpy 5.3.0 with numpy 2.5.5, whose openvdb is 13.0 (PyPI). Source: measured here;
# https://www.openvdb.org/documentation/doxygen/python.html (convertToQuads);
# https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html (3.7.2.1, winding and front faces)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 numpy==2.5.5
cat >faces.py <<'END'
import os

import bpy
import numpy as np

bpy.utils.expose_bundled_modules()
import openvdb

VOXEL = 0.2


def volume(points, faces):
    """What the faces hold; negative where they face inwards."""
    first = points[faces[:, 0]]
    sides = range(1, faces.shape[1] - 1)
    return sum(np.sum(first * np.cross(points[faces[:, n]], points[faces[:, n + 1]])) for n in sides) / 6


def of_quads(grid, threshold):
    return volume(*grid.convertToQuads(isovalue=threshold))


def of_polygons(grid, threshold):
    points, triangles, quads = grid.convertToPolygons(isovalue=threshold, adaptivity=0.1)
    assert len(triangles) and len(quads)
    return volume(points, triangles) + volume(points, quads)


def by_blender(grid):
    """The same by Blender's own modifier."""
    grid.name = "density"
    openvdb.write("fog.vdb", grids=[grid])
    held = bpy.data.objects.new("fog", bpy.data.volumes.new("fog"))
    held.data.filepath = os.path.abspath("fog.vdb")
    made = bpy.data.objects.new("mesh", bpy.data.meshes.new("mesh"))
    for thing in (held, made):
        bpy.context.collection.objects.link(thing)
    modifier = made.modifiers.new("mesh", "VOLUME_TO_MESH")
    modifier.object, modifier.threshold, modifier.grid_name = held, 0.5, "density"
    mesh = made.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    points = np.array([point.co[:] for point in mesh.vertices])
    return sum(volume(points, np.array([face.vertices[:]])) for face in mesh.polygons)


def seen_through(points, quads):
    """Where a floor 2 m below the middle of a ball of water is met by a ray that comes down at x = 1."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene

    def add(name, data, place=(0, 0, 0)):
        thing = bpy.data.objects.new(name, data)
        thing.location = place
        scene.collection.objects.link(thing)
        return thing

    def material(name, node):
        shade = bpy.data.materials.new(name)
        tree = shade.node_tree
        tree.nodes.clear()
        shader, end = tree.nodes.new(node), tree.nodes.new("ShaderNodeOutputMaterial")
        tree.links.new(shader.outputs[0], end.inputs["Surface"])
        return shade, tree, shader

    water, _, shader = material("water", "ShaderNodeBsdfRefraction")
    shader.inputs["IOR"].default_value, shader.inputs["Roughness"].default_value = 1.33, 0.0
    drop = bpy.data.meshes.new("drop")
    drop.from_pydata(points.tolist(), [], quads.tolist())
    drop.shade_smooth()
    drop.materials.append(water)
    add("drop", drop)
    marks, tree, shader = material("marks", "ShaderNodeEmission")  # as bright as x + 9
    place, parts, plus = (tree.nodes.new("ShaderNode" + kind) for kind in ("NewGeometry", "SeparateXYZ", "Math"))
    plus.inputs[1].default_value = 9.0
    tree.links.new(place.outputs["Position"], parts.inputs[0])
    tree.links.new(parts.outputs["X"], plus.inputs[0])
    tree.links.new(plus.outputs[0], shader.inputs["Strength"])
    floor = bpy.data.meshes.new("floor")
    floor.from_pydata([(-9, -9, -2.5), (9, -9, -2.5), (9, 9, -2.5), (-9, 9, -2.5)], [], [(0, 1, 2, 3)])
    floor.materials.append(marks)
    add("floor", floor)
    scene.camera = add("camera", bpy.data.cameras.new("camera"), (1, 0, 9))
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 0.3
    scene.render.engine, scene.cycles.samples = "CYCLES", 256
    scene.cycles.use_denoising, scene.cycles.sample_clamp_indirect = False, 0.0
    scene.render.resolution_x = scene.render.resolution_y = 4
    scene.render.image_settings.file_format, scene.render.filepath = "OPEN_EXR", os.path.abspath("seen.exr")
    scene.view_settings.view_transform = "Raw"
    bpy.ops.render.render(write_still=True)
    return float(np.mean(np.array(bpy.data.images.load(scene.render.filepath).pixels[:]).reshape(-1, 4)[:, 0])) - 9


ball = openvdb.createLevelSetSphere(radius=2.0, center=(0, 0, 0), voxelSize=VOXEL)
places = np.mgrid[-15:16, -15:16, -15:16] * VOXEL
fog = openvdb.FloatGrid(0.0)
fog.copyFromArray(np.clip((2.0 - np.sqrt((places**2).sum(0))) / 0.4 + 0.5, 0, 1).astype(np.float32), ijk=(-15, -15, -15))
fog.transform = openvdb.createLinearTransform(VOXEL)
mirrored = fog.deepCopy()
mirrored.transform = openvdb.createLinearTransform(
    [[-VOXEL, 0, 0, 0], [0, VOXEL, 0, 0], [0, 0, VOXEL, 0], [0, 0, 0, 1]])
whole = 4 / 3 * np.pi * 2.0**3
for name, found, wanted in [
    ("ball by convertToQuads", of_quads(ball, 0.0), -whole),
    ("ball by convertToPolygons", of_polygons(ball, 0.0), -whole),
    ("fog by convertToQuads", of_quads(fog, 0.5), -whole),
    ("mirrored fog by convertToQuads", of_quads(mirrored, 0.5), whole),
    ("fog by Blender's modifier", by_blender(fog), whole),
]:
    print("OpenVDB", openvdb.LIBRARY_VERSION, name + ": %.1f m3 of %.1f" % (found, whole), flush=True)
    if abs(found / wanted - 1) > 0.2:
        raise SystemExit("this has changed")
points, quads = ball.convertToQuads()
found = seen_through(points, quads), seen_through(points, quads[:, ::-1])
print("a ray at 1 m through a ball of water meets the floor at %.2f m, with faces turned round at %.2f m" % found)
if not found[0] > 2 or not 0.3 < found[1] < 0.36:
    raise SystemExit("this has changed")
END
venv/bin/python faces.py 2>&1 | grep "^OpenVDB\|^a ray\|changed"
