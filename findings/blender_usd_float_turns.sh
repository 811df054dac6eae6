#!/usr/bin/env bash
# Scattered leaves whose turns are in single floats all lie alike in Blender: it reads USD's half floats alone.
#
# Expected: `orientationsf` of a `PointInstancer` turns its instances, and is what counts where `orientations` is there
# too. USD has it since half floats are too coarse for some. A leaf that turns from 0 to 90 degrees within ten frames is at
# 45 degrees half way. What happens: Blender 5.3.0 reads `orientations` and nothing else. Where
# turns are in single floats no leaf is turned, at any frame; where both are there it takes the halves, which may be
# older. Places and sizes are right, so that a wood or a meadow looks like one, with all its leaves in parallel. Nothing
# is said. OpenUSD's own `ComputeInstanceTransformsAtTime` has the turns.
# Remedy: before import `orientations` from `orientationsf`, each as `Gf.Quath(turn)`, for every time sample.
# Versions: bpy 5.3.0, usd-core 26.11; bpy 5.0.1 has the same (PyPI). Source: measured here;
# https://openusd.org/release/api/class_usd_geom_point_instancer.html (orientationsf)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0
python3.13 -m venv usd
usd/bin/pip install --quiet usd-core==26.11
cat >write.py <<'END'
import math

from pxr import Gf, Usd, UsdGeom


def turn(degrees, kind):
    return kind(Gf.Quatd(Gf.Rotation((0, 0, 1), degrees).GetQuat()))


def write(name, halves, floats):
    """One leaf along x, with a turn for each frame of its half and its float orientations, in degrees."""
    stage = Usd.Stage.CreateNew(name + ".usda")
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.SetStageMetersPerUnit(stage, 1)
    stage.SetStartTimeCode(1)
    stage.SetEndTimeCode(11)
    leaf = UsdGeom.Mesh.Define(stage, "/leaves/leaf")
    leaf.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (1, 1, 0)])
    leaf.CreateFaceVertexCountsAttr([3])
    leaf.CreateFaceVertexIndicesAttr([0, 1, 2])
    leaves = UsdGeom.PointInstancer.Define(stage, "/leaves")
    leaves.CreatePrototypesRel().SetTargets(["/leaves/leaf"])
    leaves.CreateProtoIndicesAttr([0])
    positions = leaves.CreatePositionsAttr()
    for frame in (1, 11):
        positions.Set([(0, 0, 0)], frame)
    for attribute, kind, turns in [
        (leaves.CreateOrientationsAttr, Gf.Quath, halves), (leaves.CreateOrientationsfAttr, Gf.Quatf, floats),
    ]:
        for frame, degrees in turns.items():
            attribute().Set([turn(degrees, kind)], frame)
    found = []
    for frame in (1, 6, 11):
        matrix, = leaves.ComputeInstanceTransformsAtTime(frame, frame)
        x, y, _ = matrix.TransformDir((1, 0, 0))
        found.append(round(math.degrees(math.atan2(y, x))))
    print("OpenUSD", Usd.GetVersion(), name, "turns by", *found, flush=True)
    stage.Save()


write("halves", {1: 0, 11: 90}, {})
write("floats", {}, {1: 0, 11: 90})
write("both", {1: 20, 11: 20}, {1: 0, 11: 90})
END
cat >read.py <<'END'
import math

import bpy

for name, wanted in [("halves", [0, 45, 90]), ("floats", [0, 0, 0]), ("both", [20, 20, 20])]:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.usd_import(filepath=name + ".usda")
    found = []
    for frame in (1, 6, 11):
        bpy.context.scene.frame_set(frame)
        graph = bpy.context.evaluated_depsgraph_get()
        leaf, = (one.matrix_world.copy() for one in graph.object_instances if one.is_instance)
        found.append(round(math.degrees(math.atan2(leaf[1][0], leaf[0][0]))))
    print("bpy", bpy.app.version_string, name, "turns by", *found, flush=True)
    if found != wanted:
        raise SystemExit("this has changed")
END
usd/bin/python write.py
venv/bin/python read.py 2>&1 | grep "^bpy\|changed\|[Ww]arn"
