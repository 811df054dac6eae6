#!/usr/bin/env bash
# Colours of leaves from Alembic are too dark in Blender, and never above 1: it takes linear light for sRGB, in bytes.
#
# Expected: colours of Alembic are floats, and as light they may be of any size. A tint of (0.2, 0.5, 2.5) for each leaf
# comes back as it was. What happens: with *Color Attributes* Blender 5.3.0 writes *Color* of floats as it is, so linear,
# and bytes as their codes, so sRGB, with nothing in the file to tell them apart. Its import makes bytes of all, and takes
# them for sRGB: 0.033, 0.216 and 1. Linear colours of other programs go the same way; wetness and other shares that
# travel as colours are squeezed as well. Bytes come back as they were, so that painted colours show nothing. By USD
# floats come back as they were too. Nothing is said.
# Remedy: store tints as *Byte Color* before the export; or after import apply sRGB's encoding to the colour, in a
# shader by a *Gamma* node of 1 / 2.2, for what was at most 1.
# Versions: bpy 5.3.0 (PyPI). Source: measured here;
# https://projects.blender.org/blender/blender (source/blender/io/alembic/intern/abc_customdata.cc)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0
cat >tints.py <<'END'
import bpy

TINT = (0.2, 0.5, 2.5, 1)


def round_trip(kind, by):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    mesh = bpy.data.meshes.new("Leaf")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    for point in mesh.color_attributes.new("Tint", kind, "CORNER").data:
        point.color = TINT
    before = list(mesh.color_attributes["Tint"].data[0].color)[:3]
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("Leaf", mesh))
    if by == "Alembic":
        bpy.ops.wm.alembic_export(filepath="leaf.abc", as_background_job=False, vcolors=True)
        bpy.ops.wm.read_factory_settings(use_empty=True)
        bpy.ops.wm.alembic_import(filepath="leaf.abc", as_background_job=False)
    else:
        bpy.ops.wm.usd_export(filepath="leaf.usdc")
        bpy.ops.wm.read_factory_settings(use_empty=True)
        bpy.ops.wm.usd_import(filepath="leaf.usdc")
    [mesh] = [thing.data for thing in bpy.context.scene.objects if thing.type == "MESH"]
    tint = mesh.color_attributes["Tint"]
    return before, tint.data_type, [round(number, 3) for number in tint.data[0].color[:3]]


for kind, by, wanted in [
    ("FLOAT_COLOR", "USD", (0.2, 0.5, 2.5)), ("FLOAT_COLOR", "Alembic", (0.033, 0.216, 1)), ("BYTE_COLOR", "Alembic", None),
]:
    before, after, found = round_trip(kind, by)
    print("Blender", bpy.app.version_string, kind, [round(number, 3) for number in before], "by", by, "is", after, found, flush=True)
    if max(abs(one - other) for one, other in zip(found, wanted or before)) > 0.005:
        raise SystemExit("this has changed")
END
venv/bin/python tints.py 2>&1 | grep "^Blender\|changed"
