"""Writes the OpenVDB files of this folder, with the `openvdb` that Blender 5.0.1 brings:

    python tests/data/vdb/make.py        # where `import bpy` works

`several.vdb`: `density` has numbers along a line in i, j and k, and a block of .75; `heat` is the same in half
floats; `velocity` holds vectors; `nothing` has no voxels. `billion.vdb`: 1024^3 voxels of .5, as tiles. `thin.vdb`:
12 x 6 x 9 voxels of .25 where the lines of `several.vdb` are. `colours.vdb`: the same, with colours (.25, .5, 1) in
`Cd`. `moving.1.vdb` and `moving.2.vdb`: a block of 4 voxels, 8 voxels of half a metre apart, and their velocity of 96
metres a second in `vel`; `split.1.vdb`, `split.2.vdb`, `staggered.1.vdb` and `staggered.2.vdb`: the same, by a grid
an axis and on the faces of voxels. `numbers.vdb`: ten voxels along i, of 1 to 10, in every kind of number.
"""

from pathlib import Path

import bpy

bpy.utils.expose_bundled_modules()
import openvdb

HERE = Path(__file__).parent


def lines(name, is_half):
    grid = openvdb.FloatGrid()
    grid.name = name
    grid.gridClass = openvdb.GridClass.FOG_VOLUME
    accessor = grid.getAccessor()
    for i in range(-2, 9):
        for j in range(3):
            for k in range(0, 10, 3):
                accessor.setValueOn((i, j, k), 2.25 + i * 0.5 + j * 0.0625 + k * 0.125)
    grid.fill((200, 200, 200), (215, 207, 207), 0.75, True)
    grid.saveFloatAsHalf = is_half
    rows = [[0, 0.5, 0, 0], [-0.25, 0, 0, 0], [0, 0, 0.125, 0], [1, 2, 3, 1]]
    grid.transform = openvdb.createLinearTransform(rows)
    return grid


velocity = openvdb.Vec3SGrid()
velocity.name = "velocity"
velocity.fill((0, 0, 0), (3, 3, 3), (1.0, 0.0, 0.0), True)
nothing = openvdb.FloatGrid()
nothing.name = "nothing"
grids = [lines("density", False), lines("heat", True), velocity, nothing]
openvdb.write(str(HERE / "several.vdb"), grids)

billion = openvdb.FloatGrid()
billion.name = "density"
billion.fill((0, 0, 0), (1023, 1023, 1023), 0.5, True)
billion.prune()
openvdb.write(str(HERE / "billion.vdb"), billion)

thin = openvdb.FloatGrid()
thin.name = "density"
thin.fill((-2, -1, 0), (9, 4, 8), 0.25, True)
thin.transform = lines("density", False).transform
openvdb.write(str(HERE / "thin.vdb"), thin)

colours = openvdb.Vec3SGrid()
colours.name = "Cd"
colours.fill((-2, -1, 0), (9, 4, 8), (0.25, 0.5, 1.0), True)
colours.transform = thin.transform
openvdb.write(str(HERE / "colours.vdb"), [thin, colours])

for number in (1, 2):
    block = openvdb.FloatGrid()
    block.name = "density"
    block.fill((8 * number, 0, 0), (8 * number + 3, 3, 3), 1.0, True)
    velocity = openvdb.Vec3SGrid()
    velocity.name = "vel"
    velocity.fill((-16, -16, -16), (47, 15, 15), (96.0, 0.0, 0.0), True)
    axes = [openvdb.FloatGrid() for _ in "xyz"]
    for grid, axis, speed in zip(axes, "xyz", (96.0, 0.0, 0.0)):
        grid.name = f"vel_{axis}"
        grid.fill((0, 0, 0), (31, 7, 7), speed, True)
    for grid in (block, velocity, *axes):
        grid.transform = openvdb.createLinearTransform(0.5)
    openvdb.write(str(HERE / f"moving.{number}.vdb"), [block, velocity])
    openvdb.write(str(HERE / f"split.{number}.vdb"), [block, *axes])
    faces = openvdb.Vec3SGrid()
    faces.name, faces.gridClass, faces.transform = "vel", openvdb.GridClass.STAGGERED, velocity.transform
    faces.fill((0, 0, 0), (31, 7, 7), (96.0, 0.0, 0.0), True)
    openvdb.write(str(HERE / f"staggered.{number}.vdb"), [block, faces])

kinds = []
for kind, is_half in (("Float", False), ("Double", False), ("Double", True), ("Int32", False), ("Int64", False)):
    grid = getattr(openvdb, f"{kind}Grid")()
    grid.name, grid.saveFloatAsHalf = f"{kind}, half" if is_half else kind, is_half
    accessor = grid.getAccessor()
    for i in range(10):
        accessor.setValueOn((i, 0, 0), i + 1)
    kinds.append(grid)
vectors = openvdb.Vec3DGrid()
vectors.name = "Vec3D"
accessor = vectors.getAccessor()
for i in range(10):
    accessor.setValueOn((i, 0, 0), (i + 1.0, 2.0 * i, -1.0))
openvdb.write(str(HERE / "numbers.vdb"), [*kinds, vectors])
