#!/usr/bin/env bash
# three.js exports cameras without their zoom, and orthographic ones off their middle.
#
# Expected: a camera of glTF shows what the camera of three.js shows. `OrbitControls` and `MapControls` zoom orthographic
# cameras by `zoom`, and a lens of 20.6 degrees may be one of 40 with a zoom of 2. What happens: `GLTFExporter` of three.js
# 0.187 writes `fov` of 40 degrees as it is, twice as wide as the picture was. Of orthographic cameras it writes `right`
# and `top`: from -2 to 4 m at a zoom of 2, so 3 m across, is 8 m across and about another middle. It says nothing, where
# it warns of lamps that it drops; its own import shows the wider picture too.
# Remedy: before export set `fov` to `getEffectiveFOV()` and `zoom` to 1, give orthographic cameras equal sides of
# (right - left) / 2 / zoom, and move them to their middle.
# Versions: three 0.187.0 (npm). Source: measured here; https://threejs.org/docs/#PerspectiveCamera (zoom, getEffectiveFOV);
# https://github.com/mrdoob/three.js (examples/jsm/exporters/GLTFExporter.js, processCamera)
# Needs node, npm. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm init -y >/dev/null
npm install --silent three@0.187.0
cat >zoom.mjs <<'END'
import { OrthographicCamera, PerspectiveCamera, Scene, Vector3 } from "three";
import { GLTFExporter } from "three/addons/exporters/GLTFExporter.js";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

globalThis.self = globalThis;
let said = 0;
console.warn = () => { said += 1; };

/** From where to where a camera sees in its own x, in metres, at a distance of 10. */
function seen(camera) {
  camera.updateProjectionMatrix();
  const depth = new Vector3(0, 0, -10).applyMatrix4(camera.projectionMatrix).z;
  return [-1, 1].map((side) => Number(new Vector3(side, 0, depth).applyMatrix4(camera.projectionMatrixInverse).x.toFixed(3)));
}

const lens = Object.assign(new PerspectiveCamera(40, 1, 0.1, 1000), { zoom: 2 });
const plan = Object.assign(new OrthographicCamera(-2, 4, 3, -1, 0.1, 100), { zoom: 2 });
for (const [name, camera, wanted] of [["lens", lens, [-3.64, 3.64]], ["plan", plan, [-4, 4]]]) {
  const scene = new Scene();
  scene.add(camera);
  const file = await new GLTFExporter().parseAsync(scene);
  const again = await new GLTFLoader().parseAsync(JSON.stringify(file), "");
  const found = seen(again.cameras[0]);
  console.log("three.js 0.187.0", name, "sees", ...seen(camera), "in glTF", ...found, JSON.stringify(file.cameras[0][file.cameras[0].type]));
  if (found.some((side, at) => Math.abs(side - wanted[at]) > 0.01) || said) { console.log("this has changed"); process.exit(1); }
}
END
node zoom.mjs
