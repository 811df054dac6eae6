#!/usr/bin/env bash
# Cycles' hair as rounded ribbons, its default, gets 1.3 times the light of the same hair as 3D curves where the sun is
# 20 degrees above a row of it, and none where it is 10 degrees above.
#
# Expected: rounded ribbons are a cheaper picture of the same round hairs. Seen from in front they have the same outline
# and the same shading normals, so a row of hairs has about the same light by either, wherever the sun is.
# What happens: a matte row that is seen from in front has the same mean by both under a sun behind the camera. At 20
# degrees ribbons have 1.31 times the light. At 10 degrees they are black, where 3D curves have a fifth of what they
# have under the first sun. A fringe or a lawn in evening light turns dark all at once as the sun sets.
# Remedy: Render properties > Curves > Shape > 3D Curves where light grazes hair.
# Versions: bpy 5.3.0 with numpy 2.5.5; bpy 5.0.1 with numpy 1.26.4 has the same (PyPI). Source: measured here.
# Needs python3.13 and python3.11 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
cat >hair.py <<'END'
import math
import sys

import bpy
import mathutils
import numpy as np

RADIUS_M, HAIRS = 0.03, 41


def light(shape, elevation_deg):
    """Mean radiance of a row of parallel hairs that touch, seen from straight in front of the row."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    curves = bpy.data.hair_curves.new("row")
    curves.add_curves([9] * HAIRS)
    across = [(number - HAIRS // 2) * 2 * RADIUS_M for number in range(HAIRS)]
    places = [(x, 0.0, 0.25 * step - 1.0) for x in across for step in range(9)]
    curves.position_data.foreach_set("vector", np.ravel(places).astype(np.float32))
    radii = curves.attributes.new("radius", "FLOAT", "POINT").data
    radii.foreach_set("value", np.full(9 * HAIRS, RADIUS_M, np.float32))
    material = bpy.data.materials.new("matte")
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    shader, output = nodes.new("ShaderNodeBsdfDiffuse"), nodes.new("ShaderNodeOutputMaterial")
    material.node_tree.links.new(shader.outputs[0], output.inputs["Surface"])
    curves.materials.append(material)
    scene.collection.objects.link(bpy.data.objects.new("row", curves))
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy, sun.data.angle = 3.0, 0.0
    towards = mathutils.Vector((math.cos(math.radians(elevation_deg)), -math.sin(math.radians(elevation_deg)), 0.0))
    sun.rotation_euler = towards.to_track_quat("Z", "Y").to_euler()
    scene.collection.objects.link(sun)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", 1.0
    camera.location, camera.rotation_euler = (0.0, -5.0, 0.0), (math.pi / 2, 0.0, 0.0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.engine, scene.cycles.samples, scene.cycles.device = "CYCLES", 64, "CPU"
    scene.cycles.max_bounces, scene.cycles.use_denoising = 0, False
    scene.cycles_curves.shape = shape
    scene.render.resolution_x = scene.render.resolution_y = 64
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = f"{sys.argv[1]}/{shape}{elevation_deg}.exr"
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    pixels = np.empty(64 * 64 * 4, np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(-1, 4)[:, :3].mean()


for elevation_deg, expected in ((90, 1.0), (20, 1.306), (10, 0.0)):
    ribbons, tubes = light("RIBBONS", elevation_deg), light("THICK", elevation_deg)
    ratio = ribbons / tubes
    print(f"sun {elevation_deg} degrees above the row: ribbons {ribbons:.4f}, 3D curves {tubes:.4f}, ratio {ratio:.3f}")
    if abs(ratio - expected) > 0.02:
        print(f"changed: the ratio was {expected}")
END
for of in "python3.13 bpy==5.3.0 numpy==2.5.5" "python3.11 bpy==5.0.1 numpy==1.26.4"; do
    read -r python blender numbers <<<"$of"
    "$python" -m venv "$blender"
    "$blender/bin/python" -m pip install --quiet "$blender" "$numbers"
    echo "$blender"
    "$blender/bin/python" hair.py "$folder" | grep -E "^sun |^changed" | tee said
    ! grep -q "^changed" said && [ "$(wc -l <said)" = 3 ]
done
