#!/usr/bin/env bash
# Blender's openvdb takes every numpy array for one in C order: a grid from an array in Fortran order has x and z mixed.
#
# Expected: `copyFromArray` puts the element [i, j, k] of an array into the voxel (i, j, k), however the array lies in
# memory, as numpy's own functions do. What happens: it reads the memory in C order and passes over the strides. An array
# of 48 x 32 x 48 in Fortran order comes out with x and z exchanged, one of unequal sides as a hash of itself; nothing is
# said. `copyToArray` fills arrays likewise. Fortran order comes by itself: `numpy.load` keeps that of the file, and
# `transpose`, `.T` and MATLAB's files have it.
# Remedy: `copyFromArray(numpy.ascontiguousarray(array))`, and `copyToArray` into a fresh `numpy.zeros`.
# Versions: bpy 5.3.0 with numpy 2.5.5, bpy 5.0.1 has the same (PyPI). Source: measured here;
# https://www.openvdb.org/documentation/doxygen/python.html (Reading and writing arrays)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 numpy==2.5.5
cat >order.py <<'END'
import io

import bpy
import numpy as np

bpy.utils.expose_bundled_modules()
import openvdb

SIDE = 5
array = np.arange(1.0, SIDE**3 + 1, dtype=np.float32).reshape(SIDE, SIDE, SIDE)
stored = io.BytesIO()
np.save(stored, np.asfortranarray(array))
stored.seek(0)
loaded = np.load(stored)
assert np.array_equal(array, loaded) and loaded.flags.f_contiguous  # equal for numpy


def grid_of(values):
    grid = openvdb.FloatGrid(0.0)
    grid.copyFromArray(values)
    return grid


def voxels(grid):
    of = grid.getConstAccessor().getValue
    return np.array([[[of((i, j, k)) for k in range(SIDE)] for j in range(SIDE)] for i in range(SIDE)])


filled = {order: np.zeros_like(array, order=order) for order in "CF"}
for target in filled.values():
    grid_of(array).copyToArray(target)
found = {
    "from C": np.array_equal(voxels(grid_of(array)), array),
    "from Fortran": np.array_equal(voxels(grid_of(loaded)), array),
    "from Fortran, x and z exchanged": np.array_equal(voxels(grid_of(loaded)), array.transpose(2, 1, 0)),
    "to C": np.array_equal(filled["C"], array),
    "to Fortran": np.array_equal(filled["F"], array),
}
print("OpenVDB", openvdb.LIBRARY_VERSION, found)
assert list(found.values()) == [True, False, True, True, False], "changed"
END
venv/bin/python order.py 2>/dev/null
# Output seen (2026-11-29): OpenVDB (13, 0, 0) {'from C': True, 'from Fortran': False, 'from Fortran, x and z exchanged':
# True, 'to C': True, 'to Fortran': False}
