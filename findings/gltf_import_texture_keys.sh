#!/usr/bin/env bash
# Blender's glTF import does not turn textures that turn, and lets those that grow drift away.
#
# Expected: KHR_animation_pointer may point at `offset`, `rotation` and `scale` of KHR_texture_transform, the way to play
# sheets of sprites and to let patterns of light wander. A corner at (0, 0) stays at `offset` while a texture turns or
# grows. What happens: Blender 5.3.0 imports keys of `offset` rightly. Those of `rotation` are dropped: the texture stands
# still. Those of `scale` reach *Scale* alone. As v runs the other way in Blender, *Location* would have to follow: the
# corner is where it belongs at the scale of the material only, and goes through about a whole picture for each step of 1
# in scale. Nothing is said.
# Remedy: key `Location` of the *Mapping* node as well, with s, r the scale and rotation of a frame and (x, y) the offset:
# x + s.y sin r, 1 - y - s.y cos r, and `Rotation` by r.
# Versions: bpy 5.3.0, numpy 2.5.5; bpy 5.0.1 has the same (PyPI). Source: measured here;
# https://github.com/KhronosGroup/glTF (extensions/2.0/Khronos/KHR_animation_pointer, KHR_texture_transform)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 numpy==2.5.5
cat >keys.py <<'END'
import base64
import json
import math
import os

import bpy
import numpy as np

CORNERS = np.array([[0, 0], [1, 0], [0, 1]], np.float32)
OFFSET, ROTATION, SCALE = (0.1, 0.2), 0.3, (2.0, 3.0)


def write(path, name, values):
    """A triangle with a texture whose transform has keys of one of its three numbers at 0 and 1 s."""
    arrays = [np.pad(CORNERS, ((0, 0), (0, 1))), CORNERS, np.array([0, 1], np.float32), np.array(values, np.float32)]
    kinds = {1: "SCALAR", 2: "VEC2", 3: "VEC3"}
    data, views, accessors = b"", [], []
    for array in arrays:
        columns = array.shape[1] if array.ndim == 2 else 1
        accessors.append({"bufferView": len(views), "componentType": 5126, "count": len(array), "type": kinds[columns],
                          "min": np.atleast_1d(array.min(0)).tolist(), "max": np.atleast_1d(array.max(0)).tolist()})
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": array.nbytes})
        data += array.tobytes()
    pointer = "/materials/0/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/" + name
    with open(path, "w") as file:
        json.dump({
            "asset": {"version": "2.0"}, "extensionsUsed": ["KHR_animation_pointer", "KHR_texture_transform"],
            "buffers": [{"byteLength": len(data), "uri": "data:application/octet-stream;base64,"
                         + base64.b64encode(data).decode()}],
            "bufferViews": views, "accessors": accessors, "images": [{"uri": "texel.png"}], "textures": [{"source": 0}],
            "materials": [{"name": "pattern", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "extensions": {
                "KHR_texture_transform": {"offset": OFFSET, "rotation": ROTATION, "scale": SCALE}}}}}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0}]}],
            "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}], "scene": 0,
            "animations": [{"samplers": [{"input": 2, "output": 3}], "channels": [{"sampler": 0, "target": {
                "path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": pointer}}}}]}],
        }, file)


def by_blender(uv):
    """Where in the picture the Mapping node looks for a texture coordinate of glTF, at the frame at hand."""
    mapping = next(node for node in bpy.data.materials["pattern"].node_tree.nodes if node.type == "MAPPING")
    place, turn, size = (mapping.inputs[name].default_value for name in ("Location", "Rotation", "Scale"))
    x, y = uv[0] * size[0], (1 - uv[1]) * size[1]
    return (math.cos(turn[2]) * x - math.sin(turn[2]) * y + place[0],
            1 - (math.sin(turn[2]) * x + math.cos(turn[2]) * y + place[1]))


def by_gltf(uv, offset, rotation, scale):
    x, y = uv[0] * scale[0], uv[1] * scale[1]
    return (math.cos(rotation) * x + math.sin(rotation) * y + offset[0],
            -math.sin(rotation) * x + math.cos(rotation) * y + offset[1])


def apart(a, b):
    """How far two places of a picture that repeats are from one another."""
    return math.hypot(*((p - q + 0.5) % 1 - 0.5 for p, q in zip(a, b)))


texel = bpy.data.images.new("texel", 4, 4)
texel.filepath_raw, texel.file_format = os.path.abspath("texel.png"), "PNG"
texel.save()
for name, (first, last), wanted in [
    ("offset", ((0, 0), (0.5, 0.25)), (0, 0, 0)), ("rotation", (0.3, 1.3), (0, 0.51, 0.5)),
    ("scale", ((2, 3), (3, 4)), (0, 0.5, 0.3)),
]:
    write("keys.gltf", name, (first, last))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=os.path.abspath("keys.gltf"))
    scene, found = bpy.context.scene, []
    for frame in (0, 12, 24):
        scene.frame_set(frame)
        now = {"offset": OFFSET, "rotation": ROTATION, "scale": SCALE}
        between = np.array(first) + (np.array(last) - np.array(first)) * frame / scene.render.fps
        now[name] = between.tolist()
        found.append(max(apart(by_blender(uv), by_gltf(uv, **now)) for uv in CORNERS))
    print("bpy", bpy.app.version_string, "keys of", name + ": corners are off by",
          "%.2f, %.2f, %.2f of the picture at 0, 0.5 and 1 s" % tuple(found), flush=True)
    if max(abs(a - b) for a, b in zip(found, wanted)) > 0.01:
        raise SystemExit("this has changed")
END
venv/bin/python keys.py 2>&1 | grep "^bpy\|changed"
