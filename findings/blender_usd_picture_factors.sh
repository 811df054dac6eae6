#!/usr/bin/env bash
# Pictures lose what they are multiplied by in Blender's USD: neon signs are dim, and tints of leaves are gone.
#
# Expected: `scale` of a `UsdUVTexture` multiplies its picture, and Blender's import makes a node of it. So a picture in
# *Emission Color* is there times *Emission Strength*, five times as bright at 5, and a *Mix* node that multiplies a
# picture by a tint, 0.2 0.3 0.4, is that `scale`. What happens: Blender 5.3.0 connects the picture as it is. It glows
# with 1 at a strength of 0.1, of 5 and of 100, and under a tint it has all of its light, up to 5 times too bright here.
# A strength of 0 is right, and so is an emission of one colour with any strength, so that signs with pictures and
# without no longer fit. By glTF all are right. Nothing is said.
# Remedy: after export `scale` of the texture, for emission (strength, strength, strength, 1).
# Versions: bpy 5.3.0, usd-core 26.11 (PyPI); bpy 5.0.1 has the same. Source: measured here;
# https://openusd.org/release/spec_usdpreviewsurface.html (UsdUVTexture, scale);
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
cat >signs.py <<'END'
import os

import bpy

bpy.ops.wm.read_factory_settings(use_empty=True)
image = bpy.data.images.new("sign", 4, 4)
image.pixels = [1.0] * 64
image.filepath_raw, image.file_format = os.path.abspath("sign.png"), "PNG"
image.save()


def sign(name):
    bpy.ops.mesh.primitive_plane_add()
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    bpy.context.object.data.materials.append(material)
    tree = material.node_tree
    picture = tree.nodes.new("ShaderNodeTexImage")
    picture.image = image
    return tree, picture.outputs["Color"], tree.nodes["Principled BSDF"].inputs


for strength in 0, 0.1, 5, 100:
    tree, color, inputs = sign(f"glow_{strength}".replace(".", "_"))
    tree.links.new(color, inputs["Emission Color"])
    inputs["Emission Strength"].default_value = strength
tree, color, inputs = sign("plain_5")
inputs["Emission Color"].default_value = (1, 1, 1, 1)
inputs["Emission Strength"].default_value = 5
tree, color, inputs = sign("tint")
mix = tree.nodes.new("ShaderNodeMix")
mix.data_type, mix.blend_type = "RGBA", "MULTIPLY"
mix.inputs["Factor"].default_value = 1
colors = [socket for socket in mix.inputs if socket.type == "RGBA"]
colors[1].default_value = (0.2, 0.3, 0.4, 1)
tree.links.new(color, colors[0])
tree.links.new(next(socket for socket in mix.outputs if socket.type == "RGBA"), inputs["Base Color"])
bpy.ops.wm.usd_export(filepath=os.path.abspath("signs.usda"))
bpy.ops.export_scene.gltf(filepath=os.path.abspath("signs.gltf"), export_format="GLTF_SEPARATE")
END
cat >look.py <<'END'
import json

from pxr import Usd, UsdShade

with open("signs.gltf") as file:
    materials = {material["name"]: material for material in json.load(file)["materials"]}
stage = Usd.Stage.Open("signs.usda")
surfaces = {shader.GetPath().GetParentPath().name: shader for shader in map(UsdShade.Shader, stage.Traverse())
            if shader and shader.GetIdAttr().Get() == "UsdPreviewSurface"}


def by_gltf(name, is_glow):
    material = materials[name]
    if not is_glow:
        return material["pbrMetallicRoughness"]["baseColorFactor"][:3]
    strength = material.get("extensions", {}).get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1)
    return [strength * part for part in material.get("emissiveFactor", [0, 0, 0])]


def by_usd(name, is_glow):
    """What a white picture, or none, comes to."""
    entry = surfaces[name].GetInput("emissiveColor" if is_glow else "diffuseColor")
    if not entry:
        return [0, 0, 0]  # the default of `emissiveColor`
    if not entry.HasConnectedSource():
        return list(entry.Get())
    texture = UsdShade.Shader(entry.GetConnectedSources()[0][0].source)
    scale, bias = texture.GetInput("scale"), texture.GetInput("bias")
    if bias:
        raise SystemExit("this has changed")
    return list(scale.Get())[:3] if scale else [1, 1, 1]


for name, right, wanted in (
    ("glow_0", [0, 0, 0], [0, 0, 0]), ("glow_0_1", [0.1, 0.1, 0.1], [1, 1, 1]), ("glow_5", [5, 5, 5], [1, 1, 1]),
    ("glow_100", [100, 100, 100], [1, 1, 1]), ("plain_5", [5, 5, 5], [5, 5, 5]), ("tint", [0.2, 0.3, 0.4], [1, 1, 1]),
):
    gltf, usd = by_gltf(name, name != "tint"), by_usd(name, name != "tint")
    words = [" ".join(f"{number:g}" for number in (round(part, 3) for part in color)) for color in (right, gltf, usd)]
    print("bpy 5.3.0, usd-core 26.11 {}: {} is right, glTF has {}, USD {}".format(name, *words), flush=True)
    if any(abs(one - other) > 1e-3 for one, other in zip(gltf + usd, right + wanted)):
        raise SystemExit("this has changed")
END
venv/bin/python signs.py >log 2>&1 || { cat log; exit 1; }
usd/bin/python look.py
