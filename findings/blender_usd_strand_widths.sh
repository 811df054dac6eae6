#!/usr/bin/env bash
# Grass of USD with a width a blade: Blender gives them to the points of the first blades, and all others are alike.
#
# Expected: `widths` of `BasisCurves` with the interpolation `uniform` has one value a curve. A hundred blades of three
# points, from 1 mm for the first to 100 mm for the last, each as wide at its root as at its tip. What happens: Blender
# 5.3.0 takes the values one a point, in the order of the file. The first blade is 1, 2 and 3 mm wide, the 33rd 97, 98
# and 99, and from the second point of the 34th on all are 20 mm wide; 5.0.1 has a width of 0 there. `linear` and
# `catmullRom` are alike. A single width for all (`constant`) is right, and so is one for each point (`vertex`), so
# that Blender's own exports show nothing. `UsdGeom` counts what it was given as `uniform`. Nothing is said.
# Remedy: before import each width as often as its curve has points, with the interpolation `vertex`.
# Versions: bpy 5.3.0 and 5.0.1, usd-core 26.11 (PyPI). Source: measured here;
# https://openusd.org/release/api/class_usd_geom_basis_curves.html (Primvar Interpolation);
# https://openusd.org/release/api/class_usd_geom_curves.html (widths)
# Needs python3.13 and python3.11 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
python3.11 -m venv older
venv/bin/pip install --quiet bpy==5.3.0 usd-core==26.11
older/bin/pip install --quiet bpy==5.0.1
cat >in_usd.py <<'END'
from pxr import Usd, UsdGeom

BLADES, POINTS = 100, 3
stage = Usd.Stage.CreateNew("grass.usda")
UsdGeom.SetStageUpAxis(stage, "Z")
UsdGeom.SetStageMetersPerUnit(stage, 1)
each = [0.001 * (blade + 1) for blade in range(BLADES)]
for kind, basis, widths, interpolation in [
    ("linear", None, each, "uniform"), ("catmullRom", "catmullRom", each, "uniform"), ("one", None, [0.05], "constant"),
    ("points", None, [width for width in each for _ in range(POINTS)], "vertex"),
]:
    grass = UsdGeom.BasisCurves.Define(stage, "/" + kind)
    grass.CreateTypeAttr("cubic" if basis else "linear")
    if basis:
        grass.CreateBasisAttr(basis)
        grass.CreateWrapAttr("pinned")
    grass.CreateCurveVertexCountsAttr([POINTS] * BLADES)
    grass.CreatePointsAttr([(0.1 * blade, 0, 0.1 * point) for blade in range(BLADES) for point in range(POINTS)])
    grass.CreateWidthsAttr(widths)
    grass.SetWidthsInterpolation(interpolation)
    found = grass.ComputeInterpolationForSize(len(widths), Usd.TimeCode.Default())
    print("USD", Usd.GetVersion(), kind, "has", len(widths), "widths:", found, flush=True)
    if interpolation != "vertex" and found != interpolation:
        raise SystemExit("this has changed")
stage.Save()
END
cat >in_blender.py <<'END'
import os

import bpy
import numpy as np

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.usd_import(filepath=os.path.abspath("grass.usda"))
each = np.arange(1.0, 101.0)
right = np.repeat(each, 3).reshape(-1, 3)
shifted = np.full(300, 20.0 if bpy.app.version >= (5, 3) else 0.0)
shifted[:100] = each
for kind, wanted in [
    ("linear", shifted), ("catmullRom", shifted), ("one", np.full(300, 50.0)), ("points", right.ravel()),
]:
    radii = bpy.data.objects[kind].data.attributes["radius"].data
    found = np.array([2000.0 * point.value for point in radii]).reshape(-1, 3)
    blades = "; ".join("the %s %.0f %.0f %.0f" % (name, *found[number]) for name, number in (
        ("1st", 0), ("33rd", 32), ("34th", 33), ("100th", 99)))
    print("bpy", bpy.app.version_string, kind + ", mm:", blades, flush=True)
    if np.abs(found - wanted.reshape(-1, 3)).max() > 0.01:
        raise SystemExit("this has changed")
END
venv/bin/python in_usd.py 2>&1 | grep "^USD\|changed"
for blender in venv older; do
    "$blender/bin/python" in_blender.py 2>&1 | grep "^bpy\|changed"
done
