#!/usr/bin/env bash
# Zooms and pulled focus by USD's splines stand still in Blender, and lamps that flicker or fade burn evenly.
#
# Expected: what an attribute of USD is at a time is what `Get(time)` says, whether it has samples or, since OpenUSD has
# splines, a curve of knots. A lens goes from 20 to 80 mm within 24 frames, its focus from 2 to 10 m, its stop from 1 to
# 4; half way they are at 50 mm, 6 m and 2.5. A lamp goes from 10 to 100. What happens: Blender 5.3.0 makes keys of
# samples of cameras, and gives what has splines its value at the first frame, for good. The same camera turns by a
# spline as it should, so that the shot moves and does not zoom. Intensity and exposure of lamps stay as they were at
# the first frame, by samples and splines alike: lightning is a lamp, a fade to black stays bright. Nothing is said.
# Remedy: write samples of splines of cameras before (`Get` at each frame); keys of lamps by hand after.
# Versions: bpy 5.3.0, usd-core 26.11 (PyPI). Source: measured here;
# https://openusd.org/release/api/class_usd_attribute.html (GetSpline; Get at a time);
# https://docs.blender.org/manual/en/latest/files/import_export/usd.html
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv usd
usd/bin/pip install --quiet usd-core==26.11
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0
cat >write.py <<'END'
from pxr import Usd

STAGE = """#usda 1.0
(
    endTimeCode = 24
    metersPerUnit = 1
    startTimeCode = 0
    timeCodesPerSecond = 24
    upAxis = "Z"
)
def Camera "camera"
{
    float focalLength.%s
    float focusDistance.%s
    float fStop.%s
    double xformOp:rotateZ.%s
    uniform token[] xformOpOrder = ["xformOp:rotateZ"]
}
def SphereLight "lamp"
{
    float inputs:intensity.%s
}
def SphereLight "exposed"
{
    float inputs:exposure.%s
    float inputs:intensity = 10
}
"""
# A focal length of USD is in tenths of a unit of the stage.
CHANGES = [("/camera.focalLength", 0.2, 0.8), ("/camera.focusDistance", 2, 10), ("/camera.fStop", 1, 4),
           ("/camera.xformOp:rotateZ", 0, 90), ("/lamp.inputs:intensity", 10, 100), ("/exposed.inputs:exposure", 0, 2)]
for name, form in [("samples", "timeSamples = {\n        0: %g,\n        24: %g,\n    }"),
                   ("splines", "spline = {\n        0: %g; post linear,\n        24: %g; post linear,\n    }")]:
    with open(name + ".usda", "w") as file:
        file.write(STAGE % tuple(form % (first, last) for _, first, last in CHANGES))
    stage = Usd.Stage.Open(name + ".usda")
    for path, first, last in CHANGES:
        half_way = stage.GetAttributeAtPath(path).Get(12)
        if abs(half_way / ((first + last) / 2) - 1) > 1e-5:
            raise SystemExit("this has changed")
print("usd", ".".join(map(str, Usd.GetVersion())), "has all half way at frame 12, by samples and by splines")
END
usd/bin/python write.py
cat >read.py <<'END'
import math
import os

import bpy


def at(name, frame):
    """Focal length, focus, stop and turn of the camera; watts of both lamps."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.usd_import(filepath=os.path.abspath(name + ".usda"))
    bpy.context.scene.frame_set(frame)
    camera = next(thing for thing in bpy.data.objects if thing.type == "CAMERA")
    lamps = {thing.name: thing.data for thing in bpy.data.objects if thing.type == "LIGHT"}
    data = camera.data
    return [data.lens, data.dof.focus_distance, data.dof.aperture_fstop, math.degrees(camera.matrix_world.to_euler().z),
            lamps["lamp"].energy * 2**lamps["lamp"].exposure, lamps["exposed"].energy * 2**lamps["exposed"].exposure]


START = 10 * math.pi
for name, frame, wanted in [
    ("samples", 0, [20, 2, 1, 0, START, START]),
    ("samples", 12, [50, 6, 2.5, 45, START, START]),
    ("samples", 24, [80, 10, 4, 90, START, START]),
    ("splines", 0, [20, 2, 1, 0, START, START]),
    ("splines", 12, [20, 2, 1, 45, START, START]),
    ("splines", 24, [20, 2, 1, 90, START, START]),
]:
    found = at(name, frame)
    print("bpy", bpy.app.version_string, name, "at frame", frame,
          ": %.0f mm, focus at %.0f m, f/%.1f, turned by %.0f degrees; lamps of %.1f and %.1f W" % tuple(found),
          flush=True)
    if any(abs(one - other) > 0.01 for one, other in zip(found, wanted)):
        raise SystemExit("this has changed")
END
venv/bin/python read.py 2>&1 | grep "^bpy\|changed"
