#!/usr/bin/env bash
# gltf-transform's optimize stretches leaves along the wrong axis where a tree was stretched: shear is lost.
#
# Expected: a node that is turned below a node that is stretched is sheared in the world, and glTF has that: each node
# is a place, a turn and a scale, and what they make together need not be one. An optimiser that takes a node out of its
# parent keeps what is seen, or leaves it where it is. A leaf of 2 m, turned by 45 degrees below a tree that is
# stretched to twice its height, has its corners at 1.41 2.83 and -1.41 2.83. What happens: `flatten` of gltf-transform
# 4.5.1, a part of its `optimize`, makes one turn and one scale of the product. The corners are at 2.31 2.12 and -2.12
# 2.31, 1.14 m and 0.88 m off: the leaf is wide instead of high. With a tree of 1.2 times its height they are 0.21 m
# off. The turn of the new node is not even a unit quaternion, 0.985 long, as glTF asks for. Uniform scales and mirrors
# are right. It says nothing.
# Remedy: `optimize --flatten false --join false`.
# Versions: @gltf-transform/cli, core 4.5.1 (npm). Source: measured here;
# https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html (3.5.3, Transformations: a rotation is a unit quaternion);
# https://gltf-transform.dev/modules/functions/functions/flatten
# Needs node, npm. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm init -y >/dev/null
npm install --silent @gltf-transform/cli@4.5.1 @gltf-transform/core@4.5.1
cat >leaf.mjs <<'END'
import { Document, NodeIO } from "@gltf-transform/core";
import { execFileSync } from "node:child_process";

const io = new NodeIO();

/** A file of one leaf, turned by 45 degrees about z, below a tree of a scale. */
async function write(scale) {
  const document = new Document();
  const points = document.createAccessor().setType("VEC3").setBuffer(document.createBuffer())
    .setArray(new Float32Array([0, 0, 0, 2, 0, 0, 0, 2, 0]));
  const mesh = document.createMesh().addPrimitive(document.createPrimitive().setAttribute("POSITION", points));
  const leaf = document.createNode("leaf").setMesh(mesh)
    .setRotation([0, 0, Math.sin(Math.PI / 8), Math.cos(Math.PI / 8)]);
  document.createScene().addChild(document.createNode("tree").setScale(scale).addChild(leaf));
  await io.write("in.gltf", document);
}

/** The two outer corners in the world, and the length of the leaf's quaternion. */
async function read(path) {
  const node = (await io.read(path)).getRoot().listNodes().find((node) => node.getMesh());
  const world = node.getWorldMatrix();
  const points = node.getMesh().listPrimitives()[0].getAttribute("POSITION");
  const corners = [1, 2].map((corner) => {
    const [x, y, z] = points.getElement(corner, []);
    return [0, 1].map((axis) => world[axis] * x + world[4 + axis] * y + world[8 + axis] * z + world[12 + axis]);
  });
  return [...corners.flat(), Math.hypot(...node.getRotation())];
}

const RIGHT = [1.414, 2.828, -1.414, 2.828, 1];
const SHEARED = [2.311, 2.121, -2.121, 2.311, 0.985];
for (const [name, scale, command, wanted] of [
  ["as it was written", [1, 2, 1], [], RIGHT],
  ["copy", [1, 2, 1], ["copy"], RIGHT],
  ["flatten", [1, 2, 1], ["flatten"], SHEARED],
  ["optimize", [1, 2, 1], ["optimize", "--compress", "false"], SHEARED],
  ["optimize without flatten", [1, 2, 1],
    ["optimize", "--compress", "false", "--flatten", "false", "--join", "false"], RIGHT],
  ["flatten, 1.2 times as high", [1, 1.2, 1], ["flatten"], [1.566, 1.556, -1.556, 1.566, 0.999]],
  ["flatten, 2 times in all directions", [2, 2, 2], ["flatten"], [2.828, 2.828, -2.828, 2.828, 1]],
  ["flatten, mirrored", [-1, 1, 1], ["flatten"], [-1.414, 1.414, 1.414, 1.414, 1]],
]) {
  await write(scale);
  const [first, ...options] = command;
  if (first) execFileSync("npx", ["gltf-transform", first, "in.gltf", "out.gltf", ...options], { stdio: "ignore" });
  const found = await read(first ? "out.gltf" : "in.gltf");
  console.log(`gltf-transform 4.5.1 ${name}: corners and length of the quaternion`,
    found.map((value) => value.toFixed(3)).join(" "));
  if (found.some((value, place) => Math.abs(value - wanted[place]) > 0.002)) {
    console.log("this has changed");
    process.exit(1);
  }
}
END
node leaf.mjs
