#!/usr/bin/env bash
# What is clear in Blender 5.3 is opaque in its USD: a plain *Alpha* is lost.
#
# Expected: `opacity` of a `UsdPreviewSurface` is how much of what is behind is covered. A veil with *Alpha* at 0.25 is
# at 0.25, and one that is not there, with *Alpha* at 0, is at 0. Blender 5.0.1 writes that. What happens: Blender 5.3.0
# writes 1 less the *Transmission*, and nothing else, so that both are 1: a pane that nobody sees is a wall, and so it
# is in Blender's own import. *Alpha* by a picture is still connected; but where a *Math* node makes it half as strong
# the picture alone is left, in 5.0.1 as well. By glTF all are right. Nothing is said.
# Remedy: after export set `inputs:opacity`; or in Blender *Alpha* from a picture of one colour.
# Versions: bpy 5.3.0, usd-core 26.11 (PyPI); bpy 5.0.1 has plain alpha right. Source: measured here;
# https://openusd.org/release/spec_usdpreviewsurface.html (opacity);
# https://projects.blender.org/blender/blender (source/blender/io/usd/intern/usd_writer_material.cc)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0
python3.13 -m venv usd
usd/bin/pip install --quiet usd-core==26.11
cat >veils.py <<'END'
import os

import bpy

bpy.ops.wm.read_factory_settings(use_empty=True)


def veil(name, alpha=1.0, transmission=0.0):
    bpy.ops.mesh.primitive_plane_add()
    bpy.context.object.name = name
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    principled = material.node_tree.nodes["Principled BSDF"]
    principled.inputs["Alpha"].default_value = alpha
    principled.inputs["Transmission Weight"].default_value = transmission
    bpy.context.object.data.materials.append(material)
    return material.node_tree, principled


def picture(tree):
    image = bpy.data.images.new("half", 4, 4, alpha=True)
    image.pixels = [0.5] * 64
    image.filepath_raw, image.file_format = os.path.abspath("half.png"), "PNG"
    image.save()
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    return node.outputs["Alpha"]


veil("opaque")
veil("quarter", alpha=0.25)
veil("nothing", alpha=0.0)
veil("glass", transmission=1.0)
tree, principled = veil("painted")
tree.links.new(picture(tree), principled.inputs["Alpha"])
tree, principled = veil("weakened")
half = tree.nodes.new("ShaderNodeMath")
half.operation = "MULTIPLY"
half.inputs[1].default_value = 0.5
tree.links.new(picture(tree), half.inputs[0])
tree.links.new(half.outputs[0], principled.inputs["Alpha"])
bpy.ops.wm.usd_export(filepath=os.path.abspath("veils.usda"))
bpy.ops.export_scene.gltf(filepath=os.path.abspath("veils.gltf"), export_format="GLTF_SEPARATE")
END
cat >look.py <<'END'
import json

from pxr import Usd, UsdShade

with open("veils.gltf") as file:
    gltf = {material["name"]: material["pbrMetallicRoughness"].get("baseColorFactor", [1, 1, 1, 1])[3]
            for material in json.load(file)["materials"]}
stage = Usd.Stage.Open("veils.usda")
surfaces = {shader.GetPath().GetParentPath().name: shader for shader in map(UsdShade.Shader, stage.Traverse())
            if shader and shader.GetIdAttr().Get() == "UsdPreviewSurface"}
for name, right, wanted in (
    ("opaque", 1, 1), ("quarter", 0.25, 1), ("nothing", 0, 1), ("glass", 1, 0),
    ("painted", 1, "outputs:a of a picture"), ("weakened", 0.5, "outputs:a of a picture"),
):
    opacity = surfaces[name].GetInput("opacity")
    sources = opacity.GetAttr().GetConnections()
    found = opacity.Get()
    if sources:
        texture = UsdShade.Shader(stage.GetPrimAtPath(sources[0].GetPrimPath()))
        if texture.GetInput("scale") or texture.GetInput("bias"):
            raise SystemExit("this has changed")
        found = sources[0].name + " of a picture"
    told = f"{name}: alpha {right}, by glTF {gltf[name]:g}, by USD {found}"
    print("bpy 5.3.0, usd-core 26.11", told, flush=True)
    if found != wanted or abs(gltf[name] - right) > 1e-6:
        raise SystemExit("this has changed")
END
venv/bin/python veils.py >log 2>&1 || { cat log; exit 1; }
usd/bin/python look.py
