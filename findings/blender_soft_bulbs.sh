#!/usr/bin/env bash
# Wide bulbs are too dark in Blender, by a fifth at twice their radius: *Soft Falloff*, on by itself, weakens all light.
#
# Expected: a ball of radius r and radiance L gives pi L r^2 / d^2 to a floor that faces its middle at a distance d, as
# far as that is outside of it; UsdLux has that by definition. Of *Soft Falloff* the manual says that it avoids sharp
# edges where lamps touch things. What happens: Cycles of Blender 5.3.0 divides their light by 1 + (r / d)^2 everywhere.
# A bulb of 0.5 m at 2 m has 0.94, one of 1 m 0.80, one of 1.5 m 0.64 of its light; a ball that glows with the same
# radiance has 1. Points and spots have the option on when they are made, and so have all that Blender imports from USD,
# where a panel of the same stage is right, so that lamps no longer fit each other. With the option off bulbs are right.
# Nothing is said.
# Remedy: after import `use_soft_falloff = False` for each lamp of the types POINT and SPOT.
# Versions: bpy 5.3.0 with numpy 2.5.5, usd-core 26.11; bpy 5.0.1 has the same (PyPI). Source: measured here;
# https://docs.blender.org/manual/en/latest/render/lights/light_object.html (Soft Falloff);
# https://openusd.org/release/api/class_usd_lux_light_a_p_i.html (intensity is radiance)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 numpy==2.5.5
python3.13 -m venv usd
usd/bin/pip install --quiet usd-core==26.11
cat >cases.py <<'END'
DISTANCE = 2
# Kind, radius or half of the side, and the light of Blender in parts of the right one.
CASES = [("ball", 0.1, 0.998), ("ball", 0.5, 0.941), ("ball", 1, 0.8), ("ball", 1.5, 0.64), ("spot", 1, 0.8),
         ("panel", 0.5, 1), ("glow", 1, 1)]
END
cat >lamps.py <<'END'
from cases import CASES, DISTANCE
from pxr import Usd, UsdGeom, UsdLux

for number, (kind, size, _) in enumerate(CASES):
    stage = Usd.Stage.CreateNew(f"{number}.usda")
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.SetStageMetersPerUnit(stage, 1)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/World").GetPrim())
    if kind == "panel":
        lamp = UsdLux.RectLight.Define(stage, "/World/lamp")
        lamp.CreateWidthAttr(2 * size)
        lamp.CreateHeightAttr(2 * size)
        lamp.CreateIntensityAttr(1)
    else:
        lamp = UsdLux.SphereLight.Define(stage, "/World/lamp")
        lamp.CreateRadiusAttr(size)
        lamp.CreateIntensityAttr(DISTANCE ** 2 / size ** 2)  # so that a white floor below has a radiance of 1
    if kind == "spot":
        UsdLux.ShapingAPI.Apply(lamp.GetPrim()).CreateShapingConeAngleAttr(80)
    UsdGeom.XformCommonAPI(lamp).SetTranslate((0, 0, DISTANCE))
    stage.Save()
END
cat >look.py <<'END'
import glob
import math
import os
import sys

import bpy
from cases import CASES, DISTANCE

sys.path += glob.glob(sys.prefix + "/lib/python*/site-packages/bpy/*/python/lib/python*/site-packages")
import numpy as np
import OpenImageIO as oiio


def glowing(material, strength):
    nodes = material.node_tree.nodes
    nodes.clear()
    emission = nodes.new("ShaderNodeEmission")
    emission.inputs["Strength"].default_value = strength
    material.node_tree.links.new(emission.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])


def white(material):
    nodes = material.node_tree.nodes
    nodes.clear()
    diffuse = nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (1, 1, 1, 1)
    material.node_tree.links.new(diffuse.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])


def new_material():
    material = bpy.data.materials.new("material")
    material.use_nodes = True
    bpy.context.object.data.materials.append(material)
    return material


def floor(number, kind, size, is_soft):
    """The radiance of a white floor below the lamp."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    if kind == "glow":
        bpy.ops.mesh.primitive_uv_sphere_add(radius=size, segments=128, ring_count=64, location=(0, 0, DISTANCE))
        glowing(new_material(), DISTANCE ** 2 / size ** 2)
    else:
        bpy.ops.wm.usd_import(filepath=os.path.abspath(f"{number}.usda"))
        lamp = next(thing for thing in bpy.data.objects if thing.type == "LIGHT").data
        if not is_soft and lamp.type in ("POINT", "SPOT"):
            lamp.use_soft_falloff = False
    bpy.ops.mesh.primitive_plane_add(size=40)
    white(new_material())
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("black")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0, 0, 0, 1)
    lens = bpy.data.cameras.new("camera")
    lens.type, lens.ortho_scale = "ORTHO", 0.1
    camera = bpy.data.objects.new("camera", lens)
    camera.location = (0, 0, 0.2)
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.engine, scene.cycles.samples, scene.cycles.device = "CYCLES", 4096, "CPU"
    scene.cycles.use_denoising, scene.cycles.use_adaptive_sampling = False, False
    scene.cycles.max_bounces = 0
    scene.render.resolution_x = scene.render.resolution_y = 4
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.render.filepath = os.path.abspath("floor.exr")
    bpy.ops.render.render(write_still=True)
    return float(np.array(oiio.ImageBuf(scene.render.filepath).get_pixels("float"))[:, :, :3].mean())


def right(kind, size):
    """1 by the choice of the intensity; of a panel of radiance 1 the form factor of a square above its middle."""
    if kind != "panel":
        return 1
    across = size / DISTANCE
    root = math.sqrt(1 + across ** 2)
    return 4 / math.pi * across / root * math.atan(across / root)


for number, (kind, size, wanted) in enumerate(CASES):
    soft, hard = [floor(number, kind, size, is_soft) / right(kind, size) for is_soft in (True, False)]
    print("bpy", bpy.app.version_string, f"{kind} of {size} m at {DISTANCE} m: {soft:.3f} of its light,",
          f"{hard:.3f} without Soft Falloff", flush=True)
    if abs(soft - wanted) > 0.01 or abs(hard - 1) > 0.01:
        raise SystemExit("this has changed")
END
usd/bin/python lamps.py
venv/bin/python look.py 2>&1 | grep "^bpy\|changed\|Error"
