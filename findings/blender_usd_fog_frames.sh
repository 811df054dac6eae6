#!/usr/bin/env bash
# Blender's USD import plays the files of fog one a frame from the first on, whatever frames the stage gives them.
#
# Expected: time samples of an `OpenVDBAsset`'s `filePath` say which file is shown from when on, and before the first
# and after the last sample the nearest one holds, as USD has it. What happens: Blender 5.3.0 looks at the first file and
# at the first and last sample, and counts on from there. A simulation on twos runs at double speed, and its fog is gone
# in the last frame; a loop of three files goes on with files that the stage never names; what plays backwards is there
# for one frame; before the first sample there is no fog. Files of consecutive numbers, one a frame, are right for as
# long as there are samples. Nothing is said.
# Remedy: copies or links of the files, numbered as frames, and a sample for every frame.
# Versions: bpy 5.3.0, usd-core 26.11, numpy 2.5.5; bpy 5.0.1 has the same (PyPI). Source: measured here;
# https://openusd.org/release/api/class_usd_vol_open_v_d_b_asset.html (filePath)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 usd-core==26.11 numpy==2.5.5
cat >cases.py <<'END'
# Which file from which frame on; files by USD in the frames 1 to 8, and by Blender, 0 where there is no fog.
CASES = {
    "ones": ({frame: frame for frame in range(1, 9)}, [1, 2, 3, 4, 5, 6, 7, 8], [1, 2, 3, 4, 5, 6, 7, 8]),
    "later": ({frame: frame - 2 for frame in range(3, 9)}, [1, 1, 1, 2, 3, 4, 5, 6], [0, 0, 1, 2, 3, 4, 5, 6]),
    "twos": ({1: 1, 3: 2, 5: 3, 7: 4}, [1, 1, 2, 2, 3, 3, 4, 4], [1, 2, 3, 4, 5, 6, 7, 0]),
    "loop": ({frame: (frame - 1) % 3 + 1 for frame in range(1, 9)}, [1, 2, 3, 1, 2, 3, 1, 2], [1, 2, 3, 4, 5, 6, 7, 8]),
    "backwards": ({frame: 9 - frame for frame in range(1, 9)}, [8, 7, 6, 5, 4, 3, 2, 1], [8, 0, 0, 0, 0, 0, 0, 0]),
}
END
cat >in_usd.py <<'END'
from cases import CASES
from pxr import Sdf, Usd, UsdGeom, UsdVol

for name, (samples, wanted, _) in CASES.items():
    stage = Usd.Stage.CreateNew(name + ".usda")
    UsdGeom.SetStageMetersPerUnit(stage, 1)
    UsdGeom.SetStageUpAxis(stage, "Z")
    stage.SetStartTimeCode(1)
    stage.SetEndTimeCode(8)
    volume = UsdVol.Volume.Define(stage, "/fog")
    stage.SetDefaultPrim(volume.GetPrim())
    field = UsdVol.OpenVDBAsset.Define(stage, "/fog/density")
    field.CreateFieldNameAttr("density")
    volume.CreateFieldRelationship("density", field.GetPath())
    for frame, file in samples.items():
        field.CreateFilePathAttr().Set(Sdf.AssetPath(f"fog.{100 + file:04d}.vdb"), frame)
    found = [int(field.GetFilePathAttr().Get(frame).path[4:8]) - 100 for frame in range(1, 9)]
    print("USD", Usd.GetVersion(), name, *found, flush=True)
    if found != wanted:
        raise SystemExit("this has changed")
    stage.Save()
END
cat >in_blender.py <<'END'
import glob
import os
import sys

import bpy
from cases import CASES

sys.path += glob.glob(sys.prefix + "/lib/python*/site-packages/bpy/*/python/lib/python*/site-packages")
import numpy as np
import openvdb

for file in range(1, 9):  # which is which is seen by how long the fog is: 8 m each
    grid = openvdb.FloatGrid()
    grid.copyFromArray(np.ones((8 * file, 8, 8), np.float32))
    grid.name = "density"
    openvdb.write(f"fog.{100 + file:04d}.vdb", grids=[grid])
for name, (_, _, wanted) in CASES.items():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.usd_import(filepath=os.path.abspath(name + ".usda"))
    fog = next(thing for thing in bpy.data.objects if thing.type == "VOLUME")
    found = []
    for frame in range(1, 9):
        bpy.context.scene.frame_set(frame)
        shown = fog.evaluated_get(bpy.context.evaluated_depsgraph_get())
        there = shown.data.grids.load() and len(shown.data.grids) > 0
        found.append(round((shown.bound_box[6][0] - shown.bound_box[0][0]) / 8) if there else 0)
    print("bpy", bpy.app.version_string, name, *found, flush=True)
    if found != wanted:
        raise SystemExit("this has changed")
END
venv/bin/python in_usd.py 2>&1 | grep "^USD\|changed"
venv/bin/python in_blender.py 2>&1 | grep "^bpy\|changed"
