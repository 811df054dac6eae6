#!/usr/bin/env bash
# trimesh keeps the colours of glTF materials as bytes of linear light: dark soil turns black.
#
# Expected: `baseColorFactor` is linear numbers; loaded and exported again they are the same, or nearly. What happens:
# trimesh 5.2.0 rounds them to 1 / 255. Steps that are fine in sRGB are coarse in linear light: 0.0015 comes back as 0,
# and 0.01 as 0.0118, 18 % brighter. 0.25 is right to half a per cent, so that bright colours show nothing. What glows
# loses its KHR_materials_emissive_strength as well: 7 turns to 1. Nothing is said.
# Remedy: write the factors and the strength of the first file into the second.
# Versions: trimesh 5.2.0, numpy 2.5.5, Pillow 12.3.0 (PyPI). Source: measured here; https://github.com/mikedh/trimesh
# (trimesh/visual/material.py); https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html (3.9.2)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet trimesh==5.2.0 numpy==2.5.5 pillow==12.3.0
cat >bytes.py <<'END'
import base64
import json
import struct

import trimesh

COLOR = [0.0015, 0.01, 0.25, 1]
points = base64.b64encode(struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)).decode()
document = {
    "asset": {"version": "2.0"}, "extensionsUsed": ["KHR_materials_emissive_strength"],
    "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64," + points}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
    "materials": [{
        "pbrMetallicRoughness": {"baseColorFactor": COLOR}, "emissiveFactor": [1, 1, 1],
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 7}},
    }],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
    "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}], "scene": 0,
}
with open("soil.gltf", "w") as file:
    json.dump(document, file)
trimesh.load("soil.gltf").export("again.glb")
with open("again.glb", "rb") as file:
    binary = file.read()
written = json.loads(binary[20:20 + struct.unpack("<I", binary[12:16])[0]])["materials"][0]
found = [round(number, 4) for number in written["pbrMetallicRoughness"]["baseColorFactor"]]
print("trimesh", trimesh.__version__, "wrote", COLOR, "as", found, "and", written.get("extensions"), "for a strength of 7")
raise SystemExit(0 if found == [0, 0.0118, 0.251, 1] and "extensions" not in written else "this has changed")
END
venv/bin/python bytes.py
