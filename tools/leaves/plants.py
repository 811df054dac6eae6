"""Trees, boughs and ground: seeds in, meshes in metres out. Invariant: y is up, roots at y = 0."""

import math
import random

from mesh import Mesh, Vector, cross, subtract
from triangulate import clip_ears, flip_to_delaunay


def unit(a: Vector) -> Vector:
    """`a` at length 1."""
    length = math.hypot(*a)
    return (a[0] / length, a[1] / length, a[2] / length)


def along(a: Vector, direction: Vector, distance: float) -> Vector:
    """a + direction * distance."""
    return (a[0] + direction[0] * distance, a[1] + direction[1] * distance, a[2] + direction[2] * distance)


def tube(path: list[Vector], radii: list[float], sides: int, uv_scale: tuple[float, float]) -> Mesh:
    """A tapered pipe along a path, closed at its far end; u runs `uv_scale[0]` times around, v in metres / `uv_scale[1]`."""
    mesh = Mesh()
    right: Vector = (1.0, 0.0, 0.0)
    travelled = 0.0
    for ring, (center, radius) in enumerate(zip(path, radii)):
        before, after = path[max(ring - 1, 0)], path[min(ring + 1, len(path) - 1)]
        axis = unit(subtract(after, before))
        if abs(sum(a * r for a, r in zip(axis, right))) > 0.95:
            right = (0.0, 0.0, 1.0)
        side = unit(cross(axis, right))
        right = cross(side, axis)  # Carried from ring to ring, so that the pipe does not twist.
        travelled += math.dist(before, center) if ring else 0.0
        for k in range(sides + 1):
            angle = math.tau * k / sides
            rim = along(along(center, right, radius * math.cos(angle)), side, -radius * math.sin(angle))
            mesh.positions.append(rim)
            mesh.uvs.append((uv_scale[0] * k / sides, travelled / uv_scale[1]))
    row = sides + 1
    for ring in range(len(path) - 1):
        for k in range(sides):
            a = ring * row + k
            mesh.faces.append((a, a + row, a + row + 1, a + 1))
    last = (len(path) - 1) * row
    mesh.faces.append(tuple(last + k for k in reversed(range(sides))))
    return mesh


def wander(start: Vector, direction: Vector, length: float, steps: int, bend: float, lift: float, rng: random.Random) -> list[Vector]:
    """A crooked path that turns by about `bend` a step and towards the sky by `lift`."""
    path = [start]
    for _ in range(steps):
        direction = unit(
            (
                direction[0] + rng.uniform(-bend, bend),
                direction[1] + rng.uniform(-bend, bend) * 0.5 + lift,
                direction[2] + rng.uniform(-bend, bend),
            )
        )
        path.append(along(path[-1], direction, length / steps))
    return path


def make_tree(seed: str, height: float, girth: float, branch_count: int) -> Mesh:
    """A bare tree: a bent trunk with a flare at the roots, and crooked branches above a third of its height."""
    rng = random.Random(seed)
    steps = 11
    path = wander((0.0, -0.3, 0.0), (rng.uniform(-0.1, 0.1), 1.0, rng.uniform(-0.1, 0.1)), height, steps, 0.10, 0.10, rng)
    radii = [girth * (1.0 - 0.88 * i / steps) * (1.55 if i == 0 else 1.0) for i in range(steps + 1)]
    mesh = tube(path, radii, 8, (2.0, 2.5))
    for i in range(branch_count):
        ring = 4 + i * (steps - 5) // branch_count
        angle = i * 2.4 + rng.uniform(-0.4, 0.4)  # About the golden angle, so that branches spread.
        outward = unit((math.cos(angle), rng.uniform(0.25, 0.6), math.sin(angle)))
        length = height * rng.uniform(0.20, 0.34) * (1.2 - 0.6 * ring / steps)
        branch = wander(path[ring], outward, length, 4, 0.32, 0.10, rng)
        mesh.add(tube(branch, [radii[ring] * 0.42 * (1.0 - 0.85 * k / 4) for k in range(5)], 4, (1.0, 2.5)))
        turn = angle + rng.choice((-0.9, 0.9))
        twig = wander(branch[2], unit((math.cos(turn), 0.35, math.sin(turn))), length * 0.5, 3, 0.35, 0.08, rng)
        mesh.add(tube(twig, [radii[ring] * 0.16 * (1.0 - 0.8 * k / 3) for k in range(4)], 3, (1.0, 2.5)))
    return mesh


def transformed(mesh: Mesh, turn: list[Vector], size: float, offset: Vector) -> Mesh:
    """The mesh with its x, y, z axes along `turn`, scaled and moved."""

    def place(p: Vector) -> Vector:
        return tuple(size * sum(p[k] * turn[k][i] for k in range(3)) + offset[i] for i in range(3))

    return Mesh([place(p) for p in mesh.positions], list(mesh.uvs), list(mesh.faces))


