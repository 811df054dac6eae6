"""Leaf outlines: species in, closed counter-clockwise polygons and veins out.

A blade lies in the plane (x across, z along): its petiole joins at (0, 0) and it reaches z = 1.
Invariant: an outline is a simple polygon whose first vertex is the petiole joint and whose highest
vertices lie at z = 1.
"""

import math
import random
from dataclasses import dataclass

Point = tuple[float, float]


@dataclass(frozen=True)
class Blade:
    """A species' flat shape."""

    name: str
    outline: list[Point]
    veins: list[list[Point]]
    """Polylines from the thick end to the thin end; the first is the midrib."""
    petiole_length: float
    """In blade lengths."""
    twigs: bool = True
    """Whether finer veins branch off those above."""


def sagging(points: list[Point], sag: float, steps: int) -> list[Point]:
    """Points joined by arcs that bend towards the blade's inside by `sag` of their chord."""
    curve = []
    for (x0, z0), (x1, z1) in zip(points, points[1:]):
        # Right-hand side of the blade, walked from base to tip: the inside is to the left.
        mid_x = (x0 + x1) / 2 - (z1 - z0) * sag
        mid_z = (z0 + z1) / 2 + (x1 - x0) * sag
        for step in range(steps):
            t = step / steps
            a, b, c = (1 - t) ** 2, 2 * t * (1 - t), t**2
            curve.append((a * x0 + b * mid_x + c * x1, a * z0 + b * mid_z + c * z1))
    return curve + [points[-1]]


def smooth(points: list[Point], steps: int) -> list[Point]:
    """A Catmull-Rom curve through the points."""
    padded = [points[0], *points, points[-1]]
    curve = []
    for p0, p1, p2, p3 in zip(padded, padded[1:], padded[2:], padded[3:]):
        for step in range(steps):
            t = step / steps
            curve.append(
                tuple(
                    0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t**2 + (3 * b - a - 3 * c + d) * t**3)
                    for a, b, c, d in zip(p0, p1, p2, p3)
                )
            )
    return curve + [points[-1]]


def closed(right: list[Point], left: list[Point]) -> list[Point]:
    """A polygon from two sides, each given from base to tip with x >= 0."""
    return right + [(-x, z) for x, z in reversed(left[1:-1])]


def waved(half_width, steps: int, height: float, frequency: float, phase: float) -> list[Point]:
    """A side with a shallow wave along it, which ends at both ends."""
    inner = [i / steps for i in range(1, steps)]
    waves = ((half_width(t) + height * math.sin(frequency * t + phase) * min(1.0, 8 * t * (1 - t)), t) for t in inner)
    return [(0.0, 0.0), *waves, (0.0, 1.0)]


def jittered(points: list[Point], amount: float, rng: random.Random) -> list[Point]:
    """Control points moved a little, so that the two sides of a leaf are not mirror images."""
    inner = [(x + rng.uniform(-amount, amount), z + rng.uniform(-amount, amount)) for x, z in points[1:-1]]
    return [points[0], *inner, points[-1]]


def maple(individual: str = "") -> Blade:
    """Norway maple: five long lobes with drawn-out teeth, sinuses between them; another individual is cut a
    little differently."""
    rng = random.Random("maple" + individual)
    side = [
        (0.00, 0.00), (0.09, -0.075), (0.21, -0.085), (0.385, -0.135), (0.345, -0.01), (0.43, 0.035),
        (0.335, 0.085), (0.43, 0.105), (0.545, 0.085), (0.555, 0.185), (0.735, 0.285), (0.575, 0.315),
        (0.605, 0.435), (0.455, 0.375), (0.36, 0.375), (0.215, 0.355), (0.235, 0.47), (0.365, 0.585),
        (0.235, 0.605), (0.185, 0.69), (0.255, 0.80), (0.125, 0.79), (0.07, 0.88), (0.00, 1.00),
    ]  # fmt: skip
    right, left = (sagging(jittered(side, 0.014, rng), 0.10, 4) for _ in range(2))
    veins = [[(0, 0), (0, 0.97)]]
    for mirror in (1, -1):
        veins += [
            [(0, 0), (mirror * 0.33, 0.165), (mirror * 0.70, 0.275)],
            [(0, 0), (mirror * 0.18, -0.02), (mirror * 0.36, -0.12)],
            [(0, 0.34), (mirror * 0.13, 0.45), (mirror * 0.34, 0.575)],
            [(0, 0.60), (mirror * 0.10, 0.69), (mirror * 0.235, 0.785)],
            [(mirror * 0.30, 0.15), (mirror * 0.42, 0.30), (mirror * 0.59, 0.425)],
            [(mirror * 0.30, 0.15), (mirror * 0.42, 0.135), (mirror * 0.53, 0.095)],
            [(mirror * 0.18, -0.02), (mirror * 0.30, 0.01), (mirror * 0.41, 0.035)],
        ]
    return Blade("maple", closed(right, left), veins, 0.62)


