#!/usr/bin/env bash
# Lamps that Blender exports to USD in centimetres are 10,000 times too dark, beside skies and suns that are right.
#
# Expected: *Units* of the export changes numbers, not the picture. A lamp of USD with `normalize` has the luminance
# `intensity` by its area in the world, which is in the stage's own units: 10,000 times as many where they are
# centimetres. So `intensity` grows by that factor, as radii, places and sizes do by theirs. What happens: Blender 5.3.0
# puts a scale of 100 on the root and writes the `intensity` of metres, 31.8 for 100 W. By the definition a point, a spot
# and a disk of 10 cm have 0.0001 of the light in centimetres, and 0.00065 in inches. A sun and what glows are the same,
# so that a scene of both is not the same picture darker. Blender's own import gives 100 W back, whatever the unit, so
# that nobody sees it there. Nothing is said.
# Remedy: export in metres; or multiply `inputs:intensity` of lamps but suns and domes by (1 / metersPerUnit) squared.
# Versions: bpy 5.3.0, usd-core 26.11 (PyPI). Source: measured here;
# https://openusd.org/release/api/class_usd_lux_light_a_p_i.html (normalize: by the surface area in world space);
# https://openusd.org/release/api/group___usd_geom_linear_units__group.html (metersPerUnit)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0
python3.13 -m venv usd
usd/bin/pip install --quiet usd-core==26.11
cat >lamps.py <<'END'
import os

import bpy

UNITS = ("METERS", "CENTIMETERS", "INCHES")
bpy.ops.wm.read_factory_settings(use_empty=True)
for kind in ("POINT", "SPOT", "AREA", "SUN"):
    lamp = bpy.data.lights.new(kind.lower(), kind)
    lamp.energy = 3 if kind == "SUN" else 100
    if kind == "AREA":
        lamp.shape, lamp.size = "DISK", 0.2
    elif kind != "SUN":
        lamp.shadow_soft_size = 0.1
    bpy.context.scene.collection.objects.link(bpy.data.objects.new(lamp.name, lamp))
for units in UNITS:
    bpy.ops.wm.usd_export(filepath=os.path.abspath(f"{units}.usda"), convert_scene_units=units)
for units in UNITS:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.usd_import(filepath=os.path.abspath(f"{units}.usda"))
    powers = sorted((lamp.name, round(lamp.energy, 2)) for lamp in bpy.data.lights)
    if powers != [("area", 100), ("point", 100), ("spot", 100), ("sun", 3)]:
        raise SystemExit("Blender's import of what it wrote has changed")
END
cat >look.py <<'END'
import math

from pxr import Gf, Usd, UsdGeom, UsdLux

luminances = {}
for units in ("METERS", "CENTIMETERS", "INCHES"):
    stage = Usd.Stage.Open(f"{units}.usda")
    for prim in filter(lambda prim: prim.HasAPI(UsdLux.LightAPI), stage.Traverse()):
        light = UsdLux.LightAPI(prim)
        luminance = light.GetIntensityAttr().Get() * 2 ** light.GetExposureAttr().Get()
        if not light.GetNormalizeAttr().Get():
            raise SystemExit("lamps are no longer normalized: this has changed")
        if not prim.IsA(UsdLux.DistantLight):
            matrix = UsdGeom.XformCache().GetLocalToWorldTransform(prim)
            radius = prim.GetAttribute("inputs:radius").Get() * matrix.TransformDir(Gf.Vec3d(1, 0, 0)).GetLength()
            luminance /= (4 if prim.IsA(UsdLux.SphereLight) else 1) * math.pi * radius**2
        luminances[prim.GetName(), units] = luminance
is_same = True
for name in ("point", "spot", "area", "sun"):
    for units, wanted in (("CENTIMETERS", 1e-4), ("INCHES", 0.0254**2)):
        ratio = luminances[name, units] / luminances[name, "METERS"]
        print(f"{name} in {units.lower()}: {ratio:.6f} of its luminance in metres")
        is_same &= math.isclose(ratio, 1 if name == "sun" else wanted, rel_tol=1e-3)
if not is_same:
    raise SystemExit("this has changed")
END
venv/bin/python lamps.py >/dev/null
usd/bin/python look.py
