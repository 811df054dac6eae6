#!/usr/bin/env bash
# Blender's USD import moves with its parent what `!resetXformStack!` has freed from it: lamps and cameras are elsewhere.
#
# Expected: where `xformOpOrder` begins with `!resetXformStack!` a prim is where its own operations put it, whatever its
# parents do. A rig in this way holds what stands still in the world: a camera below a car, a sun below a turning set.
# What happens: Blender 5.3.0 drops the word and keeps the parent. A mesh, a camera and a lamp at x = 1 below a parent
# that goes from 5 to 15 m are at 6 to 16 m, with `merge_parent_xform` and without. Nothing is said.
# Remedy: compose world matrices before (`UsdGeom.XformCache`), and put such prims beside the parent.
# Versions: bpy 5.3.0, usd-core 26.11; bpy 5.0.1 has the same (PyPI). Source: measured here;
# https://openusd.org/release/api/class_usd_geom_xformable.html (GetResetXformStack)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 usd-core==26.11
cat >rig.usda <<'END'
#usda 1.0
(
    defaultPrim = "rig"
    metersPerUnit = 1
    upAxis = "Z"
    endTimeCode = 10
    startTimeCode = 0
)
def Xform "rig"
{
    double3 xformOp:translate.timeSamples = { 0: (5, 0, 0), 10: (15, 0, 0) }
    uniform token[] xformOpOrder = ["xformOp:translate"]

    def Mesh "mesh"
    {
        int[] faceVertexCounts = [3]
        int[] faceVertexIndices = [0, 1, 2]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0)]
        double3 xformOp:translate = (1, 0, 0)
        uniform token[] xformOpOrder = ["!resetXformStack!", "xformOp:translate"]
    }
    def Camera "camera"
    {
        double3 xformOp:translate = (1, 0, 0)
        uniform token[] xformOpOrder = ["!resetXformStack!", "xformOp:translate"]
    }
    def SphereLight "lamp"
    {
        double3 xformOp:translate = (1, 0, 0)
        uniform token[] xformOpOrder = ["!resetXformStack!", "xformOp:translate"]
    }
}
END
cat >in_usd.py <<'END'
from pxr import Usd, UsdGeom

stage = Usd.Stage.Open("rig.usda")
for name in ("mesh", "camera", "lamp"):
    prim = UsdGeom.Xformable(stage.GetPrimAtPath("/rig/" + name))
    found = [prim.ComputeLocalToWorldTransform(time).ExtractTranslation()[0] for time in (0, 10)]
    print("USD", Usd.GetVersion(), name, "from", *found, flush=True)
    if found != [1, 1]:
        raise SystemExit("this has changed")
END
cat >in_blender.py <<'END'
import os

import bpy

for merge in (True, False):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.usd_import(filepath=os.path.abspath("rig.usda"), merge_parent_xform=merge)
    for name in ("mesh", "camera", "lamp"):
        found = []
        for frame in (0, 10):
            bpy.context.scene.frame_set(frame)
            placed = bpy.data.objects[name].evaluated_get(bpy.context.evaluated_depsgraph_get())
            found.append(round(placed.matrix_world.translation.x, 3))
        print("bpy", bpy.app.version_string, name, "from", *found, "merged" if merge else "", flush=True)
        if found != [6, 16]:
            raise SystemExit("this has changed")
END
venv/bin/python in_usd.py 2>&1 | grep "^USD\|changed"
venv/bin/python in_blender.py 2>&1 | grep "^bpy\|changed"
