#!/usr/bin/env bash
# trimesh takes a leaf of 2 m that gltfpack has packed for one of 131 km: what is normalized or sparse is read as raw.
#
# Expected: integers of an accessor with `normalized` are fractions, 65535 is 1; an accessor with `sparse` is its buffer
# view with some elements replaced; a reader that lacks a required extension refuses. What happens: trimesh 5.2.0 takes
# the integers as they are, though the file requires KHR_mesh_quantization. Packed by gltfpack 1.3 as it packs by default
# a leaf has texture coordinates up to 61442 for 1, and with `-vpn` it is 131070 m wide. Of sparse accessors trimesh
# takes what was to be replaced: a corner that belongs at 3 3 0 stays at 2 2 0. Nothing is said.
# Remedy: `gltfpack -noq`; write sparse accessors out before.
# Versions: trimesh 5.2.0, numpy 2.5.5, Pillow 12.3.0 (PyPI), gltfpack 1.3.0 (npm). Source: measured here;
# https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html (3.6.2.3, 3.11);
# https://github.com/KhronosGroup/glTF/tree/main/extensions/2.0/Khronos/KHR_mesh_quantization
# Needs python3.13 with venv, node, npm. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet trimesh==5.2.0 numpy==2.5.5 Pillow==12.3.0
npm install --silent --no-fund --no-audit gltfpack@1.3.0 >npm.log 2>&1
cat >write.py <<'END'
import base64
import io
import json

import numpy as np
from PIL import Image

ARRAYS = [
    np.array([(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0)], np.float32),
    np.array([(0, 0), (1, 0), (1, 1), (0, 1)], np.float32),
    np.array([0, 1, 2, 0, 2, 3], np.uint16),
    np.array([2, 0], np.uint16),  # which corner the sparse accessor replaces
    np.array([(3, 3, 0)], np.float32),
]
offsets = np.cumsum([0] + [array.nbytes for array in ARRAYS])
data = b"".join(array.tobytes() for array in ARRAYS)
png = io.BytesIO()
Image.new("RGB", (1, 1)).save(png, "PNG")


def write(name, sparse):
    position = {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [2, 2, 0]}
    if sparse:
        position |= {"max": [3, 3, 0], "sparse": {
            "count": 1, "indices": {"bufferView": 3, "componentType": 5123}, "values": {"bufferView": 4}}}
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    json.dump({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}], "textures": [{"source": 0}],
        "images": [{"uri": "data:image/png;base64," + base64.b64encode(png.getvalue()).decode()}],
        "accessors": [position, {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
                      {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"}],
        "buffers": [{"byteLength": len(data), "uri": uri}],
        "bufferViews": [{"buffer": 0, "byteOffset": int(at), "byteLength": array.nbytes}
                        for at, array in zip(offsets, ARRAYS)],
    }, open(name, "w"))


write("leaf.gltf", False)
write("sparse.gltf", True)
END
cat >look.py <<'END'
import trimesh

for name, corner, uv in [
    ("leaf", 2, 1), ("noq", 2, 1), ("packed", 2, 61442), ("normalized", 131070, 61442), ("sparse", 2, 1),
]:
    mesh, = trimesh.load_scene(name + ".gltf").dump()
    print("trimesh", trimesh.__version__, name, mesh.bounds[1].round(3), "uv to", mesh.visual.uv.max(), flush=True)
    if abs(mesh.bounds[1][0] / corner - 1) > 0.001 or mesh.visual.uv.max() != uv:
        raise SystemExit("this has changed")
END
venv/bin/python write.py
node_modules/.bin/gltfpack -noq -i leaf.gltf -o noq.gltf >pack.log
node_modules/.bin/gltfpack -i leaf.gltf -o packed.gltf >pack.log
node_modules/.bin/gltfpack -vpn -i leaf.gltf -o normalized.gltf >pack.log
venv/bin/python look.py 2>&1 | grep "^trimesh\|changed"
