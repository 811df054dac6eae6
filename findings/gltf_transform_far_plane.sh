#!/usr/bin/env bash
# gltf-transform gives cameras without a far plane one at 100.
#
# Expected: a perspective camera without `zfar` stays so: it is infinite. What happens: gltf-transform 4.5.1 reads
# and writes it with `zfar: 100`, and renderers that honour clipping planes show nothing beyond.
# Remedy: give cameras a far plane before, or take it out afterwards.
# Source: https://github.com/donmccurdy/glTF-Transform (packages/core/src/properties/camera.ts)
# Needs node, npm. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm init -y >/dev/null
npm install --silent @gltf-transform/core@4.5.1
cat >in.gltf <<'END'
{"asset": {"version": "2.0"}, "cameras": [{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}],
 "nodes": [{"camera": 0}], "scenes": [{"nodes": [0]}], "scene": 0}
END
cat >run.mjs <<'END'
import { NodeIO } from "@gltf-transform/core";
const io = new NodeIO();
const { json } = await io.writeJSON(await io.read("in.gltf"));
console.log("gltf-transform 4.5.1: zfar", json.cameras[0].perspective.zfar);
process.exit(json.cameras[0].perspective.zfar === 100 ? 0 : 1);
END
node run.mjs
