#!/usr/bin/env bash
# Blender's glTF import drops the tangents of CUBICSPLINE keys: things move otherwise between their keys.
#
# Expected: by glTF 2.0 (appendix C.5) a key of CUBICSPLINE is an in-tangent, a value and an out-tangent, and
# what lies between two keys follows from all of them. What happens: Blender 5.3.0 takes the values alone, and
# gives each key handles of its own (AUTO). With a tangent of 8 m/s at its first key a node is 1.5 m away after half
# a second by the specification, and beyond its last key by then; in Blender it is at 0.5 m. Nothing is said.
# Remedy: write a key of LINEAR for every frame, as Blender's own export does by default.
# Versions: bpy 5.3.0, bpy 5.0.1 has the same (PyPI). Source: https://github.com/KhronosGroup/glTF-Blender-IO (issue
# 419: not handled since 2019); https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0
cat >splines.py <<'END'
import base64
import json
import struct

import bpy

# Two keys, at 0 and 1 s: x of the in-tangent, of the value, and of the out-tangent.
FIRST, LAST = (0.0, 0.0, 8.0), (0.0, 1.0, 0.0)
data = struct.pack("<2f", 0, 1) + b"".join(struct.pack("<3f", x, 0, 0) for x in FIRST + LAST)
uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
document = {
    "asset": {"version": "2.0"}, "buffers": [{"byteLength": len(data), "uri": uri}],
    "bufferViews": [{"buffer": 0, "byteLength": 8}, {"buffer": 0, "byteOffset": 8, "byteLength": 72}],
    "accessors": [
        {"bufferView": 0, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]},
        {"bufferView": 1, "componentType": 5126, "count": 6, "type": "VEC3"},
    ],
    "nodes": [{"name": "leaf"}], "scenes": [{"nodes": [0]}], "scene": 0,
    "animations": [{
        "samplers": [{"input": 0, "output": 1, "interpolation": "CUBICSPLINE"}],
        "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
    }],
}
with open("leaf.gltf", "w") as file:
    json.dump(document, file)
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_scene.gltf(filepath="leaf.gltf")
scene, leaf = bpy.context.scene, bpy.data.objects["leaf"]
for frame, wanted_m in [(0, 0.0), (6, 0.156), (12, 0.5), (18, 0.844), (24, 1.0)]:
    scene.frame_set(frame)
    t = frame / scene.render.fps
    hermite_m = (t**3 - 2 * t**2 + t) * FIRST[2] + (3 * t**2 - 2 * t**3) * LAST[1]
    found_m = leaf.matrix_world.translation.x
    print("bpy", bpy.app.version_string, "after %.2f s: %.3f m, by glTF %.3f m" % (t, found_m, hermite_m))
    if abs(found_m - wanted_m) > 0.001:
        raise SystemExit("this has changed")
END
venv/bin/python splines.py 2>&1 | grep "^bpy\|changed"
