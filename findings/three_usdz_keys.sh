#!/usr/bin/env bash
# three.js writes the tangents of glTF's splines into USD as places, lets what should jump glide, and dims what glows.
#
# Expected: what plays in three.js plays so in its USDZ; time samples of USD are straight between keys, so that other
# interpolations are baked. What happens: `USDZExporter` of three.js 0.187, which has animations since 2026, writes the
# first numbers of a track, one for each key, whatever they are. A track of CUBICSPLINE, as `GLTFLoader` makes it, has an
# in-tangent, a value and an out-tangent for each. A leaf that starts at 0 with 8 m/s is at 1.5 m half way in three.js; in
# USD it starts at 8 m, is at 4 m half way, and ends at 0 instead of 1 m. With STEP a leaf that is to jump by 5 m after a
# second glides, and is at 2.5 m half way. An emission of one colour loses `emissiveIntensity`: 5 turns to 1. Three leaves
# of an `InstancedMesh` are one at the origin, and lamps come without light. LINEAR is right. Nothing is said.
# Remedy: sample tracks at the frame rate before the export (`AnimationMixer.setTime`); `emissive` times its intensity.
# Versions: three 0.187.0 (npm), usd-core 26.11 (PyPI). Source: measured here, with OpenUSD to read;
# https://github.com/mrdoob/three.js (pull request 33589, animations; issue 22203, instances);
# https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html (appendix C, interpolation modes)
# Needs node, npm, python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet usd-core==26.11
npm init -y >/dev/null
npm install --silent --no-fund --no-audit three@0.187.0
cat >export.mjs <<'END'
import { writeFileSync } from "node:fs";
import { AnimationMixer } from "three";
import { USDZExporter } from "three/addons/exporters/USDZExporter.js";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

globalThis.self = globalThis;
globalThis.ProgressEvent = class {};
let said = 0;
console.warn = console.error = () => { said += 1; };

const arrays = [], accessors = [];
/** Index of a new accessor of floats. */
function accessor(type, count, ...numbers) {
  accessors.push({ bufferView: arrays.length, componentType: 5126, count, type });
  arrays.push(new Float32Array(numbers));
  return accessors.length - 1;
}
const attributes = {
  POSITION: accessor("VEC3", 3, 0, 0, 0, 1, 0, 0, 0, 1, 0), NORMAL: accessor("VEC3", 3, 0, 0, 1, 0, 0, 1, 0, 0, 1),
};
const seconds = accessor("SCALAR", 2, 0, 1);
Object.assign(accessors[attributes.POSITION], { min: [0, 0, 0], max: [1, 1, 0] });
Object.assign(accessors[seconds], { min: [0], max: [1] });
const tracks = [
  ["linear", "LINEAR", accessor("VEC3", 2, 0, 0, 0, 1, 0, 0)],
  ["spline", "CUBICSPLINE", accessor("VEC3", 6, 8, 0, 0, 0, 0, 0, 8, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0)],
  ["step", "STEP", accessor("VEC3", 2, 0, 0, 0, 5, 0, 0)],
];
let end = 0;
const bufferViews = arrays.map(({ byteLength }) => {
  end += byteLength;
  return { buffer: 0, byteOffset: end - byteLength, byteLength };
});
const places = accessor("VEC3", 3);
accessors[places].bufferView = bufferViews.length;
bufferViews.push({ buffer: 0, byteOffset: end, byteLength: 36 });
arrays.push(new Float32Array([10, 0, 0, 20, 0, 0, 30, 0, 0]));
const bytes = Buffer.concat(arrays.map((array) => Buffer.from(array.buffer)));
const gltf = {
  asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [0, 1, 2, 3, 4] }],
  extensionsUsed: ["EXT_mesh_gpu_instancing", "KHR_materials_emissive_strength", "KHR_lights_punctual"],
  extensions: { KHR_lights_punctual: { lights: [{ type: "point", intensity: 100 }] } },
  nodes: [
    ...tracks.map(([name]) => ({ name, mesh: 0 })),
    { name: "many", mesh: 0, extensions: { EXT_mesh_gpu_instancing: { attributes: { TRANSLATION: places } } } },
    { name: "lamp", extensions: { KHR_lights_punctual: { light: 0 } } },
  ],
  meshes: [{ primitives: [{ attributes, material: 0 }] }],
  materials: [{ emissiveFactor: [1, 1, 1], extensions: { KHR_materials_emissive_strength: { emissiveStrength: 5 } } }],
  animations: [{
    samplers: tracks.map(([, interpolation, output]) => ({ input: seconds, output, interpolation })),
    channels: tracks.map((_, index) => ({ sampler: index, target: { node: index, path: "translation" } })),
  }],
  accessors, bufferViews,
  buffers: [{ byteLength: bytes.length, uri: "data:application/octet-stream;base64," + bytes.toString("base64") }],
};
const { scene, animations } = await new GLTFLoader().parseAsync(JSON.stringify(gltf), "");
const mixer = new AnimationMixer(scene);
mixer.clipAction(animations[0]).play();
mixer.setTime(0.5);
const found = tracks.map(([name]) => scene.getObjectByName(name).position.x).join(" ");
mixer.stopAllAction();
scene.updateMatrixWorld(true);
writeFileSync("leaves.usdz", await new USDZExporter().parseAsync(scene, { animations, animationFrameRate: 24 }));
console.log(`three 0.187.0 linear spline step: at 0.5 s ${found} m, warnings ${said}`);
if (found !== "0.5 1.5 0" || said) {
  console.log("this has changed");
  process.exit(1);
}
END
node export.mjs
cat >read.py <<'END'
from pxr import Usd, UsdGeom, UsdLux, UsdShade

stage = Usd.Stage.Open("leaves.usdz")
prims = {prim.GetName(): prim for prim in stage.Traverse()}
found = {}
for name in ("linear", "spline", "step"):
    leaf = UsdGeom.Xformable(prims[name])
    found[name] = [leaf.ComputeLocalToWorldTransform(code).ExtractTranslation()[0] for code in (0, 12, 24)]
surface = next(UsdShade.Shader(prim) for prim in stage.Traverse() if prim.GetName() == "PreviewSurface")
found["emission"] = surface.GetInput("emissiveColor").Get()[0]
meshes = [prim for prim in Usd.PrimRange(prims["many"]) if prim.IsA(UsdGeom.Mesh)]
found["many"] = [UsdGeom.Xformable(mesh).ComputeLocalToWorldTransform(0).ExtractTranslation()[0] for mesh in meshes]
found["lamps"] = sum(1 for prim in stage.Traverse() if prim.HasAPI(UsdLux.LightAPI))
for name, value in found.items():
    print("USDZ of three 0.187.0", name, value)
if found != {"linear": [0, 0.5, 1], "spline": [8, 4, 0], "step": [0, 2.5, 5], "emission": 1, "many": [0], "lamps": 0}:
    raise SystemExit("this has changed")
END
venv/bin/python read.py
