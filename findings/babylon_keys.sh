#!/usr/bin/env bash
# Babylon.js exports keys to glTF otherwise than it plays them: tangents 60 times too flat, easings lost, spins at rest.
#
# Expected: what plays in Babylon.js plays so in its glTF, or the exporter warns, as it does of pivots and lamps. What
# happens: `GLTF2Export` of Babylon.js 9.28 writes tangents as change a frame, where glTF 2.0 (appendix C.5) has change
# a second. A leaf of glTF that starts with 8 m/s is at 1.5 m half way; the loader has that right, and what is exported
# is at 0.517. An easing curve is left out: a leaf that eases in, at 0.25 m half way, is at 0.5. A full turn about an
# axis, by `rotation`, is two quaternions that are the same turn, and stands still. Curves of `position.x` and
# `position.y` are two channels for one node and path, which glTF does not allow (3.11); a reader plays one of them, or
# none. Nothing is said of any of it.
# Remedy: in Babylon.js a key of `position` and of `rotationQuaternion` for every frame before the export.
# Versions: @babylonjs/core, loaders and serializers 9.28.0 (npm). Source: measured here, with Babylon.js for the truth;
# https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html (3.11; C.5 Cubic spline interpolation);
# https://github.com/BabylonJS/Babylon.js (packages/dev/serializers/src/glTF/2.0/glTFAnimation.ts, _AddSplineTangent)
# Needs node, npm. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm init -y >/dev/null
npm install --silent @babylonjs/core@9.28.0 @babylonjs/loaders@9.28.0 @babylonjs/serializers@9.28.0
cat >keys.mjs <<'END'
import * as BABYLON from "@babylonjs/core";
import "@babylonjs/loaders/glTF/index.js";
import { GLTF2Export } from "@babylonjs/serializers/glTF/index.js";

globalThis.XMLHttpRequest ??= class {};
BABYLON.Logger.LogLevels = BABYLON.Logger.NoneLogLevel;
const { Animation, Vector3 } = BABYLON;

function newScene() {
  const scene = new BABYLON.Scene(new BABYLON.NullEngine());
  scene.useRightHandedSystem = true;
  return scene;
}

function leaf(scene, property, type, start, end, easing) {
  const node = new BABYLON.TransformNode("leaf", scene);
  const animation = new Animation(property, property, 24, type, Animation.ANIMATIONLOOPMODE_CONSTANT);
  animation.setKeys([{ frame: 0, value: start }, { frame: 24, value: end }]);
  if (easing) animation.setEasingFunction(easing);
  node.animations.push(animation);
  return node;
}

// A leaf that starts at 0 with 8 m/s and comes to rest at 1 m after a second.
function splineFile() {
  const numbers = new Float32Array([0, 1, 0, 0, 0, 0, 0, 0, 8, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0]);
  const data = Buffer.from(numbers.buffer).toString("base64");
  return {
    asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ name: "leaf" }],
    animations: [{ samplers: [{ input: 0, output: 1, interpolation: "CUBICSPLINE" }],
                   channels: [{ sampler: 0, target: { node: 0, path: "translation" } }] }],
    accessors: [{ bufferView: 0, componentType: 5126, count: 2, type: "SCALAR", min: [0], max: [1] },
                { bufferView: 1, componentType: 5126, count: 6, type: "VEC3" }],
    bufferViews: [{ buffer: 0, byteLength: 8 }, { buffer: 0, byteOffset: 8, byteLength: 72 }],
    buffers: [{ byteLength: 80, uri: "data:application/octet-stream;base64," + data }],
  };
}

