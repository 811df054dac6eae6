#!/usr/bin/env bash
# gltfpack stops instances that move: their animation goes to an empty node.
#
# Expected: a node with EXT_mesh_gpu_instancing is a node; what turns it, or a node above it, turns all its instances. So
# a swirl of thousands of leaves is one animated node. What happens: gltfpack 1.3 takes instances out of the tree into
# nodes of their own at the root, at the transform of rest, and leaves the animation at the old node, which is empty now.
# All leaves stand still, with `-kn` too. The same mesh without the extension turns as it should. The file is valid, the
# animation is still in it, and nothing is said.
# Remedy: pack with gltf-transform (`quantize`, `meshopt`), which leaves instances where they are; or `uninstance` before.
# Versions: gltfpack 1.3.0 (npm). Source: measured here; https://github.com/zeux/meshoptimizer (pull request 696, which
# reads the extension since 2024, knows of it)
# Needs node, npm. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm init -y >/dev/null
npm install --silent gltfpack@1.3.0
cat >swirl.mjs <<'END'
import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";

/** A node turns about y in two seconds; below it two leaves, by the extension or as a mesh of one. */
function write(name, extension) {
  const numbers = [], accessors = [], bufferViews = [];
  const add = (type, values, width) => {
    const columns = [...Array(width).keys()].map((at) => values.filter((_, i) => i % width === at));
    bufferViews.push({ buffer: 0, byteOffset: 4 * numbers.length, byteLength: 4 * values.length });
    accessors.push({ bufferView: bufferViews.length - 1, componentType: 5126, type, count: values.length / width,
      min: columns.map((column) => Math.min(...column)), max: columns.map((column) => Math.max(...column)) });
    numbers.push(...values);
    return accessors.length - 1;
  };
  const POSITION = add("VEC3", [0, 0, 0, 1, 0, 0, 0, 1, 0], 3);
  const TRANSLATION = add("VEC3", [10, 0, 0, 20, 0, 0], 3);
  const input = add("SCALAR", [0, 1, 2], 1);
  const output = add("VEC4", [0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 0, -1], 4);
  const leaves = { name: "Leaves", mesh: 0 };
  if (extension) leaves.extensions = { EXT_mesh_gpu_instancing: { attributes: { TRANSLATION } } };
  writeFileSync(name, JSON.stringify({
    asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ name: "Swirl", children: [1] }, leaves],
    meshes: [{ primitives: [{ attributes: { POSITION } }] }], accessors, bufferViews,
    extensionsUsed: extension ? ["EXT_mesh_gpu_instancing"] : undefined,
    animations: [{ samplers: [{ input, output }], channels: [{ sampler: 0, target: { node: 0, path: "rotation" } }] }],
    buffers: [{ byteLength: 4 * numbers.length,
      uri: "data:application/octet-stream;base64," + Buffer.from(new Float32Array(numbers).buffer).toString("base64") }],
  }));
}

/** Whether the mesh is at an animated node, or below one. */
function moves(name) {
  const { nodes, animations } = JSON.parse(readFileSync(name));
  const below = (node) => [node, ...(nodes[node].children ?? []).flatMap(below)];
  const moved = animations[0].channels.flatMap((channel) => below(channel.target.node));
  return moved.some((node) => nodes[node].mesh !== undefined);
}

for (const [extension, options, wanted] of [[false, [], true], [true, [], false], [true, ["-kn"], false]]) {
  write("swirl.gltf", extension);
  if (!moves("swirl.gltf")) throw new Error("the input is at fault");
  const said = execFileSync("node_modules/.bin/gltfpack", ["-v", "-i", "swirl.gltf", "-o", "packed.gltf", ...options]);
  const warned = /warn|animat.*(lost|drop)/i.test(said);
  console.log("gltfpack 1.3.0", ...options, extension ? "instances" : "a mesh", moves("packed.gltf") ? "turn" : "stand still");
  if (moves("packed.gltf") !== wanted || warned) { console.log("this has changed"); process.exit(1); }
}
END
node swirl.mjs 2>&1
