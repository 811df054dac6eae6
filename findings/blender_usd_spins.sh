#!/usr/bin/env bash
# What spins flips back for half a frame once a turn in Blender's USD: motion blur of it is a smear the other way.
#
# Expected: something that turns by 30 degrees a frame is at 165 degrees half a frame after 150. What happens: Blender
# 5.3.0 writes `rotateXYZ` of every frame between -180 and 180 degrees, as it exports by default. USD interpolates the
# numbers, so half way from 150 to -180 it is at -15: 180 degrees off, and the wrong way round all that frame. Renderers
# that take samples within a shutter see that; so does Blender itself once it has read the file. With *Translate,
# Rotate, Scale* as a matrix (`MAT`) angles are right and things shrink between frames, here to 0.966.
# Remedy: export with `xform_op_mode="TOS"` (orient): 165 degrees, and no shrinking.
# Versions: bpy 5.3.0, usd-core 26.11, bpy 5.0.1 has the same (PyPI). Source: measured here;
# https://openusd.org/release/api/class_usd_geom_xform_op.html (values are interpolated one by one)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
cat >spin.py <<'END'
import math
import os

import bpy

for mode in ("TRS", "TOS", "MAT"):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 0, 12
    bpy.ops.mesh.primitive_plane_add()
    for frame in range(13):
        bpy.context.object.rotation_euler = (0, 0, math.radians(30 * frame))
        bpy.context.object.keyframe_insert("rotation_euler", frame=frame)
    options = {} if mode == "TRS" else {"xform_op_mode": mode}
    bpy.ops.wm.usd_export(filepath=os.path.abspath(mode + ".usda"), export_animation=True, **options)

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.usd_import(filepath=os.path.abspath("TRS.usda"))
plane = next(thing for thing in bpy.data.objects if thing.type == "MESH")
bpy.context.scene.frame_set(5, subframe=0.5)
matrix = plane.evaluated_get(bpy.context.evaluated_depsgraph_get()).matrix_world
degrees = math.degrees(math.atan2(matrix[1][0], matrix[0][0])) % 360
print("bpy", bpy.app.version_string, "TRS, read back, frame 5.5: %.1f degrees" % degrees, flush=True)
if abs(degrees - 345) > 0.1:
    raise SystemExit("this has changed")
END
cat >look.py <<'END'
import math

from pxr import Gf, Usd, UsdGeom

for mode, wanted, size in (("TRS", 345, 1), ("TOS", 165, 1), ("MAT", 165, 0.966)):
    stage = Usd.Stage.Open(mode + ".usda")
    spins = next(prim for prim in stage.Traverse() if UsdGeom.Xformable(prim).TransformMightBeTimeVarying())
    arrow = UsdGeom.Xformable(spins).ComputeLocalToWorldTransform(5.5).TransformDir(Gf.Vec3d(1, 0, 0))
    degrees = math.degrees(math.atan2(arrow[1], arrow[0])) % 360
    print("USD", Usd.GetVersion(), mode, "frame 5.5: %.1f degrees, size %.3f" % (degrees, arrow.GetLength()), flush=True)
    if abs(degrees - wanted) > 0.1 or abs(arrow.GetLength() - size) > 0.001:
        raise SystemExit("this has changed")
END
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 usd-core==26.11
venv/bin/python spin.py 2>&1 | grep "^bpy\|changed"
venv/bin/python look.py 2>&1 | grep "^USD\|changed"
