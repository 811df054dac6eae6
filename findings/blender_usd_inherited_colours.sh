#!/usr/bin/env bash
# A tint that USD hands down from a tree to its leaves never reaches them in Blender: the leaves are black.
#
# Expected: a `constant` primvar is inherited by all below the prim that has it, unless one of them has its own. So one
# `primvars:displayColor` on a tree, or on each of many instances of one leaf, tints leaves whose material reads it by a
# `UsdPrimvarReader`. Below a white sky a matte leaf of 0.9 0.1 0 has that radiance. What happens: Blender 5.3.0 imports
# the primvars of a mesh and leaves out those of what is above it, as attributes and as properties. The material asks
# for an attribute `displayColor` that is not there, and the leaf is black; so are instances of one leaf in two tints.
# `displayColor` of a mesh is right, and Blender's own export writes no other, so that a round trip shows nothing.
# Nothing is said.
# Remedy: before import give each mesh what `UsdGeom.PrimvarsAPI(mesh).FindPrimvarWithInheritance` finds; no instances.
# Versions: bpy 5.3.0 with numpy 2.5.5, usd-core 26.11; bpy 5.0.1 has the same (PyPI). Source: measured here;
# https://openusd.org/release/api/class_usd_geom_primvars_a_p_i.html (namespace inheritance of constant primvars)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 numpy==2.5.5
python3.13 -m venv usd
usd/bin/pip install --quiet usd-core==26.11
cat >tree.py <<'END'
from pxr import Usd, UsdGeom

with open("tree.usda", "w") as file:
    file.write("""#usda 1.0
(
    defaultPrim = "World"
    metersPerUnit = 1
    upAxis = "Z"
)
class Mesh "Leaf" (prepend apiSchemas = ["MaterialBindingAPI"])
{
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(-0.4, -0.4, 0), (0.4, -0.4, 0), (0.4, 0.4, 0), (-0.4, 0.4, 0)]
    uniform token subdivisionScheme = "none"
    rel material:binding = </World/tint>
}
class Xform "Twig"
{
    def Mesh "leaf" (inherits = </Leaf>)
    {
    }
}
def Xform "World"
{
    def Material "tint"
    {
        token outputs:surface.connect = </World/tint/surface.outputs:surface>
        def Shader "surface"
        {
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor.connect = </World/tint/reader.outputs:result>
            float inputs:ior = 1
            float inputs:roughness = 1
            token outputs:surface
        }
        def Shader "reader"
        {
            uniform token info:id = "UsdPrimvarReader_float3"
            string inputs:varname = "displayColor"
            float3 outputs:result
        }
    }
    def Xform "own_place"
    {
        double3 xformOp:translate = (0, 0, 0)
        uniform token[] xformOpOrder = ["xformOp:translate"]
        def Mesh "own" (inherits = </Leaf>)
        {
            color3f[] primvars:displayColor = [(0.9, 0.1, 0)] (interpolation = "constant")
        }
    }
    def Xform "tree"
    {
        color3f[] primvars:displayColor = [(0.9, 0.1, 0)] (interpolation = "constant")
        double3 xformOp:translate = (1, 0, 0)
        uniform token[] xformOpOrder = ["xformOp:translate"]
        def Mesh "inherited" (inherits = </Leaf>)
        {
        }
    }
    def Xform "green" (
        inherits = </Twig>
        instanceable = true
    )
    {
        color3f[] primvars:displayColor = [(0.1, 0.9, 0)] (interpolation = "constant")
        double3 xformOp:translate = (2, 0, 0)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
    def Xform "blue" (
        inherits = </Twig>
        instanceable = true
    )
    {
        color3f[] primvars:displayColor = [(0.1, 0, 0.9)] (interpolation = "constant")
        double3 xformOp:translate = (3, 0, 0)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
}
""")
stage = Usd.Stage.Open("tree.usda")
for path, wanted in (
    ("/World/own_place/own", (0.9, 0.1, 0)), ("/World/tree/inherited", (0.9, 0.1, 0)),
    ("/World/green/leaf", (0.1, 0.9, 0)), ("/World/blue/leaf", (0.1, 0, 0.9)),
):
    found = UsdGeom.PrimvarsAPI(stage.GetPrimAtPath(path)).FindPrimvarWithInheritance("displayColor").Get()[0]
    print("usd-core 26.11", path, "has the tint", *(f"{number:.1f}" for number in found), flush=True)
    if (found - type(found)(wanted)).GetLength() > 1e-6:
        raise SystemExit("this has changed")
END
cat >look.py <<'END'
import glob
import os
import sys

import bpy

sys.path += glob.glob(sys.prefix + "/lib/python*/site-packages/bpy/*/python/lib/python*/site-packages")
import numpy as np
import OpenImageIO as oiio

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.usd_import(filepath=os.path.abspath("tree.usda"))
scene = bpy.context.scene
scene.world = bpy.data.worlds.new("white")
scene.world.use_nodes = True
scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
lens = bpy.data.cameras.new("camera")
lens.type, lens.ortho_scale = "ORTHO", 4
camera = bpy.data.objects.new("camera", lens)
camera.location = (1.5, 0, 3)
scene.collection.objects.link(camera)
scene.camera = camera
scene.render.engine, scene.cycles.samples, scene.cycles.device = "CYCLES", 64, "CPU"
scene.cycles.use_denoising, scene.cycles.use_adaptive_sampling = False, False
scene.render.resolution_x, scene.render.resolution_y = 40, 10
scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
scene.render.filepath = os.path.abspath("leaves.exr")
bpy.ops.render.render(write_still=True)
pixels = np.array(oiio.ImageBuf(scene.render.filepath).get_pixels("float"))
leaves = [("own", (0.9, 0.1, 0)), ("inherited", (0, 0, 0)), ("green instance", (0, 0, 0)), ("blue instance", (0, 0, 0))]
for index, (name, wanted) in enumerate(leaves):
    found = pixels[3:7, 10 * index + 3:10 * index + 7, :3].mean(axis=(0, 1))
    print("bpy", bpy.app.version_string, name, "leaf has the colour", *("%.2f" % part for part in found), flush=True)
    if np.abs(found - wanted).max() > 0.03:
        raise SystemExit("this has changed")
attributes = [attribute.name for attribute in bpy.data.objects["inherited"].data.attributes]
if "displayColor" in attributes:
    raise SystemExit("this has changed")
END
usd/bin/python tree.py
venv/bin/python look.py 2>&1 | grep "^bpy\|changed\|Error"
