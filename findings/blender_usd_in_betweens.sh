#!/usr/bin/env bash
# Blender's USD import drops the in-betweens of blend shapes: what curls on its way goes straight.
#
# Expected: a `BlendShape` of UsdSkel may have in-betweens, shapes for weights within 0 and 1, through which points go.
# A corner that is to be 2 m up at a weight of 0.5, and 1 m at 1, is there; at 0.25 it is 1 m up. What happens: Blender
# 5.3.0 makes one shape key of it, that of weight 1, so that the corner is 0.5 m up at 0.5 and 0.25 at 0.25. Nothing is
# said. The ends of an animation are right, so that the first and the last frame show nothing.
# Remedy: `UsdSkel.BakeSkinning(UsdSkel.Root(prim), Gf.Interval(first, last))` makes points of it that Blender reads.
# Versions: bpy 5.3.0, usd-core 26.11; bpy 5.0.1 has the same (PyPI). Source: measured here;
# https://openusd.org/release/api/_usd_skel__schemas.html (Inbetween shapes)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 usd-core==26.11
cat >write.py <<'END'
from pxr import Gf, Usd, UsdGeom, UsdSkel

stage = Usd.Stage.CreateNew("leaf.usda")
UsdGeom.SetStageUpAxis(stage, "Z")
UsdGeom.SetStageMetersPerUnit(stage, 1)
stage.SetStartTimeCode(0)
stage.SetEndTimeCode(100)
root = UsdSkel.Root.Define(stage, "/leaves")
stage.SetDefaultPrim(root.GetPrim())
leaf = UsdGeom.Mesh.Define(stage, "/leaves/leaf")
leaf.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
leaf.CreateFaceVertexCountsAttr([4])
leaf.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
leaf.CreateSubdivisionSchemeAttr("none")
curl = UsdSkel.BlendShape.Define(stage, "/leaves/leaf/curl")
curl.CreatePointIndicesAttr([2])
curl.CreateOffsetsAttr([(0, 0, 1)])
half = curl.CreateInbetween("half")
half.SetWeight(0.5)
half.SetOffsets([(0, 0, 2)])
skeleton = UsdSkel.Skeleton.Define(stage, "/leaves/skeleton")
skeleton.CreateJointsAttr(["joint"])
skeleton.CreateBindTransformsAttr([Gf.Matrix4d(1)])
skeleton.CreateRestTransformsAttr([Gf.Matrix4d(1)])
animation = UsdSkel.Animation.Define(stage, "/leaves/animation")
animation.CreateBlendShapesAttr(["curl"])
animation.CreateBlendShapeWeightsAttr().Set([0.0], 0)
animation.GetBlendShapeWeightsAttr().Set([1.0], 100)
UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().SetTargets(["/leaves/animation"])
binding = UsdSkel.BindingAPI.Apply(leaf.GetPrim())
binding.CreateSkeletonRel().SetTargets(["/leaves/skeleton"])
binding.CreateBlendShapesAttr(["curl"])
binding.CreateBlendShapeTargetsRel().SetTargets(["/leaves/leaf/curl"])
binding.CreateJointIndicesPrimvar(False, 1).Set([0] * 4)
binding.CreateJointWeightsPrimvar(False, 1).Set([1.0] * 4)
stage.Save()
UsdSkel.BakeSkinning(root, Gf.Interval(0, 100))
for time, wanted in ((0, 0), (25, 1), (50, 2), (75, 1.5), (100, 1)):
    found = leaf.GetPointsAttr().Get(time)[2][2]
    print("USD", Usd.GetVersion(), "weight", time / 100, "corner at", found, flush=True)
    if abs(found - wanted) > 1e-5:
        raise SystemExit("this has changed")
stage.Export("baked.usda")
END
cat >in_blender.py <<'END'
import os

import bpy

for name, heights in (("leaf", (0, 0.25, 0.5, 0.75, 1)), ("baked", (0, 1, 2, 1.5, 1))):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.usd_import(filepath=os.path.abspath(name + ".usda"))
    leaf = next(thing for thing in bpy.data.objects if thing.type == "MESH")
    for frame, wanted in zip((0, 25, 50, 75, 100), heights):
        bpy.context.scene.frame_set(frame)
        mesh = leaf.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
        print("bpy", bpy.app.version_string, name, "weight", frame / 100, "corner at %.3f" % mesh.vertices[2].co.z, flush=True)
        if abs(mesh.vertices[2].co.z - wanted) > 0.001:
            raise SystemExit("this has changed")
END
venv/bin/python write.py 2>&1 | grep "^USD\|changed"
venv/bin/python in_blender.py 2>&1 | grep "^bpy\|changed"
