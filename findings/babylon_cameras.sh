#!/usr/bin/env bash
# Babylon.js exports a wide camera four times as wide, and one that sees to infinity with a far plane at 0.
#
# Expected: a camera of glTF shows what the camera of Babylon.js shows. With FOVMODE_HORIZONTAL_FIXED as `fovMode` `fov`
# is the angle across: 0.5 rad are 0.254 up at 2:1, 2 atan(tan(0.25) / 2). What happens: `GLTF2Export` of Babylon.js
# 9.28 multiplies the angle by the shape of the picture, where its tangent is to be divided: `yfov` is 1 rad, and 4.3
# times as much is seen across. An upright picture of 1:2 is too narrow by as much. `maxZ` at 0 is no far plane in
# Babylon.js, and its loader gives that to all cameras of glTF without `zfar`. It is exported as `zfar` 0, which glTF
# does not allow. So a file that is only read and written is invalid; Blender 5.3 shows nothing beyond a micrometre.
# Nothing is said.
# Remedy: before the export FOVMODE_VERTICAL_FIXED with `fov` = 2 atan(tan(fov / 2) / aspect), and a `maxZ`.
# Versions: @babylonjs/core, loaders and serializers 9.28.0, gltf-validator 2.0.0-dev.3.10 (npm). Source: measured here;
# https://doc.babylonjs.com/typedoc/classes/BABYLON.Camera (fovMode, maxZ);
# https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html (5.14, camera.perspective: zfar is above 0)
# Needs node, npm. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm init -y >/dev/null
npm install --silent @babylonjs/core@9.28.0 @babylonjs/loaders@9.28.0 @babylonjs/serializers@9.28.0 \
    gltf-validator@2.0.0-dev.3.10
cat >cameras.mjs <<'END'
import * as BABYLON from "@babylonjs/core";
import "@babylonjs/loaders/glTF/index.js";
import { GLTF2Export } from "@babylonjs/serializers/glTF/index.js";
import validator from "gltf-validator";

globalThis.XMLHttpRequest ??= class {};
BABYLON.Logger.LogLevels = BABYLON.Logger.NoneLogLevel;

function newScene(width, height) {
  const scene = new BABYLON.Scene(new BABYLON.NullEngine({ renderWidth: width, renderHeight: height }));
  scene.useRightHandedSystem = true;
  return scene;
}

async function exported(scene) {
  const { files } = await GLTF2Export.GLTFAsync(scene, "out", {});
  return JSON.parse(files["out.gltf"]);
}

function check(text, found, wanted) {
  console.log("Babylon.js", BABYLON.Engine.Version, text, ...found.map((number) => +number.toFixed(3)));
  if (found.length !== wanted.length || found.some((number, place) => Math.abs(number - wanted[place]) > 0.002)) {
    console.log("this has changed");
    process.exit(1);
  }
}

for (const [mode, name, width, height, wanted] of [
  [BABYLON.Camera.FOVMODE_VERTICAL_FIXED, "vertical", 512, 256, [0.5, 0.5]],
  [BABYLON.Camera.FOVMODE_HORIZONTAL_FIXED, "horizontal", 512, 256, [0.254, 1]],
  [BABYLON.Camera.FOVMODE_HORIZONTAL_FIXED, "horizontal", 256, 512, [0.944, 0.25]],
]) {
  const scene = newScene(width, height);
  const camera = new BABYLON.FreeCamera("camera", BABYLON.Vector3.Zero(), scene);
  camera.fov = 0.5;
  camera.fovMode = mode;
  // By what Babylon.js draws: the cotangent of half the angle is in its matrix of projection.
  const seen = 2 * Math.atan(1 / camera.getProjectionMatrix(true).m[5]);
  const { perspective } = (await exported(scene)).cameras[0];
  check(`fov of 0.5 rad, ${name}, ${width} x ${height}: height as drawn, and in glTF`,
        [seen, perspective.yfov], wanted);
}

const file = { asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ name: "camera", camera: 0 }],
               cameras: [{ type: "perspective", perspective: { yfov: 0.5, znear: 0.1 } }] };
const errors = async (json) => (await validator.validateString(JSON.stringify(json))).issues.numErrors;
const scene = newScene(512, 256);
const url = "data:model/gltf+json;base64," + Buffer.from(JSON.stringify(file)).toString("base64");
await BABYLON.AppendSceneAsync(url, scene, { pluginExtension: ".gltf" });
const again = await exported(scene);
check("without a far plane, read and written: zfar, errors of the file before, and after",
      [again.cameras[0].perspective.zfar, await errors(file), await errors(again)], [0, 0, 1]);
END
node cameras.mjs
