#!/usr/bin/env bash
# Scattered leaves of USD are one leaf at the origin in three.js; what is referenced within the stage never comes.
#
# Expected: three leaves of a `PointInstancer` are where `positions` says, and its prototype is drawn nowhere else; two
# instances that reference a prim of the same stage are its meshes, at their places. What happens: `USDLoader` of three.js
# 0.187 takes the instancer for a group and its prototype for a child of that, so that one leaf is at the origin, where
# none should be. A reference within the stage, `</Leaf>`, brings nothing in: an empty node is at its place, instanceable
# or not. Both are how Blender and Houdini write scattered leaves and instances. Nothing is said, and the loader's page
# names no limits. A mesh as it is is right.
# Remedy: flatten instances into meshes before, or convert to glTF with EXT_mesh_gpu_instancing, which three.js reads.
# Versions: three 0.187.0 (npm), usd-core 26.11 (PyPI). Source: measured here; https://threejs.org/docs/#USDLoader;
# https://openusd.org/release/api/class_usd_geom_point_instancer.html
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


def leaf(stage, path):
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (0, 1, 0)])
    mesh.CreateFaceVertexCountsAttr([3])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
    return mesh


def stage_of(name):
    stage = Usd.Stage.CreateNew(name)
    UsdGeom.SetStageUpAxis(stage, "Y")
    UsdGeom.SetStageMetersPerUnit(stage, 1)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/Wood").GetPrim())
    return stage


stage = stage_of("meshes.usda")
for at in (10, 20, 30):
    leaf(stage, f"/Wood/leaf_{at}").AddTranslateOp().Set((at, 0, 0))
stage.Save()

stage = stage_of("scatter.usda")
scatter = UsdGeom.PointInstancer.Define(stage, "/Wood/Scatter")
leaf(stage, "/Wood/Scatter/Leaf")
scatter.CreatePrototypesRel().AddTarget("/Wood/Scatter/Leaf")
scatter.CreateProtoIndicesAttr([0, 0, 0])
scatter.CreatePositionsAttr([(10, 0, 0), (20, 0, 0), (30, 0, 0)])
stage.Save()
print("OpenUSD", ".".join(map(str, Usd.GetVersion())), "scatter.usda",
      *(place.ExtractTranslation()[0] for place in scatter.ComputeInstanceTransformsAtTime(0, 0)))

for instanceable in (True, False):
    stage = stage_of(f"references_{'instances' if instanceable else 'copies'}.usda")
    stage.CreateClassPrim("/Leaf")
    leaf(stage, "/Leaf/mesh")
    for at in (10, 20, 30):
        twig = UsdGeom.Xform.Define(stage, f"/Wood/twig_{at}")
        twig.GetPrim().GetReferences().AddInternalReference("/Leaf")
        twig.GetPrim().SetInstanceable(instanceable)
        twig.AddTranslateOp().Set((at, 0, 0))
    stage.Save()
    meshes = [UsdGeom.Mesh(prim) for prim in Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies()) if prim.IsA(UsdGeom.Mesh)]
    print("OpenUSD", ".".join(map(str, Usd.GetVersion())), stage.GetRootLayer().GetDisplayName(),
          *(mesh.ComputeLocalToWorldTransform(0).ExtractTranslation()[0] for mesh in meshes))
END
venv/bin/python stage.py
cat >load.mjs <<'END'
import { readFileSync } from "node:fs";
import { USDLoader } from "three/addons/loaders/USDLoader.js";

for (const [name, wanted] of [
  ["meshes", [10, 20, 30]], ["scatter", [0]], ["references_instances", []], ["references_copies", []],
]) {
  const stage = new USDLoader().parse(readFileSync(`${name}.usda`, "utf8"));
  stage.updateMatrixWorld(true);
  const places = [];
  stage.traverse((node) => { if (node.isMesh) places.push(node.isInstancedMesh ? "instances" : node.matrixWorld.elements[12]); });
  console.log("three.js 0.187.0", `${name}.usda`, places.length, "leaves at", ...places);
  if (String(places) !== String(wanted)) { console.log("this has changed"); process.exit(1); }
}
END
node load.mjs
