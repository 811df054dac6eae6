#!/usr/bin/env bash
# Assimp writes the tangents of glTF's splines as places, and fades what should jump.
#
# Expected: a key of CUBICSPLINE is an in-tangent, a value and an out-tangent (glTF 2.0, appendix C.5). A leaf that starts
# at 0 with a tangent of 8 m/s and ends at 1 m is at 1.5 m half way; a converter keeps that, or writes many keys. With
# STEP a leaf that is to be there from 1 s on has no size before. What happens: the import of Assimp 6.0.5 makes three keys
# at one time of each, marked as splines, and its export passes over the mark: all are LINEAR. `assimp export` to glTF has
# a leaf that starts at 8 m, glides to 0, is at 4 m half way and ends at 0. Times do not increase, so that the file is
# invalid. STEP is LINEAR as well: at 0.5 s the leaf has half its size. Nothing is said, and the exit code is 0.
# Remedy: a key of LINEAR for every frame before Assimp, as Blender's export writes by default.
# Versions: Assimp 6.0.5 (cmeel-assimp 6.0.5 of PyPI). Source: measured here;
# https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html (C.3 Step, C.5 Cubic spline; 3.11, times increase strictly);
# https://github.com/assimp/assimp (pull request 6543: tangents come in since 2026; before, they were left out)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet cmeel-assimp==6.0.5
cat >keys.py <<'END'
import base64
import json
import struct
import subprocess
import sys
from pathlib import Path

ROWS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}


def write(name, interpolation, path, values):
    """A triangle with two keys at 0 and 1 s."""
    numbers, accessors, views = [], [], []
    for kind, array in [("VEC3", [0, 0, 0, 1, 0, 0, 0, 1, 0]), ("SCALAR", [0, 1]), ("VEC3", values)]:
        columns = [array[at::ROWS[kind]] for at in range(ROWS[kind])]
        views.append({"buffer": 0, "byteOffset": 4 * len(numbers), "byteLength": 4 * len(array)})
        accessors.append({"bufferView": len(views) - 1, "componentType": 5126, "type": kind, "count": len(columns[0]),
                          "min": list(map(min, columns)), "max": list(map(max, columns))})
        numbers += array
    data = base64.b64encode(struct.pack(f"<{len(numbers)}f", *numbers)).decode()
    Path(name).write_text(json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"name": "Leaf", "mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "accessors": accessors, "bufferViews": views,
        "buffers": [{"byteLength": 4 * len(numbers), "uri": "data:application/octet-stream;base64," + data}],
        "animations": [{"samplers": [{"input": 1, "output": 2, "interpolation": interpolation}],
                        "channels": [{"sampler": 0, "target": {"node": 0, "path": path}}]}],
    }))


def read(name, path):
    """Interpolation, times and the first number of each value."""
    file = json.loads(Path(name).read_text())
    animation = file["animations"][0]
    sampler = next(animation["samplers"][channel["sampler"]] for channel in animation["channels"]
                   if channel["target"]["path"] == path)
    data = Path(file["buffers"][0]["uri"]).read_bytes()

    def numbers(index):
        accessor = file["accessors"][index]
        view, rows = file["bufferViews"][accessor["bufferView"]], ROWS[accessor["type"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        return list(struct.unpack_from(f"<{rows * accessor['count']}f", data, start))[::rows]

    return sampler.get("interpolation", "LINEAR"), numbers(sampler["input"]), numbers(sampler["output"])


SPLINE = [0, 0, 0, 0, 0, 0, 8, 0, 0] + [0, 0, 0, 1, 0, 0, 0, 0, 0]
for interpolation, path, values, wanted in [
    ("LINEAR", "translation", [0, 0, 0, 1, 0, 0], ("LINEAR", [0, 1], [0, 1])),
    ("CUBICSPLINE", "translation", SPLINE, ("LINEAR", [0, 0, 0, 1, 1, 1], [0, 0, 8, 0, 1, 0])),
    ("STEP", "scale", [0, 0, 0, 1, 1, 1], ("LINEAR", [0, 1], [0, 1])),
]:
    write("leaf.gltf", interpolation, path, values)
    subprocess.run([sys.argv[1], "export", "leaf.gltf", "out.gltf"], check=True, capture_output=True)
    found = read("out.gltf", path)
    print("Assimp 6.0.5", interpolation, path, "is", found[0], "times", *found[1], "values", *found[2], flush=True)
    if found != wanted:
        raise SystemExit("this has changed")
END
venv/bin/python keys.py venv/bin/assimp
