#!/usr/bin/env bash
# Blender's USD import makes leaves as clear as their colour is dark once their texture has a factor.
#
# Expected: `outputs:a` of a `UsdUVTexture` is alpha, whatever `scale` and `bias` make of the colour. A card whose texture
# is clear on its left half and opaque on its right covers 0 and 1. `scale` tints textures; three.js writes it for every
# textured material that is not white. What happens: Blender 5.3.0 puts a *Multiply Add* behind the colour, and connects
# that to *Alpha* as well. A green leaf with `scale` (0.9, 0.9, 0.9, 1) covers 0.30, the mean of its red, green and blue;
# a black one is not there, a brown one hardly is, and shadows are as thin. `opacityThreshold` is lost with it. Without
# `scale` all is right. Nothing is said.
# Remedy: after import connect the *Alpha* of the image to that of *Principled BSDF*; or put the factor into the picture.
# Versions: bpy 5.3.0 with numpy 2.5.5, bpy 5.0.1 has the same (PyPI). Source: measured here;
# https://openusd.org/release/spec_usdpreviewsurface.html (Texture Reader: outputs, scale);
# https://github.com/mrdoob/three.js (examples/jsm/exporters/USDZExporter.js)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 numpy==2.5.5
cat >leaf.py <<'END'
import os

import bpy
import numpy as np

STAGE = """#usda 1.0
(
    metersPerUnit = 1
    upAxis = "Z"
)
def Mesh "card" (
    prepend apiSchemas = ["MaterialBindingAPI"]
)
{
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
    texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] (
        interpolation = "vertex"
    )
    rel material:binding = </leaf>
}
def Material "leaf"
{
    token outputs:surface.connect = </leaf/surface.outputs:surface>
    def Shader "surface"
    {
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor.connect = </leaf/texture.outputs:rgb>
        float inputs:opacity.connect = </leaf/texture.outputs:a>
        %s
        token outputs:surface
    }
    def Shader "texture"
    {
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @./leaf.png@
        float2 inputs:st.connect = </leaf/st.outputs:result>
        %s
        float3 outputs:rgb
        float outputs:a
    }
    def Shader "st"
    {
        uniform token info:id = "UsdPrimvarReader_float2"
        string inputs:varname = "st"
        float2 outputs:result
    }
}
"""
PIXELS = 16
bpy.ops.wm.read_factory_settings(use_empty=True)
picture = bpy.data.images.new("leaf", 64, 64, alpha=True)
texels = np.zeros((64, 64, 4), np.float32)
texels[..., 1], texels[:, 32:, 3] = 1.0, 1.0
picture.pixels = texels.ravel()
picture.filepath_raw, picture.file_format = os.path.abspath("leaf.png"), "PNG"
picture.save()


def coverage(surface, texture):
    """Alpha of the left and the right half of the card, as Cycles draws it."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    with open("leaf.usda", "w") as file:
        file.write(STAGE % (surface, texture))
    bpy.ops.wm.usd_import(filepath=os.path.abspath("leaf.usda"))
    scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.camera.data.type, scene.camera.data.ortho_scale, scene.camera.location = "ORTHO", 2, (0, 0, 1)
    scene.collection.objects.link(scene.camera)
    scene.render.engine, scene.cycles.samples, scene.cycles.device = "CYCLES", 1024, "CPU"
    scene.cycles.use_denoising, scene.render.film_transparent = False, True
    scene.render.resolution_x = scene.render.resolution_y = PIXELS
    scene.render.image_settings.file_format, scene.render.image_settings.color_mode = "OPEN_EXR", "RGBA"
    scene.render.filepath = os.path.abspath("card.exr")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath, check_existing=False)
    alpha = np.array(image.pixels[:]).reshape(PIXELS, PIXELS, 4)[..., 3]
    return alpha[:, 1:7].mean(), alpha[:, 9:15].mean()


TINT, CUT = "float4 inputs:scale = (0.9, 0.9, 0.9, 1)", "float inputs:opacityThreshold = 0.5"
for name, (surface, texture), wanted in [
    ("as it is", ("", ""), (0, 1)), ("with a threshold", (CUT, ""), (0, 1)),
    ("tinted", ("", TINT), (0, 0.3)), ("tinted, with a threshold", (CUT, TINT), (0, 0.3)),
]:
    found = coverage(surface, texture)
    print("bpy", bpy.app.version_string, "card whose leaf is on the right,", name + ":",
          "alpha %.2f left, %.2f right" % found, flush=True)
    if max(abs(a - b) for a, b in zip(found, wanted)) > 0.02:
        raise SystemExit("this has changed")
END
venv/bin/python leaf.py 2>&1 | grep "^bpy\|changed"
