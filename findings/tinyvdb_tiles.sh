#!/usr/bin/env bash
# Clouds are hollow in tinyvdb, and even fog is not there: it drops what OpenVDB keeps as tiles.
#
# Expected: in OpenVDB blocks of one value, of 8 voxels a side and more, are tiles, active like any voxel. OpenVDB makes
# them by itself: `copyFromArray` of a cube of 36 voxels of density 0.1 has leaves at three of its sides, and tiles. All
# of its 46656 voxels are active, and exp(-3.6) = 0.027 of the light comes through the middle. What happens: tinyvdb
# 0.9.0, which reads OpenVDB without OpenVDB, leaves tiles out of `to_sparse` and `materialize_dense`: 13888 voxels are
# left, light meets 4 of 36, and 0.67 comes through. A cube of 32 voxels of even fog has no voxel. Inside of a level set
# values are 0 instead of below 0, so that a ball of 20 voxels has 38 % of its volume. The file's own count, in
# `metadata`, is right; what is saved again has its tiles, so that a round trip shows nothing. Nothing is said.
# Remedy: compare with `file_voxel_count`; `voxelizeActiveTiles` of OpenVDB in C++ before the file is written.
# Versions: tinyvdb 0.9.0, bpy 5.3.0 with numpy 2.5.5, whose openvdb is 13.0 (PyPI). Source: measured here, with OpenVDB
# for the truth; https://github.com/syoyo/tinyvdb; https://www.openvdb.org/documentation/doxygen/overview.html (tiles);
# Museth 2013, VDB: high-resolution sparse volumes with dynamic topology
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 numpy==2.5.5 tinyvdb==0.9.0
cat >write.py <<'END'
import bpy
import numpy as np

bpy.utils.expose_bundled_modules()
import openvdb


def check(name, count, value, wanted):
    print("OpenVDB of bpy", bpy.app.version_string, name, f"has {count} active, {value:.2f} in the middle", flush=True)
    if count != wanted[0] or abs(value - wanted[1]) > 1e-6:
        raise SystemExit("this has changed")


ramp = np.arange(1, 8**3 + 1, dtype=np.float32).reshape(8, 8, 8) / 5120
for name, array, wanted in (
    ("uneven", ramp, (512, ramp[4, 4, 4])), ("cube", np.full([36] * 3, 0.1, np.float32), (46656, 0.1)),
    ("block", np.full([32] * 3, 0.1, np.float32), (32768, 0.1)),
):
    grid = openvdb.FloatGrid()
    grid.name, grid.gridClass = "density", openvdb.GridClass.FOG_VOLUME
    grid.copyFromArray(array)
    check(name, grid.activeVoxelCount(), grid.getConstAccessor().getValue((len(array) // 2,) * 3), wanted)
    openvdb.write(name + ".vdb", grids=[grid])
ball = openvdb.createLevelSetSphere(radius=20.0, voxelSize=1.0)
check("ball", ball.activeVoxelCount(), ball.getConstAccessor().getValue((0, 0, 0)), (ball.activeVoxelCount(), -3))
openvdb.write("ball.vdb", grids=[ball])
END
cat >read.py <<'END'
import math

import numpy as np
import tinyvdb


def read(name, low, high):
    file = tinyvdb.open(name + ".vdb")
    file.read_grids()
    grid = file.grid(0)
    dense = grid.materialize_dense((low,) * 3, (high,) * 3)
    array = np.frombuffer(dense, np.float32).reshape(dense.shape)
    return grid.metadata["file_voxel_count"], grid.to_sparse()["count"], dense, array


def check(told, found, wanted):
    print("tinyvdb 0.9.0", told, flush=True)
    if any(abs(one - other) > 1e-3 * abs(other) + 1e-6 for one, other in zip(found, wanted)):
        raise SystemExit("this has changed")


for name, side, sparse_wanted, through_wanted in (
    ("uneven", 8, 512, None), ("cube", 36, 13888, math.exp(-0.4)), ("block", 32, 0, 1),
):
    by_file, sparse, _, array = read(name, 0, side)
    through = math.exp(-float(array[side // 2, side // 2].sum()))  # along x, which is the last axis here
    if through_wanted is None:
        through_wanted = math.exp(-float((64 * np.arange(8) + 37).sum()) / 5120)
    filled = np.count_nonzero(array)
    told = f"{name}: {by_file} voxels by the file, {sparse} in to_sparse, {filled} in materialize_dense;"
    check(f"{told} light through the middle {through:.3f}", [sparse, filled, through],
          [sparse_wanted, sparse_wanted, through_wanted])
_, _, dense, array = read("ball", -24, 25)
volume, right = tinyvdb.volume(dense), 4 / 3 * math.pi * 20**3
check(f"ball: {array[24, 24, 24]:.1f} in the middle, volume {volume:.0f} of {right:.0f}", [array[24, 24, 24], volume],
      [0, 12892])
END
venv/bin/python write.py 2>&1 | grep "^OpenVDB\|changed\|Error"
venv/bin/python read.py