def make_bough(leaf: Mesh, seed: str, length: float, twig_count: int, leaf_count: int, leaf_size: float) -> Mesh:
    """A leafy bough along +z about the origin, coarse enough to stand in the light by the dozen.

    Its twigs take the colour of the edge of the leaf's picture, so one material serves all.
    """
    rng = random.Random(seed)
    stem = wander((0.0, 0.0, -length / 2), (0.0, 0.1, 1.0), length, 4, 0.25, 0.0, rng)
    twigs = [stem]
    for k in range(twig_count):
        angle = rng.uniform(-0.5, 0.5) + (0.9 if k % 2 else -0.9)
        start = stem[1 + k * 3 // twig_count]
        outward = unit((math.sin(angle), rng.uniform(-0.15, 0.35), math.cos(angle)))
        twigs.append(wander(start, outward, length * rng.uniform(0.25, 0.42), 1, 0.3, 0.0, rng))
    mesh = Mesh()
    for twig in twigs:
        thickness = 0.010 * length if twig is stem else 0.005 * length
        bark = tube(twig, [thickness * (1 - 0.8 * i / len(twig)) for i in range(len(twig))], 3, (1.0, 1.0))
        bark.uvs = [(0.04, 0.5)] * len(bark.positions)
        mesh.add(bark)
    for _ in range(leaf_count):
        twig = rng.choice(twigs[1:] + [stem])
        k = rng.randrange(len(twig) - 1)
        t = rng.random()
        spot = tuple(a + (b - a) * t + rng.gauss(0, 0.045 * length) for a, b in zip(twig[k], twig[k + 1]))
        # Leaves hang: tips outward and down, upper sides roughly to the sky.
        heading = rng.uniform(0, math.tau)
        tip = unit((math.sin(heading), rng.uniform(-1.1, 0.1), math.cos(heading)))
        across = unit(cross((rng.gauss(0, 0.35), 1.0, rng.gauss(0, 0.35)), tip))
        back = (-tip[0], -tip[1], -tip[2])
        mesh.add(transformed(leaf, [across, cross(back, across), back], leaf_size * rng.uniform(0.7, 1.25), spot))
    return mesh


def make_clump(seed: str, sprays: int) -> Mesh:
    """Foliage far away: one bent sheet about a metre across whose ragged outline looks like many leaves."""
    rng = random.Random(seed)
    outline = []
    for i in range(sprays):
        angle = math.tau * i / sprays
        reach = 0.36 + 0.10 * math.sin(3 * angle + 1.0) + rng.uniform(-0.05, 0.05)
        # A spray of leaves: a notch, a side tip, the main tip.
        for turn, factor in ((0.0, 0.62), (0.30, 1.0), (0.48, 0.84), (0.66, 1.18)):
            theta = angle + math.tau * (turn + rng.uniform(-0.05, 0.05)) / sprays
            outline.append((reach * factor * math.cos(theta), reach * factor * math.sin(theta)))
    return Mesh(
        # The half turn about x that takes (x, z) to the sheet keeps its front towards +y.
        positions=[(x, 0.12 * math.sin(5 * x) + 0.4 * z * z, -z) for x, z in outline],
        uvs=[(0.5 + 0.3 * x, 0.5 + 0.3 * z) for x, z in outline],
        faces=list(flip_to_delaunay(outline, clip_ears(outline))),
    )


def ground_height(x: float, z: float) -> float:
    """Gentle undulation, metres; about level around the origin."""
    away = min(1.0, math.hypot(x, z) / 12.0)
    waves = 0.22 * math.sin(0.31 * x + 0.6) * math.cos(0.27 * z) + 0.10 * math.sin(0.83 * x + 0.49 * z) + 0.06 * math.sin(1.1 * z)
    banks = 0.9 * max(0.0, abs(x) - 6.0) / 14.0
    return away * waves + banks


def make_ground(half_width: float, near: float, far: float, columns: int, rows: int, tile_m: float) -> Mesh:
    """A grid of quads from z = near to z = far; one texture tile is `tile_m` metres."""
    mesh = Mesh()
    for row in range(rows + 1):
        for column in range(columns + 1):
            x = half_width * (2 * column / columns - 1)
            z = near + (far - near) * row / rows
            mesh.positions.append((x, ground_height(x, z), z))
            mesh.uvs.append((x / tile_m, -z / tile_m))
    width = columns + 1
    for row in range(rows):
        for column in range(columns):
            a = row * width + column
            mesh.faces.append((a, a + 1, a + width + 1, a + width))
    return mesh
