#!/usr/bin/env bash
# A camera whose sensor fits the height sees less once Blender has exported it to Alembic.
#
# Expected: a file of a camera says what the picture shows. A lens of 50 mm on a sensor of 24 mm, *Sensor Fit* at
# *Vertical*, sees 46.2 x 27.0 degrees at 16:9. What happens: Blender 5.3.0 writes 36 and 24 mm, both fields of the
# sensor as they are, whichever counts, and nothing of the fit or of the shape of the picture. Its import has *Auto*:
# 39.6 x 22.9 degrees. Upright pictures by *Horizontal* go from 65.2 degrees of height to 39.6, and by *Vertical* from
# 27.0. Cameras of *Auto*, the default, are right. By USD all are right, as its export fits the sensor to the picture.
# Nothing is said.
# Remedy: before export *Auto*, with a sensor of width = 24 mm * 16 / 9 for this one (upright: of the height); or USD.
# Versions: bpy 5.3.0 (PyPI). Source: measured here;
# https://docs.blender.org/manual/en/latest/render/cameras.html (Sensor Fit);
# https://projects.blender.org/blender/blender (source/blender/io/alembic/exporter/abc_writer_camera.cc)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0
cat >fit.py <<'END'
import math

import bpy

WIDE, UPRIGHT = (1920, 1080), (1080, 1920)


def scene(size):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    made = bpy.context.scene
    made.render.resolution_x, made.render.resolution_y = size
    return made


def angles(camera, size):
    """Degrees that the picture shows, across and up."""
    bpy.context.view_layer.update()
    lens = camera.calc_matrix_camera(bpy.context.evaluated_depsgraph_get(), x=size[0], y=size[1])
    return [round(math.degrees(2 * math.atan(1 / lens[axis][axis])), 1) for axis in (0, 1)]


def round_trip(fit, size, by):
    within = scene(size)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.data.lens, camera.data.sensor_fit = 50, fit
    within.collection.objects.link(camera)
    before = angles(camera, size)
    if by == "Alembic":
        bpy.ops.wm.alembic_export(filepath="camera.abc", as_background_job=False)
        scene(size)
        bpy.ops.wm.alembic_import(filepath="camera.abc", as_background_job=False)
    else:
        bpy.ops.wm.usd_export(filepath="camera.usda")
        scene(size)
        bpy.ops.wm.usd_import(filepath="camera.usda")
    [again] = [thing for thing in bpy.context.scene.objects if thing.type == "CAMERA"]
    return before, angles(again, size)


for fit, size, wanted in [
    ("AUTO", WIDE, (39.6, 22.9)), ("AUTO", UPRIGHT, (22.9, 39.6)), ("VERTICAL", WIDE, (39.6, 22.9)),
    ("HORIZONTAL", UPRIGHT, (22.9, 39.6)), ("VERTICAL", UPRIGHT, (22.9, 39.6)),
]:
    for by in ("USD", "Alembic"):
        before, after = round_trip(fit, size, by)
        print("Blender", bpy.app.version_string, fit, size, "sees", *before, "degrees, by", by, *after, flush=True)
        for one, other in zip(after, before if by == "USD" else wanted):
            if abs(one - other) > 0.15:
                raise SystemExit("this has changed")
END
venv/bin/python fit.py 2>&1 | grep "^Blender\|changed"
