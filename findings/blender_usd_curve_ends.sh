#!/usr/bin/env bash
# Blender's USD import passes over how curves end: Catmull-Rom strands grow by two segments, B-splines stop short.
#
# Expected: `wrap` of `BasisCurves` says whether a curve reaches its first and last point. `nonperiodic`, which is what
# counts where nothing is said, runs a Catmull-Rom or B-spline curve of 4 points from the second to the third only, one
# segment; `pinned` runs both from the first to the last, three. What happens: Blender 5.3.0 reads all Catmull-Rom curves
# as pinned, and all B-splines as not. Grass or hair of 4 points from x = 0 to 3 that should be there from 1 to 2 is
# three times as long, and a pinned B-spline a third as long. Blender's own export pins, so a round trip shows nothing.
# Remedy: before import take the first and last point from nonperiodic Catmull-Rom curves where they matter, or write
# curves as `linear` or `bezier`, which are right.
# Versions: bpy 5.3.0, usd-core 26.11; bpy 5.0.1 has the same (PyPI). Source: measured here;
# https://openusd.org/release/api/class_usd_geom_basis_curves.html (Wrap, segment counts)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 usd-core==26.11
cat >cases.py <<'END'
# Basis and wrap; segments by USD; where a curve of the points (0 .. 3, 0, 0) is in x by Blender.
CASES = [
    ("catmullRom", "nonperiodic", 1, (0, 3)), ("catmullRom", "pinned", 3, (0, 3)),
    ("bspline", "nonperiodic", 1, (1, 2)), ("bspline", "pinned", 3, (1, 2)), ("bezier", "nonperiodic", 1, (0, 3)),
]
END
cat >in_usd.py <<'END'
from cases import CASES
from pxr import Usd, UsdGeom

for basis, wrap, segments, _ in CASES:
    stage = Usd.Stage.CreateNew(f"{basis}_{wrap}.usda")
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.SetStageMetersPerUnit(stage, 1)
    strand = UsdGeom.BasisCurves.Define(stage, "/strand")
    stage.SetDefaultPrim(strand.GetPrim())
    strand.CreateTypeAttr("cubic")
    strand.CreateBasisAttr(basis)
    strand.CreateWrapAttr(wrap)
    strand.CreateCurveVertexCountsAttr([4])
    strand.CreatePointsAttr([(x, 0, 0) for x in range(4)])
    strand.CreateWidthsAttr([0.01])
    strand.SetWidthsInterpolation("constant")
    found = list(strand.ComputeSegmentCounts(Usd.TimeCode.Default()))
    print("USD", Usd.GetVersion(), basis, wrap, "has", *found, "segments", flush=True)
    if found != [segments]:
        raise SystemExit("this has changed")
    stage.Save()
END
cat >in_blender.py <<'END'
import os

import bpy
from cases import CASES

for basis, wrap, _, ends in CASES:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.usd_import(filepath=os.path.abspath(f"{basis}_{wrap}.usda"))
    strand = next(thing for thing in bpy.data.objects if thing.type == "CURVES")
    bpy.context.view_layer.objects.active = strand
    strand.select_set(True)
    bpy.ops.object.convert(target="MESH")
    x = [vertex.co.x for vertex in bpy.context.object.data.vertices]
    print("bpy", bpy.app.version_string, basis, wrap, "from %.2f to %.2f" % (min(x), max(x)), flush=True)
    if abs(min(x) - ends[0]) + abs(max(x) - ends[1]) > 0.01:
        raise SystemExit("this has changed")
END
venv/bin/python in_usd.py 2>&1 | grep "^USD\|changed"
venv/bin/python in_blender.py 2>&1 | grep "^bpy\|changed"
