"""The forest's floor: ground and ferns, metres. Invariant: y is up, and pieces of ground
meet without a gap."""

import math
import random

from mesh import Mesh, Vector, cross
from trees import along, unit

CELL_M, TILE_M = 3.0, 2.6
"""How wide a quad of the ground is, and the picture on it."""


def ground_height(x: float, z: float) -> float:
    """Gentle undulation, metres; about level around the origin."""
    away = min(1.0, math.hypot(x, z) / 12.0)
    waves = (
        0.22 * math.sin(0.31 * x + 0.6) * math.cos(0.27 * z)
        + 0.10 * math.sin(0.83 * x + 0.49 * z)
        + 0.06 * math.sin(1.1 * z)
    )
    banks = 0.9 * max(0.0, abs(x) - 6.0) / 14.0
    return away * waves + banks


def litter_position(x: float, z: float, tile_m: float) -> tuple[float, float]:
    """Where a point of the ground lies in the picture that repeats every `tile_m`: turned and swayed, so that
    no rows of it line up."""
    swayed_x = x + 1.9 * math.sin(0.21 * z + 0.9) + 1.1 * math.sin(0.13 * x - 0.37 * z)
    swayed_z = z + 1.7 * math.sin(0.24 * x + 0.4) + 1.2 * math.sin(0.31 * x + 0.17 * z)
    return ((0.83 * swayed_x + 0.56 * swayed_z) / tile_m, (0.56 * swayed_x - 0.83 * swayed_z) / tile_m)


def make_ground(left: float, right: float, near: float, far: float, cell_m: float, tile_m: float) -> Mesh:
    """A grid of quads `cell_m` wide, whole numbers of them; one texture tile is `tile_m` metres."""
    columns, rows = round((right - left) / cell_m), round((near - far) / cell_m)
    mesh = Mesh()
    for row in range(rows + 1):
        for column in range(columns + 1):
            x = left + cell_m * column
            z = near - cell_m * row
            mesh.positions.append((x, ground_height(x, z), z))
            mesh.uvs.append(litter_position(x, z, tile_m))
    width = columns + 1
    for row in range(rows):
        for column in range(columns):
            a = row * width + column
            mesh.faces.append((a, a + 1, a + width + 1, a + width))
    return mesh


def drift_height(x: float, z: float) -> float:
    """How high leaves lie above the ground, metres, and how far below it their floor is where none do: the
    wind's ridges, which sway and end."""
    along_wind = 1.15 * x + 0.9 * math.sin(0.55 * z + 0.4)
    across_wind = 1.7 * z + 0.8 * math.sin(0.6 * x)
    across_both = 2.3 * x - 1.9 * z + math.sin(1.3 * z)
    ridges = math.sin(along_wind) * math.cos(across_wind) + 0.5 * math.sin(across_both)
    return 0.11 * (ridges - 0.15)


def laid_height(x: float, z: float) -> float:
    """Height of the ground as it is laid, in triangles of `CELL_M`."""
    left, near = CELL_M * math.floor(x / CELL_M), CELL_M * math.ceil(z / CELL_M)
    u, v = (x - left) / CELL_M, (near - z) / CELL_M
    first, last = ground_height(left, near), ground_height(left + CELL_M, near - CELL_M)
    corner = ground_height(left + CELL_M, near) if u >= v else ground_height(left, near - CELL_M)
    return first + (corner - first) * max(u, v) + (last - corner) * min(u, v)


def make_drifts(left: float, right: float, near: float, far: float, cell_m: float) -> Mesh:
    """What of a grid of quads stands out of the ground; its rim lies below, so that no border is seen."""
    mesh = make_ground(left, right, near, far, cell_m, TILE_M)
    heights = [drift_height(x, z) for x, _, z in mesh.positions]
    mesh.positions = [(x, laid_height(x, z) + up, z) for (x, _, z), up in zip(mesh.positions, heights)]
    mesh.faces = [face for face in mesh.faces if any(heights[i] > 0.0 for i in face)]
    return mesh.without_strays()


def make_fern(seed: str, fronds: int, length_m: float, pinnae: int) -> Mesh:
    """A fern: fronds that arch outward, each with two rows of narrow pinnae; texture
    coordinates lie on one leaf."""
    rng = random.Random(seed)
    mesh = Mesh()
    for f in range(fronds):
        turn = math.tau * (f + rng.uniform(-0.3, 0.3)) / fronds
        out: Vector = (math.cos(turn), 0.0, math.sin(turn))
        length, rise = length_m * rng.uniform(0.7, 1.1), rng.uniform(0.75, 1.25)
        across = unit(cross((0.0, 1.0, 0.0), out))
        roll = rng.uniform(-0.25, 0.25)

        def rachis(t: float) -> Vector:
            far = 0.2 * t + 0.7 * t * t
            return (out[0] * length * far, length * rise * (t - 0.62 * t * t), out[2] * length * far)

        for i in range(pinnae):
            t = 0.16 + 0.84 * i / pinnae
            base, ahead = rachis(t), rachis(min(1.0, t + 0.08))
            forward = unit(tuple(b - a for a, b in zip(base, ahead)))
            reach = length * 0.26 * math.sin(math.pi * (0.12 + 0.88 * t) ** 1.3) + 0.01
            width = length * 0.42 / pinnae
            for side in (1.0, -1.0):
                ahead_x, ahead_z = (side * across[i] + 0.45 * forward[i] for i in (0, 2))
                outward = unit((ahead_x, side * roll - 0.25, ahead_z))
                tip = along(base, outward, reach * rng.uniform(0.85, 1.1))
                middle = along(base, outward, reach * 0.45)
                first = len(mesh.positions)
                mesh.positions += [base, along(middle, forward, width), tip, along(middle, forward, -width)]
                mesh.uvs += [(0.5, 0.42), (0.56, 0.55), (0.5, 0.72), (0.44, 0.55)]
                corners = (first, first + 1, first + 2, first + 3)
                mesh.faces.append(corners if side < 0 else corners[::-1])
    return mesh
