#!/usr/bin/env bash
# A neon tube of USD is a point of one brightness in Blender, 50 times too bright here; glowing meshes of USD are dark.
#
# Expected: lamps of UsdLux have a radiance, so the light of a `CylinderLight` goes with its length and its width, and its
# shadows are as soft as a tube's; a mesh with `MeshLightAPI` shines; `shaping:cone:angle` cuts off the light of a panel or
# a disc as it does that of a ball, so that there is none at 37 degrees with a cone of 10. What happens: Blender 5.3.0 makes
# a point without size of every tube, with `intensity` times pi watts, whatever its length and radius. Below a tube of 2 m,
# 0.1 m thick, a floor at 4 m is 5 times too bright, below one of 1 m and 0.02 m 50 times. A ball with `treatAsPoint`
# goes the same way, 127 times too bright at a radius of 0.05 m. The mesh comes without its light. Cones of panels and
# discs are passed over. Balls, cones of balls, panels and discs without cones are right. Nothing is said.
# Remedy: after import panels of the length and twice the radius for tubes; an emission for the mesh; `spread` for cones.
# Versions: bpy 5.3.0 with numpy 2.5.5, usd-core 26.11 (PyPI). Source: measured here;
# https://openusd.org/release/api/class_usd_lux_cylinder_light.html; https://openusd.org/release/api/usd_lux_page_front.html
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
from pxr import Usd, UsdGeom, UsdLux


def stage(name):
    made = Usd.Stage.CreateNew(name + ".usda")
    UsdGeom.SetStageUpAxis(made, "Z")
    UsdGeom.SetStageMetersPerUnit(made, 1)
    return made


def lamp(name, schema, cone=None, **sizes):
    """A lamp of radiance 10, 4 m above the floor, that shines down."""
    made = stage(name)
    light = getattr(UsdLux, schema).Define(made, "/lamp")
    light.CreateIntensityAttr(10)
    light.AddTranslateOp().Set((0, 0, 4))
    for size, value in sizes.items():
        getattr(light, "Create%sAttr" % size)(value)
    if cone:
        UsdLux.ShapingAPI.Apply(light.GetPrim()).CreateShapingConeAngleAttr(cone)
    made.Save()


def glowing_mesh(name):
    made = stage(name)
    mesh = UsdGeom.Mesh.Define(made, "/lamp")
    mesh.CreatePointsAttr([(-0.25, -0.5, 4), (-0.25, 0.5, 4), (0.25, 0.5, 4), (0.25, -0.5, 4)])
    mesh.CreateFaceVertexCountsAttr([4])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    UsdLux.MeshLightAPI.Apply(mesh.GetPrim())
    UsdLux.LightAPI(mesh.GetPrim()).CreateIntensityAttr(10)
    made.Save()


lamp("ball", "SphereLight", Radius=0.05)
lamp("ball_as_point", "SphereLight", Radius=0.05, TreatAsPoint=True)
lamp("panel", "RectLight", Width=0.5, Height=1)
lamp("tube", "CylinderLight", Radius=0.05, Length=2)
lamp("thin_tube", "CylinderLight", Radius=0.01, Length=1)
glowing_mesh("mesh")
lamp("ball_with_cone", "SphereLight", cone=10, Radius=0.05)
lamp("panel_with_cone", "RectLight", cone=10, Width=0.1, Height=0.1)
lamp("disc_with_cone", "DiskLight", cone=10, Radius=0.05)
END
cat >look.py <<'END'
import os

import bpy
import numpy as np

X = np.linspace(-1, 1, 2001)


def tube(length, radius):
    """What a white floor 4 m below a thin tube sends back: irradiance / pi."""
    half = length / 2
    return 10 * 2 * radius * np.mean(16 / (16 + (X * half) ** 2) ** 2) * length / np.pi


def floor_at(x):
    """What a white floor sends back at x, in Cycles."""
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", 256, False
    scene.cycles.use_adaptive_sampling, scene.cycles.max_bounces = False, 0
    scene.render.resolution_x = scene.render.resolution_y = 1
    scene.render.image_settings.file_format, scene.render.filepath = "OPEN_EXR", os.path.abspath("out.exr")
    scene.render.image_settings.color_depth = "32"
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.ortho_scale, camera.location = "ORTHO", 0.01, (x, 0, 1)
    scene.collection.objects.link(camera)
    scene.camera = camera
    bpy.ops.render.render(write_still=True)
    return bpy.data.images.load(scene.render.filepath, check_existing=False).pixels[0]


def white_floor():
    bpy.ops.mesh.primitive_plane_add(size=99)
    material = bpy.data.materials.new("white")
    tree = material.node_tree
    tree.nodes.clear()
    white, out = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeOutputMaterial")
    white.inputs["Color"].default_value = (1, 1, 1, 1)
    tree.links.new(white.outputs[0], out.inputs["Surface"])
    bpy.context.object.data.materials.append(material)


BALL, PANEL, POINT = 10 * 0.05**2 / 16, 10 * 0.5 / 16 / np.pi, 10 / 16 / np.pi
SMALL, AT_3_M = 10 * 0.01 / 16 / np.pi, (16 / 25) ** 2  # a small panel, and what of its light is left at x = 3 m
for name, x, right, wanted in [
    ("ball", 0, BALL, BALL), ("panel", 0, PANEL, PANEL),
    ("tube", 0, tube(2, 0.05), POINT), ("thin_tube", 0, tube(1, 0.01), POINT), ("ball_as_point", 0, BALL, POINT),
    ("mesh", 0, PANEL, 0), ("ball_with_cone", 0, BALL, BALL), ("ball_with_cone", 3, 0, 0),
    ("panel_with_cone", 3, 0, SMALL * AT_3_M), ("disc_with_cone", 3, 0, BALL * AT_3_M),
]:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.usd_import(filepath=name + ".usda")
    white_floor()
    found = floor_at(x)
    print("bpy", bpy.app.version_string, name, "at %d m: %.5f, by UsdLux %.5f" % (x, found, right), flush=True)
    if abs(found - wanted) > 0.03 * wanted + 1e-6:
        raise SystemExit("this has changed")
END
usd/bin/python write.py
venv/bin/python look.py 2>&1 | grep "^bpy\|changed\|Error\|[Ww]arn"
