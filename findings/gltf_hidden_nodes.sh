#!/usr/bin/env bash
# Optimisers of glTF show nodes that KHR_node_visibility hides.
#
# Expected: a node with `"KHR_node_visibility": {"visible": false}` stays hidden, or the optimiser refuses or
# warns. What happens: gltfpack 1.3 drops the extension, with -kn -ke -km too, and the node is drawn. The
# function `instance` of gltf-transform 4.5.1 puts the hidden node's mesh among the visible instances of one
# EXT_mesh_gpu_instancing. Neither says a word of it. gltf-transform keeps the extension as long as nodes are
# not merged. Its `instance` also leaves the extras of the merged nodes behind.
# Source: https://github.com/KhronosGroup/glTF/tree/main/extensions/2.0/Khronos/KHR_node_visibility
# Needs node, npm and python3. Ends with 1 if any of it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm init -y >/dev/null
npm install --silent gltfpack@1.3.0 @gltf-transform/core@4.5.1 @gltf-transform/extensions@4.5.1 @gltf-transform/functions@4.5.1
cat >make.py <<'END'
import json, struct

points = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
nodes = [{"mesh": 0, "name": f"seen.{i}", "translation": [i, 0, 0], "extras": {"id": i}} for i in range(4)]
nodes.append({"mesh": 0, "name": "hidden", "extensions": {"KHR_node_visibility": {"visible": False}}})
document = {
    "asset": {"version": "2.0"}, "extensionsUsed": ["KHR_node_visibility"],
    "buffers": [{"byteLength": 36}], "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "nodes": nodes, "scenes": [{"nodes": [0, 1, 2, 3, 4]}], "scene": 0,
}
text = json.dumps(document).encode()
text += b" " * (-len(text) % 4)
with open("in.glb", "wb") as file:
    file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + 36))
    file.write(struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", 36, 0x004E4942) + points)
END
python3 make.py
npx gltfpack -kn -ke -km -noq -i in.glb -o packed.glb >/dev/null
cat >run.mjs <<'END'
import { NodeIO } from "@gltf-transform/core";
import { ALL_EXTENSIONS } from "@gltf-transform/extensions";
import { instance } from "@gltf-transform/functions";
const io = new NodeIO().registerExtensions(ALL_EXTENSIONS);
const document = await io.read("in.glb");
await document.transform(instance({ min: 2 }));
await io.write("instanced.glb", document);
END
node run.mjs
cat >look.py <<'END'
import json, struct

def read(name):
    data = open(name, "rb").read()
    return json.loads(data[20 : 20 + struct.unpack("<I", data[12:16])[0]])

def said(document):
    return [node["name"] for node in document["nodes"] if "KHR_node_visibility" in node.get("extensions", {}) and "mesh" in node]

packed, instanced = read("packed.glb"), read("instanced.glb")
batch = next(node for node in instanced["nodes"] if "EXT_mesh_gpu_instancing" in node.get("extensions", {}))
at = batch["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"]
count = instanced["accessors"][at]["count"]
print("gltfpack 1.3.0: hidden meshes:", said(packed), "of", len([n for n in packed["nodes"] if "mesh" in n]))
print("gltf-transform 4.5.1 instance: instances seen:", count, "of 4; extras:", batch.get("extras"))
raise SystemExit(0 if not said(packed) and count == 5 and not batch.get("extras") else 1)
END
python3 look.py
