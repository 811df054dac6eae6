#!/usr/bin/env bash
# What turns about one axis, by matrices or in another order stands still once three.js has read it from USD.
#
# Expected: `xformOpOrder` of USD lists the steps by which a prim gets its place, whatever steps these are, and each may
# have samples: a matrix, a turn about one axis, three angles in one of six orders, a pivot. A leaf that turns by 90
# degrees a half second has its tip, 1 m out, at 0 1 0 after that, by a matrix at 5 1 0 as it also goes 5 m. What
# happens: `USDLoader` of three.js 0.187 makes tracks of `translate`, `rotateXYZ`, `orient` and `scale` alone. Samples
# of `rotateZ` and `transform` are dropped. `rotateZYX` is dropped even where nothing moves. A pivot counts where
# nothing moves, and not as the leaf turns about it, so that it swings about elsewhere. Of two translations the first
# alone counts. Nothing is said.
# Remedy: convert to glTF by another program; or write `translate`, `orient` and `scale`, once each, before.
# Versions: three 0.187.0 (npm), usd-core 26.11 (PyPI). Source: measured here, with OpenUSD itself for the truth;
# https://openusd.org/release/api/class_usd_geom_xformable.html (xformOpOrder);
# https://threejs.org/docs/pages/USDLoader.html
# Needs node, npm, python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet usd-core==26.11
npm init -y >/dev/null
npm install --silent three@0.187.0
cat >write.py <<'END'
import json

from pxr import Gf, Usd, UsdGeom

STAGE = """#usda 1.0
(
    endTimeCode = 24
    metersPerUnit = 1
    startTimeCode = 0
    timeCodesPerSecond = 24
    upAxis = "Y"
)
def Xform "leaf"
{
%s
    uniform token[] xformOpOrder = [%s]
    def Mesh "blade"
    {
        int[] faceVertexCounts = [3]
        int[] faceVertexIndices = [0, 1, 2]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
    }
}
"""


def moved(name, start, end):
    return "    %s.timeSamples = {\n        0: %s,\n        12: %s,\n    }\n" % (name, start, end)


def still(name, value):
    return "    %s = %s\n" % (name, value)


PIVOT = still("float3 xformOp:translate:pivot", "(1, 0, 0)")
ABOUT = ["translate:pivot", "rotateXYZ", "!translate:pivot"]
CASES = {
    "rotateXYZ": (moved("float3 xformOp:rotateXYZ", "(0, 0, 0)", "(0, 0, 90)"), ["rotateXYZ"]),
    "rotateZ": (moved("float xformOp:rotateZ", 0, 90), ["rotateZ"]),
    "transform": (moved("matrix4d xformOp:transform", "((1,0,0,0), (0,1,0,0), (0,0,1,0), (0,0,0,1))",
                        "((0,1,0,0), (-1,0,0,0), (0,0,1,0), (5,0,0,1))"), ["transform"]),
    "rotateZYX, still": (still("float3 xformOp:rotateZYX", "(0, 0, 90)"), ["rotateZYX"]),
    "pivot, still": (PIVOT + still("float3 xformOp:rotateXYZ", "(0, 0, 90)"), ABOUT),
    "pivot": (PIVOT + moved("float3 xformOp:rotateXYZ", "(0, 0, 0)", "(0, 0, 90)"), ABOUT),
    "two translations, still": (
        still("double3 xformOp:translate", "(1, 0, 0)") + still("double3 xformOp:translate:wind", "(0, 1, 0)"),
        ["translate", "translate:wind"]),
}
cases = []
for number, (name, (steps, order)) in enumerate(CASES.items()):
    words = ['"!invert!xformOp:%s"' % step[1:] if step[0] == "!" else '"xformOp:%s"' % step for step in order]
    path = "%d.usda" % number
    with open(path, "w") as file:
        file.write(STAGE % (steps, ", ".join(words)))
    stage = Usd.Stage.Open(path)
    world = UsdGeom.Xformable(stage.GetPrimAtPath("/leaf")).ComputeLocalToWorldTransform(12)
    cases.append({"name": name, "path": path, "tip": list(world.Transform(Gf.Vec3d(1, 0, 0)))})
with open("cases.json", "w") as file:
    json.dump(cases, file)
END
venv/bin/python write.py
cat >read.mjs <<'END'
import { readFileSync } from "node:fs";
import * as THREE from "three";
import { USDLoader } from "three/addons/loaders/USDLoader.js";

globalThis.self = globalThis;
// Where three.js has the tip, and where OpenUSD has it.
const WANTED = {
  "rotateXYZ": [0, 1, 0, 0, 1, 0],
  "rotateZ": [1, 0, 0, 0, 1, 0],
  "transform": [1, 0, 0, 5, 1, 0],
  "rotateZYX, still": [1, 0, 0, 0, 1, 0],
  "pivot, still": [1, 0, 0, 1, 0, 0],
  "pivot": [0, 1, 0, 1, 0, 0],
  "two translations, still": [2, 0, 0, 2, 1, 0],
};
for (const { name, path, tip } of JSON.parse(readFileSync("cases.json"))) {
  const root = new USDLoader().parse(readFileSync(path, "utf8"));
  if (root.animations.length) {
    const mixer = new THREE.AnimationMixer(root);
    const action = mixer.clipAction(root.animations[0]).setLoop(THREE.LoopOnce);
    action.clampWhenFinished = true;
    action.play();
    mixer.setTime(0.5);
  }
  root.updateMatrixWorld(true);
  const found = new THREE.Vector3(1, 0, 0).applyMatrix4(root.getObjectByName("leaf").matrixWorld).toArray();
  const text = (numbers) => numbers.map((number) => number.toFixed(2)).join(" ");
  console.log(`three ${THREE.REVISION} ${name}: the tip is at ${text(found)}, by OpenUSD at ${text(tip)}`);
  if ([...found, ...tip].some((value, place) => Math.abs(value - WANTED[name][place]) > 0.01)) {
    console.log("this has changed");
    process.exit(1);
  }
}
END
node read.mjs
