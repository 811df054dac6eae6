#!/usr/bin/env bash
# three.js exports smooth tracks of places to glTF as straight ones.
#
# Expected: a track with `InterpolateSmooth` (`Catmull-Rom` through its keys) is baked, written as CUBICSPLINE, or a
# warning says that it is not, as the exporter says of morph targets. What happens: `GLTFExporter` of three.js 0.187
# writes its keys with LINEAR. A leaf keyed at 0, 1, 1 and 0 m for seconds 0 to 3 stands at 1.125 m half way between the
# middle keys before, and at 1.000 m after `GLTFLoader` has read the file. Tracks with `InterpolateDiscrete` keep their
# steps. Nothing is said. The path of a swaying leaf gets a corner at each key.
# Remedy: sample such tracks at the frame rate before the export (`track.createInterpolant().evaluate(time)`).
# Versions: three 0.187.0 (npm). Source: measured here; https://threejs.org/docs/#KeyframeTrack (interpolation);
# https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html (appendix C, interpolation modes)
# Needs node, npm. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm init -y >/dev/null
npm install --silent --no-fund --no-audit three@0.187.0
cat >smooth.mjs <<'END'
import {
  AnimationClip, AnimationMixer, InterpolateDiscrete, InterpolateLinear, InterpolateSmooth, Object3D, Scene,
  VectorKeyframeTrack,
} from "three";
import { GLTFExporter } from "three/addons/exporters/GLTFExporter.js";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

globalThis.self = globalThis;
globalThis.ProgressEvent = class {};
globalThis.FileReader = class {
  async readAsDataURL(blob) {
    this.result = "data:application/octet-stream;base64," + Buffer.from(await blob.arrayBuffer()).toString("base64");
    this.onloadend();
  }
};
let said = 0;
console.warn = () => { said += 1; };

/** Where the leaf is at 1.5 s, in metres. */
function place(root, clip) {
  const mixer = new AnimationMixer(root);
  mixer.clipAction(clip).play();
  mixer.setTime(1.5);
  return root.getObjectByName("leaf").position.x.toFixed(3);
}

let isSame = true;
for (const [name, mode, wanted] of [
  ["InterpolateLinear", InterpolateLinear, "1.000 1.000 LINEAR"],
  ["InterpolateDiscrete", InterpolateDiscrete, "1.000 1.000 STEP"],
  ["InterpolateSmooth", InterpolateSmooth, "1.125 1.000 LINEAR"],
]) {
  const scene = new Scene();
  const leaf = new Object3D();
  leaf.name = "leaf";
  scene.add(leaf);
  const track = new VectorKeyframeTrack("leaf.position", [0, 1, 2, 3], [0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0], mode);
  const clip = new AnimationClip("sway", 3, [track]);
  const before = place(scene, clip);
  const text = JSON.stringify(await new GLTFExporter().parseAsync(scene, { animations: [clip] }));
  const read = await new GLTFLoader().parseAsync(text, "");
  const after = place(read.scene, read.animations[0]);
  const found = `${before} ${after} ${JSON.parse(text).animations[0].samplers[0].interpolation}`;
  console.log(`three 0.187.0 ${name}: at 1.5 s ${before} m, exported ${after} m, file says ${found.split(" ")[2]}`);
  isSame &&= found === wanted;
}
console.log(`warnings: ${said}`);
if (!isSame || said) {
  console.log("this has changed");
  process.exit(1);
}
END
node smooth.mjs
