#!/usr/bin/env bash
# Leaves of one name: three.js moves the first by the mean of all their keys, and the others stand still.
#
# Expected: in USD names are unique among siblings alone; /Tree/A/leaf and /Tree/B/leaf are two leaves, as each reference
# of one asset brings its own names along. The first falls by 4 m in a second, the second rises by 2 m; half way they are
# at -2 and at 1 m. What happens: `USDLoader` of three.js 0.187 makes tracks for the last part of the path, `leaf.position`
# twice, and its mixer finds the first node of that name for both and mixes them: half way the first leaf is at -0.5 m,
# the second at 0. With distinct names both are right. Nothing is said. three.js's own glTF loader makes names unique.
# Remedy: distinct names before (`Usd.NamespaceEditor`, or `Sdf` where a leaf is defined); glTF in place of USD.
# Versions: three 0.187.0 (npm), usd-core 26.11 (PyPI). Source: measured here;
# https://github.com/mrdoob/three.js (examples/jsm/loaders/usd/USDComposer.js, _buildTransformAnimations)
# Needs node, npm, python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet usd-core==26.11
npm init -y >/dev/null
npm install --silent three@0.187.0
cat >stage.py <<'END'
from pxr import Usd, UsdGeom

for name, leaves in [("same.usda", ("leaf", "leaf")), ("distinct.usda", ("leaf_a", "leaf_b"))]:
    stage = Usd.Stage.CreateNew(name)
    UsdGeom.SetStageUpAxis(stage, "Y")
    UsdGeom.SetStageMetersPerUnit(stage, 1)
    stage.SetTimeCodesPerSecond(24)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/Tree").GetPrim())
    heights = []
    for twig, leaf, height in [("A", leaves[0], -4), ("B", leaves[1], 2)]:
        UsdGeom.Xform.Define(stage, f"/Tree/{twig}")
        mesh = UsdGeom.Mesh.Define(stage, f"/Tree/{twig}/{leaf}")
        mesh.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (0, 1, 0)])
        mesh.CreateFaceVertexCountsAttr([3])
        mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
        place = mesh.AddTranslateOp()
        place.Set((0, 0, 0), 0)
        place.Set((0, height, 0), 24)
        heights.append(mesh.ComputeLocalToWorldTransform(12).ExtractTranslation()[1])
    stage.Save()
    print("OpenUSD", ".".join(map(str, Usd.GetVersion())), name, "heights half way", *heights)
    if heights != [-2, 1]:
        raise SystemExit("this has changed")
END
venv/bin/python stage.py
cat >load.mjs <<'END'
import { readFileSync } from "node:fs";
import { AnimationMixer } from "three";
import { USDLoader } from "three/addons/loaders/USDLoader.js";

for (const [name, wanted] of [["distinct.usda", [-2, 1]], ["same.usda", [-0.5, 0]]]) {
  const stage = new USDLoader().parse(readFileSync(name, "utf8"));
  const mixer = new AnimationMixer(stage);
  stage.animations.forEach((clip) => mixer.clipAction(clip).play());
  mixer.setTime(0.5);
  stage.updateMatrixWorld(true);
  const heights = [];
  stage.traverse((node) => { if (node.isMesh) heights.push(Number(node.matrixWorld.elements[13].toFixed(3))); });
  const tracks = stage.animations.flatMap((clip) => clip.tracks.map((track) => track.name));
  console.log("three.js 0.187.0", name, "heights half way", ...heights, "by", ...tracks);
  if (heights.some((height, at) => Math.abs(height - wanted[at]) > 0.01)) { console.log("this has changed"); process.exit(1); }
}
END
node load.mjs