def ovate(width: float, widest: float, tip: float, t: float) -> float:
    """Half width of an egg-shaped blade at `t` along it."""
    power = math.log(0.5) / math.log(widest)
    return width * max(math.sin(math.pi * t**power), 0.0) ** tip


def pinnate_veins(half_width, count: int, rise: float) -> list[list[Point]]:
    """A midrib with `count` slightly curved side veins on either side."""
    veins = [[(0.0, 0.0), (0.0, 0.98)]]
    for i in range(count):
        z = 0.06 + 0.76 * i / count
        end = min(z + rise, 0.97)
        for mirror in (1, -1):
            x = mirror * half_width(end) * 0.96
            veins.append([(0.0, z), (x * 0.55, z + (end - z) * 0.45), (x, end)])
    return veins


def birch() -> Blade:
    """Silver birch: an egg with a drawn-out tip and two sizes of teeth."""
    rng = random.Random("birch")

    def half_width(t: float) -> float:
        return ovate(0.36, 0.34, 0.86, t)

    sides = []
    for _ in range(2):
        side: list[Point] = [(0.0, 0.0), (half_width(0.04), 0.035)]
        teeth = 15
        for i in range(teeth):
            t = 0.14 + 0.80 * i / teeth
            depth = (0.055 if i % 2 == 0 else 0.028) * (0.4 + 2.2 * half_width(t)) * rng.uniform(0.8, 1.2)
            side.append((half_width(t) * 0.97 - depth * 0.25, t - 0.012))
            side.append((half_width(t) + depth * 0.8, t + 0.022))
        side.append((0.0, 1.0))
        sides.append(side)
    return Blade("birch", closed(*sides), pinnate_veins(half_width, 7, 0.17), 0.42)


def oak(individual: str = "") -> Blade:
    """Pedunculate oak: rounded lobes, widest beyond the middle, a short petiole; another individual is cut a
    little differently."""
    rng = random.Random("oak" + individual)
    side = [
        (0.00, 0.00), (0.045, -0.012), (0.075, 0.035), (0.065, 0.10), (0.13, 0.155), (0.185, 0.20), (0.175, 0.25),
        (0.105, 0.275), (0.125, 0.325), (0.225, 0.375), (0.285, 0.43), (0.265, 0.485), (0.155, 0.495),
        (0.165, 0.555), (0.275, 0.61), (0.335, 0.675), (0.305, 0.735), (0.185, 0.73), (0.18, 0.785),
        (0.24, 0.845), (0.225, 0.905), (0.13, 0.91), (0.085, 0.965), (0.00, 1.00),
    ]  # fmt: skip
    right, left = (smooth(jittered(side, 0.010, rng), 3) for _ in range(2))
    veins = [[(0.0, 0.0), (0.0, 0.97)]]
    for mirror in (1, -1):
        for start, x, z in [
            (0.07, 0.165, 0.215),
            (0.22, 0.265, 0.44),
            (0.42, 0.31, 0.685),
            (0.63, 0.215, 0.88),
        ]:
            veins.append([(0.0, start), (mirror * x * 0.5, start + (z - start) * 0.42), (mirror * x, z)])
    return Blade("oak", closed(right, left), veins, 0.16)


