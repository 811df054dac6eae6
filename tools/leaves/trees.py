"""Trees: a habit and a seed in, wood and twigs out, metres.

Wood is what shows its bark; leaves sit on twigs. Invariant: y is up, roots at y = 0, every tube
faces outward and is closed at its far end.
"""

import math
import random
from dataclasses import dataclass

from mesh import Mesh, Vector, cross, subtract


def unit(a: Vector) -> Vector:
    """`a` at length 1."""
    length = math.hypot(*a)
    return (a[0] / length, a[1] / length, a[2] / length)


def along(a: Vector, direction: Vector, distance: float) -> Vector:
    """a + direction * distance."""
    return (a[0] + direction[0] * distance, a[1] + direction[1] * distance, a[2] + direction[2] * distance)


def tube(path: list[Vector], radii: list[float], sides: int, uv_scale: tuple[float, float]) -> Mesh:
    """A tapered pipe along a path, closed at its far end; u runs `uv_scale[0]` times around, v in
    metres / `uv_scale[1]`."""
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


def thin_tube(start: Vector, end: Vector, radii: tuple[float, float], sides: int) -> Mesh:
    """A straight pipe of three sides, open at its ends, or a strip of two: a twig is a pixel wide at best,
    but there are many."""
    axis = unit(subtract(end, start))
    right = unit(cross(axis, (1.0, 0.0, 0.0) if abs(axis[0]) < 0.9 else (0.0, 1.0, 0.0)))
    side = cross(axis, right)
    mesh = Mesh()
    for center, radius in zip((start, end), radii):
        for k in range(sides):
            angle = math.tau * k / sides
            mesh.positions.append(
                along(along(center, right, radius * math.cos(angle)), side, radius * math.sin(angle))
            )
    mesh.faces = [
        (k, (k + 1) % sides, (k + 1) % sides + sides, k + sides) for k in range(sides if sides > 2 else 1)
    ]
    return mesh


def wander(
    start: Vector, direction: Vector, length: float, steps: int, bend: float, lift: float, rng: random.Random
) -> list[Vector]:
    """A crooked path that turns by about `bend` a step and towards the sky by `lift`."""
    path = [start]
    for _ in range(steps):
        dx, dy, dz = (rng.uniform(-bend, bend) for _ in range(3))
        direction = unit((direction[0] + dx, direction[1] + dy * 0.5 + lift, direction[2] + dz))
        path.append(along(path[-1], direction, length / steps))
    return path


@dataclass(frozen=True)
class Habit:
    """How a kind of tree grows."""

    height_m: float
    girth_m: float
    """Radius of the trunk above its roots."""
    crown_base: float
    """Height of the lowest limb, as a share of the tree's."""
    limbs: int
    limb_length_m: float
    rise: float
    """How steeply limbs leave the trunk: 0 is level."""
    bend: float
    """How crooked everything is."""
    branches: int
    """On each limb."""
    twigs: int
    """On each branch."""
    twig_length_m: float
    droop: float
    """How much twigs hang."""
    sides: int
    """Of the trunk."""
    branch_steps: int = 3
    branch_sides: int = 4
    twig_sides: int = 3


HABITS = {
    # In a wood trees are bare far up; what stands alone or at its edge is not.
    "oak": Habit(15.0, 0.36, 0.22, 13, 5.4, 0.40, 0.30, 6, 4, 0.85, 0.0, 20),
    "maple": Habit(17.0, 0.24, 0.24, 16, 4.4, 0.50, 0.20, 6, 4, 0.80, 0.08, 20),
    # Its crown takes more than 12,000 leaves; what carries them is hardly seen.
    "beech": Habit(19.0, 0.40, 0.17, 24, 5.6, 0.42, 0.22, 8, 5, 0.95, 0.05, 20, 2, 3, 2),
    "birch": Habit(13.0, 0.13, 0.26, 16, 2.8, 0.72, 0.16, 5, 4, 0.85, 0.45, 15),
    "sapling": Habit(3.6, 0.035, 0.22, 9, 1.1, 0.75, 0.24, 3, 3, 0.36, 0.05, 10),
}


