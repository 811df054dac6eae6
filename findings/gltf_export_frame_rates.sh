#!/usr/bin/env bash
# Blender's glTF export turns the base of a frame rate upside down: a shot of 23.976 frames a second runs too fast.
#
# Expected: glTF has seconds. Frame n of a scene of 24 / 1.001 frames a second is at n * 1.001 / 24 s.
# What happens: Blender 5.3.0 writes n / (24 * 1.001) s. Frame 2400 is at 99.900 s, where it belongs at 100.100 s: 4.8
# frames away from a plate or from sound. At a base of 2 all is 4 times as fast. Import has the same slip, so that a
# round trip through Blender gives the old frames back.
# Remedy: multiply the times of the file by the base squared; or export at a base of 1, and multiply by the base.
# Versions: bpy 5.3.0, bpy 5.0.1 has the same (PyPI). Source: measured here;
# https://github.com/KhronosGroup/glTF-Blender-IO (issue 2024, whose remedy this was, in 2023);
# https://docs.blender.org/api/current/bpy.types.RenderSettings.html (fps_base)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0
cat >rates.py <<'END'
import json
import os

import bpy

PATH = os.path.abspath("leaf.gltf")


def last_key(base):
    """The time in seconds of what has its key on frame 2400, in a glTF file, and its frame after import."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.fps, scene.render.fps_base, scene.frame_end = 24, base, 2400
    bpy.ops.object.empty_add()
    leaf = bpy.context.object
    leaf.keyframe_insert("location", frame=0)
    leaf.location.x = 1
    leaf.keyframe_insert("location", frame=2400)
    bpy.ops.export_scene.gltf(filepath=PATH, export_format="GLTF_SEPARATE")
    with open(PATH) as file:
        document = json.load(file)
    times = document["animations"][0]["samplers"][0]["input"]
    bpy.ops.object.delete()
    bpy.ops.import_scene.gltf(filepath=PATH)
    return document["accessors"][times]["max"][0], bpy.data.actions[-1].frame_range[1]


for base in (1.0, 1.001, 2.0):
    found_s, frame = last_key(base)
    true_s, wanted_s = 2400 * base / 24, 2400 / (24 * base)
    print("bpy %s base %.3f: frame 2400 is at %.3f s, in the file at %.3f s, read back as frame %.1f"
          % (bpy.app.version_string, base, true_s, found_s, frame), flush=True)
    if abs(found_s - wanted_s) > 0.001 or abs(frame - 2400) > 0.1:
        raise SystemExit("this has changed")
END
venv/bin/python rates.py 2>&1 | grep "^bpy\|changed"
