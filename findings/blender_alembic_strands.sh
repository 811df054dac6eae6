#!/usr/bin/env bash
# Straight strands of Alembic lose two points in three in Blender, where the file has the basis that comes by itself.
#
# Expected: curves of the type `kLinear` run straight from point to point; a basis is for the type `kCubic`. A stem of
# seven points that goes up and to the side in steps of 0.1 m has seven points and is 0.6 m long. What happens: Blender
# 5.3.0 looks at the basis and not at the type. Alembic's own constructor of a sample, in C++ and in Python, has
# `kBezierBasis` where nobody names one. So Blender takes the points for knots with two handles between them: three are
# left, and the stem is a soft curve through them. With `kNoBasis` all seven are there, which is what Blender itself
# writes, so that a round trip shows nothing. Of a strand of five points two are left. The file is right by Alembic's
# reader. Nothing is said.
# Remedy: write linear curves with `kNoBasis`; or USD, whose `type` counts in Blender.
# Versions: bpy 5.3.0, bpy 5.0.1 has the same; alembic3d 1.8.12.1 (PyPI). Source: measured here;
# https://github.com/alembic/alembic (lib/Alembic/AbcGeom/OCurves.h, Sample: iBasis);
# https://projects.blender.org/blender/blender (source/blender/io/alembic/intern/abc_reader_curves.cc)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 alembic3d==1.8.12.1
cat >stems.py <<'END'
import gc

from alembic3d import Abc, AbcGeom
import imath

POINTS = [(0, 0, 0), (0, 0.1, 0), (0.1, 0.1, 0), (0.1, 0.2, 0), (0.2, 0.2, 0), (0.2, 0.3, 0), (0.3, 0.3, 0)]


def array(kind, values):
    made = kind(len(values))
    for index, value in enumerate(values):
        made[index] = value
    return made


def write(archive):
    for name, count, basis in [
        ("told", 7, AbcGeom.BasisType.kNoBasis), ("untold", 7, None), ("short", 5, None),
    ]:
        shape = [array(imath.V3fArray, [imath.V3f(*point) for point in POINTS[:count]]), array(imath.IntArray, [count])]
        more = {} if basis is None else {"iBasis": basis}
        strand = AbcGeom.OCurves(archive.getTop(), name)
        strand.getSchema().set(AbcGeom.OCurvesSchemaSample(*shape, iType=AbcGeom.CurveType.kLinear, **more))


write(Abc.OArchive("stems.abc"))
gc.collect()  # closes the file
top = Abc.IArchive("stems.abc").getTop()
for name, basis in ("told", "kNoBasis"), ("untold", "kBezierBasis"), ("short", "kBezierBasis"):
    found = AbcGeom.ICurves(top, name).getSchema().getValue()
    print("Alembic", name, found.getType(), found.getBasis(), len(found.getPositions()), "points", flush=True)
    if (str(found.getType()), str(found.getBasis())) != ("kLinear", basis):
        raise SystemExit("this has changed")
END
cat >look.py <<'END'
import os

import bpy

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.alembic_import(filepath=os.path.abspath("stems.abc"))
for name, wanted, right in ("told", 7, 0.6), ("untold", 3, 0.6), ("short", 2, 0.4):
    strand = bpy.data.objects[name]
    points = len(strand.data.points)
    bpy.ops.object.select_all(action="DESELECT")
    bpy.context.view_layer.objects.active = strand
    strand.select_set(True)
    bpy.ops.object.convert(target="MESH")
    drawn = [vertex.co for vertex in bpy.context.object.data.vertices]
    length = sum((one - other).length for one, other in zip(drawn, drawn[1:]))
    told = name + ": %d points, %.3f m long of %.1f" % (points, length, right)
    print("bpy", bpy.app.version_string, told, flush=True)
    if points != wanted or (abs(length - right) < 0.01) != (name == "told"):
        raise SystemExit("this has changed")
END
venv/bin/python stems.py
venv/bin/python look.py 2>&1 | grep "^bpy\|changed"