@dataclass
class Tree:
    """The two meshes of a tree."""

    wood: Mesh
    twigs: Mesh
    """Without texture coordinates: they are too thin to show any."""


def shape_of_crown(t: float) -> float:
    """Length of limbs at `t` between crown base and top, as a share of the longest."""
    return (0.55 + 0.45 * math.sin(math.pi * min(1.0, t * 1.5))) * (1.0 - 0.62 * t)


# Heights of the rings where a trunk enters the ground, by its girth: there it bends most.
FOOT = (-0.3, 0.0, 0.2, 0.45, 0.8, 1.3, 2.0, 3.0)


def make_trunk(habit: Habit, rng: random.Random) -> tuple[list[Vector], list[float], Mesh]:
    """Path, radii and mesh of a trunk, whose foot flares into roots."""
    steps, depth = 12, 0.4
    upwards = (rng.uniform(-0.08, 0.08), 1.0, rng.uniform(-0.08, 0.08))
    path = wander((0.0, -depth, 0.0), upwards, habit.height_m, steps, habit.bend * 0.4, 0.10, rng)
    # Two more points near the ground; limbs start at shares of the number of points.
    path[1:1] = [tuple(a + (b - a) * t for a, b in zip(path[0], path[1])) for t in (0.35, 0.65)]
    shares = [0.0, 0.35 / steps, 0.65 / steps] + [i / steps for i in range(1, steps + 1)]
    foot = [(depth + height * habit.girth_m) / habit.height_m for height in FOOT]
    rings = [0.0, *foot, *(share for share in shares if share > 1.2 * foot[-1])]
    line, girths = [within(path, shares, share) for share in rings], [radius(habit, share) for share in rings]
    mesh = tube(line, girths, habit.sides, (max(1, round(habit.girth_m * 8)), 2.0))
    phase, row = rng.uniform(0, math.tau), habit.sides + 1
    for i, position in enumerate(mesh.positions):
        share, angle = rings[i // row], math.tau * (i % row % habit.sides) / habit.sides
        center = within(path, shares, share)
        out = 1.0 + flare(share * habit.height_m - depth, habit.girth_m, angle, phase)
        mesh.positions[i] = tuple(
            c + (p - c) * (1.0 if axis == 1 else out) for axis, (c, p) in enumerate(zip(center, position))
        )
    return path, [radius(habit, share) for share in shares], mesh


def radius(habit: Habit, share: float) -> float:
    """Radius of a trunk at a share of its height, without its roots."""
    return habit.girth_m * (1.0 - 0.93 * share**0.85)


def within(path: list[Vector], shares: list[float], share: float) -> Vector:
    """The point of a path at a share of its height."""
    step = max(i for i, start in enumerate(shares[:-1]) if start <= share)
    t = (share - shares[step]) / (shares[step + 1] - shares[step])
    return tuple(a + (b - a) * t for a, b in zip(path[step], path[step + 1]))


def flare(height: float, girth: float, angle: float, phase: float) -> float:
    """How far a trunk swells at a height above the ground, by its radius: into roots, of which
    some are stronger, and a little all round."""
    turned = angle + 0.5 * math.sin(2 * angle + phase)
    root = (0.5 + 0.5 * math.cos(5 * turned + phase)) ** 1.5 * (0.75 + 0.25 * math.cos(angle - 2 * phase))
    strides = max(height / girth, FOOT[0])
    fluting = 0.045 * math.sin(3 * angle + 0.5 * height + phase)
    spread = 1.3 * min(1.0, girth / 0.24)  # Slender trees have slender roots.
    return 0.35 * math.exp(-strides / 2.5) + spread * root * math.exp(-strides / 0.6) + fluting


def at(path: list[Vector], values: list[float], share: float) -> tuple[Vector, Vector, float]:
    """Point, direction and value at a share of a path's steps."""
    place = share * (len(path) - 1)
    step = min(int(place), len(path) - 2)
    t = place - step
    point = tuple(a + (b - a) * t for a, b in zip(path[step], path[step + 1]))
    heading = unit(subtract(path[step + 1], path[step]))
    return point, heading, values[step] + (values[step + 1] - values[step]) * t


def sideways(direction: Vector, angle: float, forward: float) -> Vector:
    """A direction that leaves `direction` at `angle` around it; `forward` is the tangent of how
    far it leans ahead."""
    right = unit(cross(direction, (0.0, 1.0, 0.0) if abs(direction[1]) < 0.9 else (1.0, 0.0, 0.0)))
    up = cross(right, direction)
    return unit(
        tuple(
            math.cos(angle) * r + math.sin(angle) * u + forward * d for r, u, d in zip(right, up, direction)
        )
    )


def make_tree(seed: str, habit: Habit) -> Tree:
    """A tree of that habit; another seed, another tree."""
    rng = random.Random(seed)
    path, radii, wood = make_trunk(habit, rng)
    tree = Tree(wood, Mesh())
    turn = rng.uniform(0, math.tau)
    for i in range(habit.limbs):
        t = (i + rng.uniform(0.1, 0.9)) / habit.limbs
        start, _, radius = at(path, radii, habit.crown_base + (0.98 - habit.crown_base) * t)
        turn += 2.4 + rng.uniform(-0.5, 0.5)  # About the golden angle, so that limbs spread.
        outward = unit((math.cos(turn), habit.rise * rng.uniform(0.6, 1.3) + 0.7 * t * t, math.sin(turn)))
        length = habit.limb_length_m * shape_of_crown(t) * rng.uniform(0.8, 1.2)
        add_limb(tree, habit, start, outward, length, min(0.55 * radius, 0.022 * length + 0.012), rng)
    return tree


def add_limb(
    tree: Tree, habit: Habit, start: Vector, outward: Vector, length: float, radius: float, rng: random.Random
) -> None:
    """A limb with its branches and their twigs."""
    steps = 5
    limb = wander(start, outward, length, steps, habit.bend, 0.05, rng)
    radii = [radius * (1.0 - 0.80 * k / steps) for k in range(steps + 1)]
    tree.wood.add(tube(limb, radii, 6, (1.0, 2.0)))
    for b in range(habit.branches):
        share = 0.28 + 0.72 * (b + rng.uniform(0.2, 0.8)) / habit.branches
        point, direction, thickness = at(limb, radii, share)
        side = rng.uniform(-0.6, 0.6) + (math.pi if b % 2 else 0.0)
        branch_length = length * rng.uniform(0.30, 0.45) * (1.25 - 0.6 * share)
        branch = wander(
            point, sideways(direction, side, 0.9), branch_length, habit.branch_steps, habit.bend, 0.02, rng
        )
        branch_radii = [
            thickness * 0.55 * (1.0 - 0.75 * k / habit.branch_steps) for k in range(habit.branch_steps + 1)
        ]
        tree.wood.add(tube(branch, branch_radii, habit.branch_sides, (1.0, 2.0)))
        for k in range(habit.twigs):
            share = 0.25 + 0.75 * (k + 1) / habit.twigs
            point, direction, _ = at(branch, branch_radii, share)
            side = rng.uniform(-0.7, 0.7) + (math.pi if k % 2 else 0.0)
            heading = direction if k == habit.twigs - 1 else sideways(direction, side, 0.8)
            heading = unit((heading[0], heading[1] - habit.droop, heading[2]))
            length_m = habit.twig_length_m * rng.uniform(0.6, 1.2)
            twig = wander(point, heading, length_m, 1, 0.2, -0.10 - 0.3 * habit.droop, rng)
            tree.twigs.add(thin_tube(twig[0], twig[-1], (0.006, 0.003), habit.twig_sides))
