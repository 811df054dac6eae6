#!/usr/bin/env bash
# A lamp with keys is 12.6 times as bright in Blender's glTF as the same lamp without, and a sun is 683 times as dark.
#
# Expected: `intensity` of a light is in candela, of a sun in lux, and KHR_animation_pointer animates that very number. So
# the first key of a lamp of 100 W is what the light itself says, 100 * 683 / (4 pi) = 5435 cd, that of a sun of 100 W/m2
# is 68300 lx. What happens: with *Animation Pointer* Blender 5.3.0 writes lights rightly, and keys of lamps in lumen,
# 68300, and of suns in W/m2, 100. The *Exposure* of a lamp is in its light, and not in its keys. As an animation begins
# lamps flare up by 4 pi, and suns go out. Import has the same slip for lamps: read back they are as they were, and a
# file that keeps to the specification is read 12.6 times too dark. Suns come back 683 times as dark.
# Remedy: divide keys of lamps by 4 pi, multiply those of suns by 683, and both by 2^exposure.
# Versions: bpy 5.3.0, bpy 5.0.1 has the same (PyPI). Source: measured here; https://github.com/KhronosGroup/glTF
# (extensions/2.0/Khronos/KHR_lights_punctual, extensions/2.0/Khronos/KHR_animation_pointer)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0
cat >keys.py <<'END'
import json
import os
import struct

import bpy

for kind, exposure, light, key, read_back in [
    ("POINT", 0, 5435.14, 68300, 100), ("SPOT", 0, 5435.14, 68300, 100), ("SUN", 0, 68300, 100, 0.1464),
    ("POINT", 2, 21740.57, 68300, 100),
]:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 0, 10
    lamp = bpy.data.lights.new("lamp", kind)
    lamp.exposure = exposure
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("lamp", lamp))
    for frame, energy in ((0, 100), (10, 200)):
        lamp.energy = energy
        lamp.keyframe_insert("energy", frame=frame)
    bpy.context.scene.frame_set(0)
    path = os.path.abspath("lamp.gltf")
    bpy.ops.export_scene.gltf(filepath=path, export_format="GLTF_SEPARATE", export_lights=True,
                              export_pointer_animation=True, export_animation_mode="SCENE")
    document = json.load(open(path))
    channel, = document["animations"][0]["channels"]
    pointer = channel["target"]["extensions"]["KHR_animation_pointer"]["pointer"]
    values = document["accessors"][document["animations"][0]["samplers"][channel["sampler"]]["output"]]
    start = document["bufferViews"][values["bufferView"]].get("byteOffset", 0) + values.get("byteOffset", 0)
    first, = struct.unpack_from("<f", open("lamp.bin", "rb").read(), start)
    said = document["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"]
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=path)
    bpy.context.scene.frame_set(0)
    energy = bpy.data.lights[0].evaluated_get(bpy.context.evaluated_depsgraph_get()).energy
    print("bpy", bpy.app.version_string, kind, "of 100, exposure", exposure, "light %.1f first key %.1f" % (said, first),
          "read back %.4f" % energy, flush=True)
    if pointer != "/extensions/KHR_lights_punctual/lights/0/intensity":
        raise SystemExit("this has changed")
    if any(abs(a / b - 1) > 0.001 for a, b in ((said, light), (first, key), (energy, read_back))):
        raise SystemExit("this has changed")
END
venv/bin/python keys.py 2>&1 | grep "^bpy\|changed"
