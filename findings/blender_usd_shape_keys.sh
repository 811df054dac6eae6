#!/usr/bin/env bash
# Blender's USD export drops the weights of shape keys, what they are relative to, their vertex groups, and muting.
#
# Expected: a key moves points by how it differs from its *Relative To* key, where its vertex group says, unless it is
# muted; that is what Blender draws, and what it exports with *Shape Keys* off. What happens: *Shape Keys* is on and
# *Animation* off by default, and so Blender 5.3.0 writes no weights at all: what is curled lies flat. With *Animation*
# each blend shape is the difference from the basis, for all points, and muted keys have their weights. Two keys of 1
# and 3 m, the second relative to the first, at weights of 1: Blender has 3 m, USD 4. A key of one corner lifts all
# four, and one that is muted curls a leaf that is flat. Nothing is said. The glTF export has vertex groups and
# *Relative To* wrong as well, as issues of 2019 and 2021 tell.
# Remedy: export with *Shape Keys* off: points of every frame, as Blender draws them.
# Versions: bpy 5.3.0, usd-core 26.11; bpy 5.0.1 has the same (PyPI). Source: measured here;
# https://docs.blender.org/manual/en/latest/animation/shape_keys/shape_keys_panel.html;
# https://github.com/KhronosGroup/glTF-Blender-IO (issues 747, 1403)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0
python3.13 -m venv pixar
pixar/bin/pip install --quiet usd-core==26.11
cat >export.py <<'END'
import json
import os

import bpy


def still(mesh, keys):
    keys[1].value, keys[2].value = 0, 1


def relative(mesh, keys):
    keys[2].relative_key = keys[1]
    keys[1].value = keys[2].value = 1


def grouped(mesh, keys):
    mesh.vertex_groups.new(name="corner").add([0], 1.0, "REPLACE")
    keys[2].vertex_group = "corner"
    keys[1].value, keys[2].value = 0, 1


def muted(mesh, keys):
    keys[2].mute = True
    keys[1].value, keys[2].value = 0, 1


for case in (still, relative, grouped, muted):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.mesh.primitive_plane_add(size=2)
    mesh = bpy.context.object
    for name, height in [("basis", 0), ("low", 1), ("high", 3)]:
        for point in mesh.shape_key_add(name=name).data:
            point.co.z = height
    case(mesh, mesh.data.shape_keys.key_blocks)
    bpy.context.view_layer.update()
    drawn = mesh.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    with open(f"{case.__name__}.json", "w") as file:
        json.dump([vertex.co.z for vertex in drawn.vertices], file)
    bpy.context.scene.frame_end = 1
    for keys in (True, False):
        path = os.path.abspath(f"{case.__name__}_{keys}.usda")
        bpy.ops.wm.usd_export(filepath=path, export_shapekeys=keys, export_animation=case != still)
END
cat >read.py <<'END'
import json

from pxr import Gf, Usd, UsdGeom, UsdSkel

for case, wanted in [("still", [0] * 4), ("relative", [4] * 4), ("grouped", [3] * 4), ("muted", [3] * 4)]:
    with open(f"{case}.json") as file:
        drawn = json.load(file)
    heights = []
    for keys in (True, False):
        stage = Usd.Stage.Open(f"{case}_{keys}.usda")
        for prim in list(stage.Traverse()):
            if prim.IsA(UsdSkel.Root):
                UsdSkel.BakeSkinning(UsdSkel.Root(prim), Gf.Interval(1, 1))
        mesh = next(UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh))
        heights.append([round(point[2], 4) for point in mesh.GetPointsAttr().Get(1)])
    print("bpy 5.3.0", case, "corners by Blender:", drawn, "by its USD with shape keys:", heights[0],
          "without:", heights[1])
    if heights != [wanted, drawn]:
        raise SystemExit("this has changed")
END
venv/bin/python export.py >export.log 2>&1 || { cat export.log; exit 1; }
pixar/bin/python read.py
