#!/usr/bin/env bash
# What twists keeps its width in Blender and in USD, and collapses on the way between them, in both directions.
#
# Expected: bones blend by matrices, which pinches what twists to a point at half a turn, or by dual quaternions, which
# keeps its width. UsdSkel has `skel:skinningMethod` for that, Blender *Preserve Volume*. A leaf that reaches 1 m from
# its axis, and of which one bone is turned by 170 degrees, reaches 1 m in the middle by dual quaternions, and 0.087 m,
# the cosine of 85 degrees, by matrices. What happens: Blender 5.3.0 imports `dualQuaternion` as an armature without
# *Preserve Volume*, and exports *Preserve Volume* without `skinningMethod`, so as `classicLinear`. It is 0.087 m either
# way. Frames in which nothing is twisted are right, so that the first one shows nothing. Nothing is said.
# Remedy: after import `use_deform_preserve_volume` for modifiers of the type ARMATURE; after export `skinningMethod`.
# Versions: bpy 5.3.0, usd-core 26.11; bpy 5.0.1 has the same (PyPI). Source: measured here, with OpenUSD for the truth;
# https://openusd.org/release/api/class_usd_skel_binding_a_p_i.html (skinningMethod);
# https://docs.blender.org/manual/en/latest/modeling/modifiers/deform/armature.html (Preserve Volume);
# Kavan, Collins, Zara, O'Sullivan 2007, Skinning with dual quaternions
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

from pxr import Gf, Usd, UsdGeom, UsdSkel

stage = Usd.Stage.CreateNew("twist.usda")
UsdGeom.SetStageUpAxis(stage, "Z")
UsdGeom.SetStageMetersPerUnit(stage, 1)
stage.SetStartTimeCode(1)
stage.SetEndTimeCode(2)
root = UsdSkel.Root.Define(stage, "/leaf")
stage.SetDefaultPrim(root.GetPrim())
skeleton = UsdSkel.Skeleton.Define(stage, "/leaf/skeleton")
skeleton.CreateJointsAttr(["base", "base/tip"])
skeleton.CreateBindTransformsAttr([Gf.Matrix4d(1)] * 2)
skeleton.CreateRestTransformsAttr([Gf.Matrix4d(1)] * 2)
animation = UsdSkel.Animation.Define(stage, "/leaf/animation")
animation.CreateJointsAttr(["base", "base/tip"])
animation.CreateTranslationsAttr([(0, 0, 0)] * 2)
animation.CreateScalesAttr([Gf.Vec3h(1)] * 2)
half = math.radians(170) / 2
turned = Gf.Quatf(math.cos(half), Gf.Vec3f(math.sin(half), 0, 0))
animation.CreateRotationsAttr().Set([Gf.Quatf(1)] * 2, 1)
animation.GetRotationsAttr().Set([Gf.Quatf(1), turned], 2)
UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().SetTargets(["/leaf/animation"])
for method in "classicLinear", "dualQuaternion":
    mesh = UsdGeom.Mesh.Define(stage, "/leaf/" + method)
    mesh.CreatePointsAttr([(0, 1, 0), (1, 1, 0), (2, 1, 0)])
    mesh.CreateFaceVertexCountsAttr([3])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
    mesh.CreateSubdivisionSchemeAttr("none")
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    binding.CreateSkeletonRel().SetTargets(["/leaf/skeleton"])
    binding.CreateJointIndicesPrimvar(False, 2).Set([0, 1] * 3)
    binding.CreateJointWeightsPrimvar(False, 2).Set([1, 0, 0.5, 0.5, 0, 1])
    binding.CreateSkinningMethodAttr(method)
stage.Save()
END
cat >blender.py <<'END'
import math
import os

import bpy


def width(thing):
    """Of the middle, from the axis."""
    bpy.context.scene.frame_set(2)
    middle = thing.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.vertices[1].co
    return math.hypot(middle.y, middle.z)


def check(text, found, wanted):
    print("bpy", bpy.app.version_string, text, "is %.3f m wide" % found, flush=True)
    if abs(found - wanted) > 1e-3:
        raise SystemExit("this has changed")


bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.usd_import(filepath=os.path.abspath("twist.usda"))
for method, wanted in ("classicLinear", 0.087), ("dualQuaternion", 0.087):
    check("imported by " + method, width(bpy.data.objects[method]), wanted)
for modifier in bpy.data.objects["dualQuaternion"].modifiers:
    modifier.use_deform_preserve_volume = True
check("imported by dualQuaternion, with Preserve Volume,", width(bpy.data.objects["dualQuaternion"]), 1)

bpy.ops.wm.read_factory_settings(use_empty=True)
bones = bpy.data.armatures.new("bones")
armature = bpy.data.objects.new("armature", bones)
bpy.context.collection.objects.link(armature)
bpy.context.view_layer.objects.active = armature
bpy.ops.object.mode_set(mode="EDIT")
base, tip = bones.edit_bones.new("base"), bones.edit_bones.new("tip")
base.tail, tip.head, tip.tail = (1, 0, 0), (1, 0, 0), (2, 0, 0)
tip.parent = base
bpy.ops.object.mode_set(mode="OBJECT")
mesh = bpy.data.meshes.new("leaf")
mesh.from_pydata([(0, 1, 0), (1, 1, 0), (2, 1, 0)], [], [(0, 1, 2)])
leaf = bpy.data.objects.new("leaf", mesh)
leaf.parent = armature
bpy.context.collection.objects.link(leaf)
for name, weights in ("base", (1, 0.5, 0)), ("tip", (0, 0.5, 1)):
    group = leaf.vertex_groups.new(name=name)
    for index, weight in enumerate(weights):
        group.add([index], weight, "REPLACE")
modifier = leaf.modifiers.new("armature", "ARMATURE")
modifier.object, modifier.use_deform_preserve_volume = armature, True
bone = armature.pose.bones["tip"]
bone.rotation_mode = "QUATERNION"
bone.keyframe_insert("rotation_quaternion", frame=1)
half = math.radians(170) / 2
bone.rotation_quaternion = (math.cos(half), 0, math.sin(half), 0)  # about its own y, which is along the bone
bone.keyframe_insert("rotation_quaternion", frame=2)
bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 2
check("with Preserve Volume", width(leaf), 1)
bpy.ops.wm.usd_export(filepath=os.path.abspath("exported.usda"), export_animation=True)
END
cat >read.py <<'END'
import math
import sys

from pxr import Gf, Usd, UsdSkel

for name, wanted in ("twist.usda", {"classicLinear": 0.087, "dualQuaternion": 1}), ("exported.usda", {"leaf": 0.087}):
    if name not in sys.argv:
        continue
    stage = Usd.Stage.Open(name)
    roots = [UsdSkel.Root(prim) for prim in stage.Traverse() if prim.IsA(UsdSkel.Root)]
    UsdSkel.BakeSkinning(roots[0], Gf.Interval(1, 2))
    for prim in stage.Traverse():
        if prim.GetTypeName() == "Mesh":
            middle = prim.GetAttribute("points").Get(2)[1]
            label = prim.GetName() if prim.GetName() in wanted else prim.GetParent().GetName()
            width = math.hypot(middle[1], middle[2])
            print("usd-core 26.11", name, label, "is %.3f m wide" % width, flush=True)
            if abs(width - wanted[label]) > 1e-3:
                raise SystemExit("this has changed")
END
usd/bin/python write.py
usd/bin/python read.py twist.usda
venv/bin/python blender.py 2>&1 | grep "^bpy\|changed\|Error"
usd/bin/python read.py exported.usda