// Channels of what Babylon.js writes, with the path and the value at half a second by the specification.
async function exported(scene) {
  const { files } = await GLTF2Export.GLTFAsync(scene, "out", {});
  const file = JSON.parse(files["out.gltf"]);
  const buffer = new DataView(await files["out.bin"].arrayBuffer());
  const numbers = (index) => {
    const accessor = file.accessors[index];
    const start = (file.bufferViews[accessor.bufferView].byteOffset ?? 0) + (accessor.byteOffset ?? 0);
    const columns = { SCALAR: 1, VEC3: 3, VEC4: 4 }[accessor.type];
    return Array.from({ length: accessor.count }, (_, row) =>
      Array.from({ length: columns }, (_, column) => buffer.getFloat32(start + 4 * (columns * row + column), true)));
  };
  const channels = [];
  for (const { samplers, channels: all } of file.animations) {
    for (const { sampler, target } of all) {
      const values = numbers(samplers[sampler].output);
      const [[start], [end]] = numbers(samplers[sampler].input);
      const along = (0.5 - start) / (end - start);
      let half = values[0].map((value, axis) => value + (values[1][axis] - value) * Math.min(along, 1));
      if (samplers[sampler].interpolation === "CUBICSPLINE") {
        half = values[1].map((value, axis) => (value + values[4][axis]) / 2 + (values[2][axis] - values[3][axis]) / 8);
      }
      channels.push({ path: target.path, values, half });
    }
  }
  return channels;
}

// Where Babylon.js itself has it at half a second.
function played(node, path) {
  const animation = node.animations[0];
  return animation.evaluate(animation.framePerSecond / 2)[path];
}

function check(text, found, wanted) {
  console.log("Babylon.js", BABYLON.Engine.Version, text, ...found.map((number) => number.toFixed(3)));
  if (found.some((number, place) => Math.abs(number - wanted[place]) > 0.002)) {
    console.log("this has changed");
    process.exit(1);
  }
}

let scene = newScene();
const text = Buffer.from(JSON.stringify(splineFile())).toString("base64");
await BABYLON.AppendSceneAsync("data:model/gltf+json;base64," + text, scene, { pluginExtension: ".gltf" });
const loaded = scene.animationGroups[0].targetedAnimations[0].animation;
let [channel] = await exported(scene);
check("spline of 8 m/s: half way it plays, and exports",
      [loaded.evaluate(loaded.framePerSecond / 2).x, channel.half[0]], [1.5, 0.5 + 8 / 60 / 8]);

scene = newScene();
const easeIn = new BABYLON.QuadraticEase();
easeIn.setEasingMode(BABYLON.EasingFunction.EASINGMODE_EASEIN);
let node = leaf(scene, "position", Animation.ANIMATIONTYPE_VECTOR3, Vector3.Zero(), new Vector3(1, 0, 0), easeIn);
[channel] = await exported(scene);
check("ease in: half way it plays, and exports", [played(node, "x"), channel.half[0]], [0.25, 0.5]);

scene = newScene();
node = leaf(scene, "rotation", Animation.ANIMATIONTYPE_VECTOR3, Vector3.Zero(), new Vector3(0, 0, 2 * Math.PI));
[channel] = await exported(scene);
const [first, last] = channel.values;
const cosine = Math.min(1, Math.abs(first.reduce((sum, value, axis) => sum + value * last[axis], 0)));
check("full turn: degrees half way, and degrees between its two keys",
      [played(node, "z") * 180 / Math.PI, Math.acos(cosine) * 360 / Math.PI], [180, 0]);

scene = newScene();
node = leaf(scene, "position.x", Animation.ANIMATIONTYPE_FLOAT, 0, 1);
const up = new Animation("up", "position.y", 24, Animation.ANIMATIONTYPE_FLOAT, Animation.ANIMATIONLOOPMODE_CONSTANT);
up.setKeys([{ frame: 0, value: 0 }, { frame: 24, value: 2 }]);
node.animations.push(up);
const both = await exported(scene);
const translations = both.filter(({ path }) => path === "translation");
check("two curves: channels for one path, the x of one, the y of the other",
      [translations.length, translations[0].half[0], translations[0].half[1], translations[1].half[0],
       translations[1].half[1]], [2, 0.5, 0, 0, 1]);
END
node keys.mjs