def beech(individual: str = "") -> Blade:
    """Common beech: an egg with a shallow wave along its edge and straight parallel veins; another individual
    is wider or narrower."""
    rng = random.Random("beech" + individual)
    width, widest = (rng.uniform(0.26, 0.36), rng.uniform(0.38, 0.54)) if individual else (0.31, 0.46)

    def half_width(t: float) -> float:
        return ovate(width, widest, 0.72, t)

    sides = (waved(half_width, 44, 0.011, 54, phase) for phase in (0.0, 1.3))
    return Blade("beech", closed(*sides), pinnate_veins(half_width, 8, 0.15), 0.20)


def ginkgo() -> Blade:
    """Ginkgo: a fan with a wavy rim and one deep cleft; its veins fork and never meet again."""
    rng = random.Random("ginkgo")
    spread, notch = 1.16, 0.07  # Half the fan's opening in radians, half the cleft's at the rim.

    def rim(turn: float, phase: float) -> Point:
        """On the rim, `turn` radians from the axis."""
        reach = 0.99 + 0.018 * math.sin(23 * turn + phase) + 0.012 * math.sin(41 * turn + 2 * phase)
        reach *= 1.0 - 0.13 * (turn / spread) ** 4
        return (reach * math.sin(turn), reach * math.cos(turn))

    def side(phase: float) -> list[Point]:
        stalk = [(0.0, 0.0), (0.022, 0.02), (0.075, 0.07), (0.24, 0.175), (0.50, 0.265)]
        turns = [spread + (notch - spread) * i / 26 for i in range(27)]
        depth = rng.uniform(0.56, 0.6)
        return smooth(stalk, 3)[:-1] + [rim(turn, phase) for turn in turns] + [(0.012, 0.8), (0.0, depth)]

    right, left = side(0.4), side(2.1)
    highest = max(z for _, z in right + left)
    outline = [(x / highest, z / highest) for x, z in closed(right, left)]
    veins = []
    for i in range(17):
        turn = (i - 8) / 8 * spread * 0.94
        if abs(turn) < 0.05:
            continue
        # Two to a stem: each pair parts a third of the way out.
        stem = turn - math.copysign(0.04, i % 2 - 0.5)
        bases = [(0.02 * math.sin(stem), 0.05), (0.36 * math.sin(stem), 0.36 * math.cos(stem))]
        ends = [(r * math.sin(turn), r * math.cos(turn)) for r in (0.62, 0.9)]
        veins.append(bases + ends)
    return Blade("ginkgo", outline, [[(0, 0), (0, 0.3)]] + veins, 0.75, twigs=False)


def aspen() -> Blade:
    """Trembling aspen: almost round, blunt teeth, a short point, a long flat petiole."""
    rng = random.Random("aspen")

    def half_width(t: float) -> float:
        return 0.49 * max(math.sin(math.pi * t**0.86), 0.0) ** 0.56

    def side() -> list[Point]:
        points: list[Point] = [(0.0, 0.0), (0.10, -0.012)]
        teeth = 10
        for i in range(teeth):
            t = 0.06 + 0.80 * i / teeth
            depth = rng.uniform(0.012, 0.022)
            points.append((half_width(t) - depth, t - 0.006))
            points.append((half_width(t + 0.04) + depth, t + 0.045))
        points += [(0.16, 0.905), (0.07, 0.945), (0.0, 1.0)]
        return smooth(points, 3)

    return Blade("aspen", closed(side(), side()), pinnate_veins(half_width, 5, 0.24), 0.85)


def willow() -> Blade:
    """White willow: a narrow lance with fine teeth and many side veins."""

    def half_width(t: float) -> float:
        return ovate(0.092, 0.42, 0.88, t)

    sides = (waved(half_width, 40, 0.0035, 80, phase) for phase in (0.0, 0.8))
    return Blade("willow", closed(*sides), pinnate_veins(half_width, 14, 0.06), 0.09)


SPECIES = [maple, birch, oak, beech, ginkgo, aspen, willow]
