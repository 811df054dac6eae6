#!/usr/bin/env bash
# three.js exports a BatchedMesh of thousands of leaves as one leaf at the origin.
#
# Expected: leaves at 10, 20 and 30 m are there in glTF, as they are from an `InstancedMesh`, which becomes
# EXT_mesh_gpu_instancing; or the exporter warns, as it does of lamps. What happens: `GLTFExporter` of three.js 0.187
# writes the buffers of a `BatchedMesh` as one mesh: each shape once, at the origin, whatever the places, colours and
# visibilities of its instances. What is kept free in the buffers comes along as triangles of no area, nine vertices for
# a leaf of three here. Nothing is said. `BatchedMesh` is what three.js advises for many shapes of one material.
# Remedy: for the export one `InstancedMesh` for each shape, filled by `getMatrixAt` and `getColorAt`.
# Versions: three 0.187.0 (npm). Source: measured here; https://threejs.org/docs/#BatchedMesh;
# https://threejs.org/docs/#GLTFExporter (names the extensions that it writes)
# Needs node, npm. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm init -y >/dev/null
npm install --silent three@0.187.0
cat >batch.mjs <<'END'
import { BatchedMesh, BufferAttribute, BufferGeometry, InstancedMesh, Matrix4, MeshStandardMaterial, Scene } from "three";
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

const shape = new BufferGeometry();
shape.setAttribute("position", new BufferAttribute(new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0]), 3));
shape.setIndex([0, 1, 2]);
const material = new MeshStandardMaterial();
const places = [10, 20, 30].map((x) => new Matrix4().makeTranslation(x, 0, 0));
const instanced = new InstancedMesh(shape, material, 3);
places.forEach((place, at) => instanced.setMatrixAt(at, place));
const batched = new BatchedMesh(3, 9, 9, material);
const leaf = batched.addGeometry(shape);
places.forEach((place) => batched.setMatrixAt(batched.addInstance(leaf), place));

for (const [name, mesh, wanted] of [["InstancedMesh", instanced, [10, 20, 30]], ["BatchedMesh", batched, [0]]]) {
  const scene = new Scene();
  scene.add(mesh);
  const file = await new GLTFExporter().parseAsync(scene);
  const again = await new GLTFLoader().parseAsync(JSON.stringify(file), "");
  const found = [];
  again.scene.updateMatrixWorld(true);
  again.scene.traverse((node) => {
    if (!node.isMesh) return;
    const place = new Matrix4();
    for (let at = 0; at < (node.isInstancedMesh ? node.count : 1); at += 1) {
      if (node.isInstancedMesh) node.getMatrixAt(at, place);
      found.push(place.elements[12] + node.matrixWorld.elements[12]);
    }
  });
  const vertices = file.accessors[file.meshes[0].primitives[0].attributes.POSITION].count;
  console.log("three.js 0.187.0", name, "has leaves at 10 20 30, in glTF at", ...found, "of", vertices, "vertices");
  if (String(found) !== String(wanted) || said) { console.log("this has changed"); process.exit(1); }
}
END
node batch.mjs
