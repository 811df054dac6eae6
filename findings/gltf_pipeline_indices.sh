#!/usr/bin/env bash
# gltf-pipeline lifts leaves by their stalks, scatters them elsewhere, and lights them by another picture.
#
# Expected: gltf-pipeline removes what nothing uses and renumbers the rest; a file that is only read and written looks as
# before. What happens: version 4.3.1 knows some of the places where glTF has indices. It removes the buffer views of
# sparse accessors: a morph target that lifts the tip of a leaf by 1 m lifts its stalk, by numbers of other data. Blender
# writes shape keys as sparse accessors by default. Where an unused mesh precedes them, instances
# (`EXT_mesh_gpu_instancing`) take other accessors: leaves at x = 10, 20 and 30 m stand at 0, 1 and 0 m, the corners of a
# leaf. The picture of the light through leaves (`KHR_materials_diffuse_transmission`) goes, and its index names that of
# their colour. Of two materials the wrong one flickers (`KHR_animation_pointer`). Clearcoat, sheen and volume are not
# among what it knows either. Nothing is said, and the exit code is 0.
# Remedy: `--keepUnusedElements`, which puts all but sparse accessors right; without these in Blender by *Use Sparse
# Accessor if better* off.
# Versions: gltf-pipeline 4.3.1, @gltf-transform/core and extensions 4.5.1 to read (npm). Source: measured here;
# https://github.com/CesiumGS/gltf-pipeline (issue 408, sparse accessors; lib/removeUnusedElements.js);
# https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html (3.6.2.3, Sparse Accessors)
# Needs node, npm, python3.13. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm init -y >/dev/null
npm install --silent --no-fund --no-audit gltf-pipeline@4.3.1 @gltf-transform/core@4.5.1 @gltf-transform/extensions@4.5.1
cat >make.py <<'END'
import base64
import json
import struct
import zlib

data, views, accessors = b"", [], []


def view(part):
    global data
    data += b"\0" * (-len(data) % 4)
    views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(part)})
    data += part
    return len(views) - 1


def accessor(kind, rows, **more):
    """Index of a new accessor of floats."""
    part = b"".join(struct.pack(f"<{len(row)}f", *row) for row in rows)
    accessors.append({"bufferView": view(part), "componentType": 5126, "count": len(rows), "type": kind, **more})
    return len(accessors) - 1


def picture(name):
    """A picture of one grey pixel."""
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    png = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", 1, 1, 8, 2, 0, 0, 0))
    png += chunk(b"IDAT", zlib.compress(b"\0\x80\x80\x80")) + chunk(b"IEND", b"")
    return {"name": name, "uri": "data:image/png;base64," + base64.b64encode(png).decode()}


leaf = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
bounds = {"min": [0, 0, 0], "max": [1, 1, 0]}
old = accessor("VEC3", leaf, **bounds)
position = accessor("VEC3", leaf, **bounds)
accessors.append({  # The third corner goes up by 1 m.
    "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [0, 0, 1],
    "sparse": {"count": 1, "indices": {"bufferView": view(struct.pack("<H", 2)), "componentType": 5123},
               "values": {"bufferView": view(struct.pack("<3f", 0, 0, 1))}}})
