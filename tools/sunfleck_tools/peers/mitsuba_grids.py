"""Fog from a grid as Mitsuba's `gridvolume`. Blender's module `openvdb` reads the file."""

import mitsuba as mi
import numpy

from ..errors import SceneError
from .scene import FOG_GROWTH, Fog

CUBE_FROM_UNIT = numpy.array([[2, 0, 0, -1], [0, 2, 0, -1], [0, 0, 2, -1], [0, 0, 0, 1]], float)


def grid_fog(fog: Fog) -> tuple[numpy.ndarray, dict]:
    """Transform to the world from the cube [-1, 1]^3 around the grid, and the medium."""
    density, albedos, node_from_unit = _dense(fog)
    world_from_unit = fog.world_from_cube @ node_from_unit

    def volume(values: numpy.ndarray, factors: list[float]) -> dict:
        # Mitsuba has z outermost and x fastest, with colours innermost.
        colors = values.transpose(2, 1, 0, 3) * numpy.array(factors, numpy.float32)
        return {
            "type": "gridvolume",
            "grid": mi.VolumeGrid(numpy.ascontiguousarray(colors, numpy.float32)),
            "to_world": mi.ScalarTransform4f(world_from_unit),
            "filter_type": "trilinear",
            "wrap_mode": "clamp",
            "raw": True,
        }

    even = {"type": "constvolume", "value": {"type": "rgb", "value": fog.albedo}}
    medium = {
        "type": "heterogeneous",
        "sigma_t": volume(density, fog.density_per_m),
        "albedo": even if albedos is None else volume(albedos, fog.albedo),
        "phase": {"type": "hg", "g": fog.anisotropy},
    }
    return world_from_unit @ numpy.linalg.inv(CUBE_FROM_UNIT) @ FOG_GROWTH, medium


def _dense(fog: Fog) -> tuple[numpy.ndarray, numpy.ndarray | None, numpy.ndarray]:
    """Voxels with a margin of zeros, their colours if they have any, and the transform to the node's space
    from the unit cube that they fill."""
    assert fog.grid is not None, "whoever asks has seen a grid"
    path, name = fog.grid
    try:
        import bpy

        bpy.utils.expose_bundled_modules()
        import openvdb
    except ImportError as error:
        raise SceneError(f"{path}: Mitsuba gets grids by Blender's module ({error}): pip install bpy") from None
    try:
        grid = openvdb.read(str(path), name)
        low, high = (numpy.array(corner) for corner in grid.evalActiveVoxelBoundingBox())
    except (KeyError, OSError, RuntimeError, AttributeError) as error:
        raise SceneError(f"{path}: no grid `{name}` can be read: {error}") from None
    low, size = low - 1, high - low + 3
    values, colors = numpy.zeros(size, numpy.float32), None
    grid.copyToArray(values, ijk=tuple(map(int, low)))
    if fog.albedo_grid is not None:
        colors = numpy.zeros((*(size - 2), 3), numpy.float32)
        openvdb.read(str(path), fog.albedo_grid).copyToArray(colors, ijk=tuple(map(int, low + 1)))
        # Colours extend beyond the density.
        colors = numpy.pad(colors, [(1, 1)] * 3 + [(0, 0)], "edge")
    place = lambda voxel: numpy.array(grid.transform.indexToWorld(tuple(map(float, voxel))))
    first = low - 0.5
    node_from_unit = numpy.eye(4)
    node_from_unit[:3, 3] = place(first)
    for axis in range(3):
        node_from_unit[:3, axis] = place(first + size * numpy.eye(3)[axis]) - node_from_unit[:3, 3]
    return values[..., None], colors, node_from_unit
