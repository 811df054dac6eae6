#!/usr/bin/env bash
# Blender's USD import loses births: a mesh that appears later is there from the start, an instance may never come.
#
# Expected: what has `visibility` "invisible" until frame 10 is seen from there on, and an instance whose id is among
# `invisibleIds` until then as well. What happens: Blender 5.3.0 imports the mesh without any visibility, so it is drawn
# in all frames. It follows `invisibleIds` where the instancer's positions have time samples too. Where they have none,
# the ids of the start count for ever, and what was hidden then never comes. Nothing is said of either.
# Remedy: samples of a scale of almost 0 while a mesh is not there; two equal samples of an instancer's positions.
# Versions: bpy 5.3.0, bpy 5.0.1 has the same (PyPI). Source: measured here;
# https://openusd.org/release/api/class_usd_geom_point_instancer.html (masking instances)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0
cat >leaves.usda <<'END'
#usda 1.0
(
    defaultPrim = "wood"
    endTimeCode = 20
    metersPerUnit = 1
    startTimeCode = 1
    upAxis = "Z"
)
def Xform "wood"
{
    def Mesh "mesh"
    {
        int[] faceVertexCounts = [3]
        int[] faceVertexIndices = [0, 1, 2]
        point3f[] points = [(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0)]
        token visibility.timeSamples = { 1: "invisible", 10: "inherited" }
    }
    def PointInstancer "still"
    {
        int64[] ids = [10, 11]
        int64[] invisibleIds.timeSamples = { 1: [11], 10: [] }
        point3f[] positions = [(1, 0, 0), (2, 0, 0)]
        int[] protoIndices = [0, 0]
        rel prototypes = </wood/still/leaf>
        def Mesh "leaf"
        {
            int[] faceVertexCounts = [3]
            int[] faceVertexIndices = [0, 1, 2]
            point3f[] points = [(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0)]
        }
    }
    def PointInstancer "sampled"
    {
        int64[] ids = [10, 11]
        int64[] invisibleIds.timeSamples = { 1: [11], 10: [] }
        point3f[] positions.timeSamples = { 1: [(3, 0, 0), (4, 0, 0)], 20: [(3, 0, 0), (4, 0, 0)] }
        int[] protoIndices = [0, 0]
        rel prototypes = </wood/sampled/leaf>
        def Mesh "leaf"
        {
            int[] faceVertexCounts = [3]
            int[] faceVertexIndices = [0, 1, 2]
            point3f[] points = [(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0)]
        }
    }
}
END
cat >births.py <<'END'
import os

import bpy

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.usd_import(filepath=os.path.abspath("leaves.usda"))
# The mesh is at 0; of each instancer the second leaf, at 2 and at 4, is hidden until frame 10.
for frame, wanted in [(1, [0, 1, 3]), (15, [0, 1, 3, 4])]:
    bpy.context.scene.frame_set(frame)
    drawn = bpy.context.evaluated_depsgraph_get().object_instances
    found = sorted(round(each.matrix_world.translation.x) for each in drawn
                   if each.object.type == "MESH" and each.show_self and not each.object.hide_render)
    print("bpy", bpy.app.version_string, "frame", frame, "has what is at x =", found, flush=True)
    if found != wanted:
        raise SystemExit("this has changed")
END
venv/bin/python births.py 2>&1 | grep "^bpy\|changed"
