"""Maps of a leaf: a blade in, pictures of numbers out, which `paint` colours.

Invariant: every map is a square of one size, its top row first. What a species' maps share is painted once;
what tells individuals apart is painted by seed.
"""

import math
import random
from dataclasses import dataclass, replace

from leaf import texture_position
from outlines import Blade

Map = list[list[float]]


def noise_map(width: int, height: int, cells_x: int, cells_y: int, rng: random.Random) -> Map:
    """Value noise in -1..1 that repeats at the borders (Perlin's fade between random lattice values)."""
    lattice = [[rng.uniform(-1, 1) for _ in range(cells_x)] for _ in range(cells_y)]

    def cell_and_fade(i: int, size: int, cells: int) -> tuple[int, int, float]:
        position = i * cells / size
        cell = int(position)
        t = position - cell
        return cell, (cell + 1) % cells, t * t * (3 - 2 * t)

    columns = [cell_and_fade(x, width, cells_x) for x in range(width)]
    rows = []
    for y in range(height):
        y0, y1, fade = cell_and_fade(y, height, cells_y)
        line = [a + (b - a) * fade for a, b in zip(lattice[y0], lattice[y1])]
        rows.append([line[x0] + (line[x1] - line[x0]) * t for x0, x1, t in columns])
    return rows


def add_maps(parts: list[tuple[float, Map]]) -> Map:
    """The weighted sum of maps of one size."""
    height, width = len(parts[0][1]), len(parts[0][1][0])
    return [[sum(weight * part[y][x] for weight, part in parts) for x in range(width)] for y in range(height)]


def fill(polygon: list[tuple[float, float]], size: int) -> list[bytearray]:
    """Scan conversion: 1 where a pixel's centre lies inside (even-odd)."""
    rows = [bytearray(size) for _ in range(size)]
    edges = list(zip(polygon, polygon[1:] + polygon[:1]))
    for y, row in enumerate(rows):
        cuts = sorted(
            x0 + (y + 0.5 - y0) / (y1 - y0) * (x1 - x0)
            for (x0, y0), (x1, y1) in edges
            if (y0 > y + 0.5) != (y1 > y + 0.5)
        )
        for start, end in zip(cuts[::2], cuts[1::2]):
            first, last = max(0, math.ceil(start - 0.5)), min(size, math.ceil(end - 0.5))
            row[first:last] = b"\1" * max(0, last - first)
    return rows


def distance_inside(mask: list[bytearray]) -> Map:
    """Pixels to the nearest pixel outside: the two-pass chamfer transform (Borgefors 1986)."""
    size = len(mask)
    far, straight, diagonal = 1e6, 1.0, 1.4142
    d = [[far if inside else 0.0 for inside in row] for row in mask]
    for y in range(1, size):
        above, row = d[y - 1], d[y]
        for x in range(1, size - 1):
            if row[x]:
                beside, across = min(row[x - 1], above[x]), min(above[x - 1], above[x + 1])
                row[x] = min(beside + straight, across + diagonal)
    for y in range(size - 2, -1, -1):
        below, row = d[y + 1], d[y]
        for x in range(size - 2, 0, -1):
            if row[x]:
                beside, across = min(row[x + 1], below[x]), min(below[x + 1], below[x - 1])
                row[x] = min(row[x], beside + straight, across + diagonal)
    return d


def stamp_line(strength: Map, a, b, radius_a: float, radius_b: float, reach: float) -> None:
    """Raises `strength` along a tapered line to 1 at its middle, falling off over `reach` radii."""
    steps = max(2, int(math.dist(a, b) * 1.5))
    size = len(strength)
    for i in range(steps + 1):
        t = i / steps
        cx, cy, radius = (p + (q - p) * t for p, q in zip((*a, radius_a), (*b, radius_b)))
        extent = radius * reach
        for y in range(max(0, int(cy - extent)), min(size, int(cy + extent) + 2)):
            row = strength[y]
            for x in range(max(0, int(cx - extent)), min(size, int(cx + extent) + 2)):
                value = math.exp(-(((x + 0.5 - cx) ** 2 + (y + 0.5 - cy) ** 2) / (radius * radius)))
                if value > row[x]:
                    row[x] = value


@dataclass(frozen=True)
class LeafMaps:
    """What all variants of a species share; every map is `size` x `size`."""

    margin: list[bytes]
    """1 on the blade, its petiole and a few pixels around them; no point elsewhere is ever looked up."""
    edge_distance: Map
    vein: Map
    glow: Map
    """A wide, soft neighbourhood of the veins."""
    net: Map
    """Meshes of the finest veins."""
    mottle: Map
    spots: Map