curl = len(accessors) - 1
places = accessor("VEC3", [(10, 0, 0), (20, 0, 0), (30, 0, 0)])
normal = accessor("VEC3", [(0, 0, 1)] * 3)
lamp = accessor("VEC3", leaf, **bounds)
uv = accessor("VEC2", [(0, 0), (1, 0), (0, 1)])
times = accessor("SCALAR", [(0,), (1,)], min=[0], max=[1])
flicker = accessor("VEC3", [(0, 0, 0), (1, 1, 1)])
attributes = {"POSITION": position, "NORMAL": normal, "TEXCOORD_0": uv}
json.dump({
    "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1, 2]}],
    "extensionsUsed": ["EXT_mesh_gpu_instancing", "KHR_materials_diffuse_transmission", "KHR_animation_pointer"],
    "nodes": [
        {"name": "leaves", "mesh": 1, "extensions": {
            "EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places}}}},
        {"name": "curled", "mesh": 2, "weights": [1]}, {"name": "lamp", "mesh": 3}],
    "meshes": [
        {"name": "old", "primitives": [{"attributes": {"POSITION": old}, "material": 0}]},
        {"name": "leaf", "primitives": [{"attributes": attributes, "material": 3}]},
        {"name": "curled", "primitives": [{"attributes": attributes, "targets": [{"POSITION": curl}], "material": 2}]},
        {"name": "lamp", "primitives": [{"attributes": {"POSITION": lamp}, "material": 1}]}],
    "materials": [
        {"name": "old"}, {"name": "lamp"}, {"name": "curled"},
        {"name": "leaf", "pbrMetallicRoughness": {"baseColorTexture": {"index": 1}}, "extensions": {
            "KHR_materials_diffuse_transmission": {
                "diffuseTransmissionFactor": 0.5, "diffuseTransmissionColorTexture": {"index": 0}}}}],
    "textures": [{"source": 0}, {"source": 1}], "images": [picture("light"), picture("colour")],
    "animations": [{
        "samplers": [{"input": times, "output": flicker}],
        "channels": [{"sampler": 0, "target": {"path": "pointer", "extensions": {
            "KHR_animation_pointer": {"pointer": "/materials/1/emissiveFactor"}}}}]}],
    "accessors": accessors, "bufferViews": views,
    "buffers": [{"byteLength": len(data), "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}],
}, open("before.gltf", "w"))
END
python3.13 make.py
npx gltf-pipeline -i before.gltf -o after.gltf
npx gltf-pipeline --keepUnusedElements -i before.gltf -o kept.gltf
cat >read.mjs <<'END'
import { readFileSync } from "node:fs";
import { Logger, NodeIO } from "@gltf-transform/core";
import { ALL_EXTENSIONS } from "@gltf-transform/extensions";

const WANTED = {
  before: "lifts 0 0 1, places 10 20 30, light by light, flickers lamp",
  after: "lifts 1 0 0, places 0 1 0, light by colour, flickers curled",
  kept: "lifts 1 0 0, places 10 20 30, light by light, flickers lamp",
};
const io = new NodeIO().setLogger(new Logger(Logger.Verbosity.SILENT)).registerExtensions(ALL_EXTENSIONS);
let isSame = true;
for (const [name, wanted] of Object.entries(WANTED)) {
  const json = JSON.parse(readFileSync(`${name}.gltf`));
  const pointer = json.animations[0].channels[0].target.extensions.KHR_animation_pointer.pointer;
  const root = (await io.read(`${name}.gltf`)).getRoot();
  const named = (list, text) => list.find((thing) => thing.getName() === text);
  const target = named(root.listMeshes(), "curled").listPrimitives()[0].listTargets()[0].getAttribute("POSITION");
  const leaves = named(root.listNodes(), "leaves").getExtension("EXT_mesh_gpu_instancing");
  const places = leaves.getAttribute("TRANSLATION");
  const light = named(root.listMaterials(), "leaf").getExtension("KHR_materials_diffuse_transmission");
  const found = [
    `lifts ${[0, 1, 2].map((index) => target.getElement(index, [])[2]).join(" ")}`,
    `places ${[0, 1, 2].map((index) => places.getElement(index, [])[0]).join(" ")}`,
    `light by ${light.getDiffuseTransmissionColorTexture().getName()}`,
    `flickers ${json.materials[Number(pointer.split("/")[2])].name}`,
  ].join(", ");
  console.log(`gltf-pipeline 4.3.1, ${name}: ${found}`);
  isSame &&= found === wanted;
}
if (!isSame) {
  console.log("this has changed");
  process.exit(1);
}
END
node read.mjs
