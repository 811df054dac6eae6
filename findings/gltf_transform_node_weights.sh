#!/usr/bin/env bash
# gltf-transform uncurls leaves: `weights` of nodes are lost as it makes instances, and as it packs what has children.
#
# Expected: by glTF 2.0 `weights` of a node count before those of its mesh. So one mesh is a flat leaf, a curled one and
# all between, in five nodes; their tips are at 0, 0.25, 0.5, 0.75 and 1 m. What happens: `instance` of gltf-transform
# 4.5.1, a part of its `optimize`, makes one node of five nodes that share a mesh, with `EXT_mesh_gpu_instancing`, and
# keeps places, turns and scales. All leaves have the weights of the mesh, and all tips are at 0. `quantize` puts the
# mesh of a node that has children, or that is moved by an animation, into a new node below, without weights: the same.
# It says nothing.
# Remedy: `optimize --instance false`; a mesh for each weight, with the weights at the mesh.
# Versions: @gltf-transform/cli, core, extensions 4.5.1 (npm). Source: measured here;
# https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html (3.7.2.2, Morph Targets; node.weights);
# https://gltf-transform.dev/modules/functions/functions/instance
# Needs node, npm. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm init -y >/dev/null
npm install --silent @gltf-transform/cli@4.5.1 @gltf-transform/core@4.5.1 @gltf-transform/extensions@4.5.1
cat >curls.mjs <<'END'
import { Document, NodeIO } from "@gltf-transform/core";
import { ALL_EXTENSIONS } from "@gltf-transform/extensions";
import { execFileSync } from "node:child_process";

const io = new NodeIO().registerExtensions(ALL_EXTENSIONS);

/** A file of five leaves of one mesh, whose tip is at z = 0 and goes to z = 1 by a morph target. */
async function write(change) {
  const document = new Document();
  const buffer = document.createBuffer();
  const points = (...numbers) =>
    document.createAccessor().setType("VEC3").setBuffer(buffer).setArray(new Float32Array(numbers));
  const target = document.createPrimitiveTarget().setAttribute("POSITION", points(0, 0, 0, 0, 0, 1, 0, 0, 0));
  const flat = document.createPrimitive().setAttribute("POSITION", points(0, 0, 0, 2, 0, 0, 0, 2, 0)).addTarget(target);
  const mesh = document.createMesh().addPrimitive(flat).setWeights([0]);
  const scene = document.createScene();
  for (const weight of [0, 0.25, 0.5, 0.75, 1]) {
    const leaf = document.createNode().setMesh(mesh).setTranslation([9 * weight, 0, 0]).setWeights([weight]);
    scene.addChild(leaf);
    change(document, leaf, buffer);
  }
  await io.write("in.gltf", document);
}

/** Heights of all tips, by weights of nodes where there are some, else of meshes. */
async function read(path) {
  const heights = [];
  for (const node of (await io.read(path)).getRoot().listNodes()) {
    const mesh = node.getMesh();
    if (!mesh) continue;
    const [weight] = node.getWeights().length ? node.getWeights() : mesh.getWeights();
    const primitive = mesh.listPrimitives()[0];
    const world = node.getWorldMatrix();
    const tip = [0, 1, 2].map((corner) => {
      const start = primitive.getAttribute("POSITION").getElement(corner, []);
      const moved = primitive.listTargets()[0].getAttribute("POSITION").getElement(corner, []);
      return world[10] * (start[2] + weight * moved[2]) + world[14];
    });
    const instances = node.getExtension("EXT_mesh_gpu_instancing")?.getAttribute("TRANSLATION").getCount() ?? 1;
    heights.push(...Array(instances).fill(Math.max(...tip)));
  }
  return heights;
}

const alone = () => {};
const withChild = (document, leaf) => leaf.addChild(document.createNode("drop"));
function moved(document, leaf, buffer) {
  const floats = (type, ...numbers) =>
    document.createAccessor().setType(type).setBuffer(buffer).setArray(new Float32Array(numbers));
  const sampler = document.createAnimationSampler().setInput(floats("SCALAR", 0, 1))
    .setOutput(floats("VEC3", 0, 0, 0, 0, 9, 0));
  const channel = document.createAnimationChannel().setTargetNode(leaf).setTargetPath("translation")
    .setSampler(sampler);
  document.createAnimation().addSampler(sampler).addChannel(channel);
}

const CURLED = [0, 0.25, 0.5, 0.75, 1], FLAT = [0, 0, 0, 0, 0];
for (const [name, change, command, wanted] of [
  ["as it was written", alone, [], CURLED],
  ["instance", alone, ["instance"], FLAT],
  ["optimize", alone, ["optimize", "--compress", "false", "--simplify", "false"], FLAT],
  ["optimize without instance", alone,
    ["optimize", "--compress", "false", "--simplify", "false", "--instance", "false"], CURLED],
  ["quantize", alone, ["quantize"], CURLED],
  ["quantize, a drop below each leaf", withChild, ["quantize"], FLAT],
  ["quantize, leaves that fall", moved, ["quantize"], FLAT],
]) {
  await write(change);
  const [first, ...options] = command;
  if (first) execFileSync("npx", ["gltf-transform", first, "in.gltf", "out.gltf", ...options], { stdio: "ignore" });
  const found = await read(first ? "out.gltf" : "in.gltf");
  console.log(`gltf-transform 4.5.1 ${name}: tips at`, found.map((tip) => tip.toFixed(3)).join(" "));
  if (found.length !== 5 || found.some((height, leaf) => Math.abs(height - wanted[leaf]) > 0.002)) {
    console.log("this has changed");
    process.exit(1);
  }
}
END
node curls.mjs