def leaf_maps(blade: Blade, size: int) -> LeafMaps:
    """Paints the maps of a species."""
    rng = random.Random(f"paint {blade.name}")
    seeded = random.Random(f"net {blade.name}")

    def pixel(x: float, z: float) -> tuple[float, float]:
        u, v = texture_position(blade, x, z)
        return (u * size, (1 - v) * size)

    unit = math.dist(pixel(0, 0), pixel(0, 1))
    edge_distance = distance_inside(fill([pixel(x, z) for x, z in blade.outline], size))
    vein = [[0.0] * size for _ in range(size)]
    glow = [[0.0] * size for _ in range(size)]
    for index, polyline in enumerate(blade.veins):
        thick = 0.0105 if index == 0 else 0.0065
        count = len(polyline) - 1
        for k, (a, b) in enumerate(zip(polyline, polyline[1:])):
            radii = [unit * thick * (1 - 0.75 * (k + end) / count) for end in (0, 1)]
            stamp_line(vein, pixel(*a), pixel(*b), *radii, 2.2)
            stamp_line(glow, pixel(*a), pixel(*b), *(r + unit * 0.035 for r in radii), 2.0)
            twigs = max(2, int(math.dist(a, b) * 14)) if blade.twigs else 0
            for i in range(1, twigs):
                # Fine veins branch off in turn to either side, leaning forward.
                t, turn = i / twigs, (0.75 if i % 2 else -0.75) + rng.uniform(-0.12, 0.12)
                start = (a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t)
                angle = math.atan2(b[1] - a[1], b[0] - a[0]) + turn
                length = rng.uniform(0.06, 0.12)
                end = (start[0] + math.cos(angle) * length, start[1] + math.sin(angle) * length)
                stamp_line(vein, pixel(*start), pixel(*end), unit * 0.0028, unit * 0.0012, 2.0)
    petiole_end = pixel(0, -blade.petiole_length - 0.1)
    stamp_line(vein, pixel(0, 0), petiole_end, unit * 0.05, unit * 0.05, 1.5)
    reach = unit * 0.16
    edge = [[min(1.0, d / reach) for d in row] for row in edge_distance]
    net = cell_edges(size, round(size / unit * 34), seeded)
    shown = [[d + v for d, v in zip(*rows)] for rows in zip(edge, vein)]
    return blemished(LeafMaps(widened(shown, 5), edge, vein, glow, net, vein, vein), f"{blade.name} 0")


def widened(shown: Map, reach: int) -> list[bytes]:
    """1 wherever there is something within a square of `reach` pixels."""

    def along_rows(rows: list[list[float]]) -> list[list[float]]:
        return [[max(row[max(0, i - reach) : i + reach + 1]) for i in range(len(row))] for row in rows]

    columns = along_rows([list(column) for column in zip(*along_rows(shown))])
    return [bytes(value > 0 for value in row) for row in zip(*columns)]


def blemished(maps: LeafMaps, seed: str) -> LeafMaps:
    """The same leaf with mottle and spots of another individual."""
    rng = random.Random(f"blemishes {seed}")
    size = len(maps.vein)
    mottle = add_maps([(0.6, noise_map(size, size, 5, 5, rng)), (0.4, noise_map(size, size, 17, 17, rng))])
    spots = [[0.0] * size for _ in range(size)]
    for _ in range(rng.randrange(20, 60)):
        x, y = rng.uniform(0, size), rng.uniform(0, size)
        radius = size * (0.002 + 0.011 * rng.random() ** 3)
        stamp_line(spots, (x, y), (x + rng.uniform(-2, 2), y + rng.uniform(-2, 2)), radius, radius, 1.8)
    return replace(maps, mottle=mottle, spots=spots)


def cell_edges(size: int, cells: int, rng: random.Random) -> Map:
    """1 on the edges between the cells of scattered points, one a lattice cell (Worley, "A cellular texture
    basis function", 1996)."""
    points = [[(x + rng.random(), y + rng.random()) for x in range(cells)] for y in range(cells)]
    rows = []
    for j in range(size):
        y = (j + 0.5) * cells / size
        row = []
        for i in range(size):
            x = (i + 0.5) * cells / size
            nearest, second = 9.0, 9.0
            for cell_y in range(max(0, int(y) - 1), min(cells, int(y) + 2)):
                for px, py in points[cell_y][max(0, int(x) - 1) : int(x) + 2]:
                    d = (px - x) * (px - x) + (py - y) * (py - y)
                    if d < nearest:
                        nearest, second = d, nearest
                    elif d < second:
                        second = d
            row.append(max(0.0, 1.0 - 5.0 * (math.sqrt(second) - math.sqrt(nearest))))
        rows.append(row)
    return rows
