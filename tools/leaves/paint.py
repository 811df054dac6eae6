"""Texture maps: a blade and a palette in, rows of sRGB bytes out.

A leaf's picture is three maps painted once a species (distance from the edge, veins, mottle) and a
palette that colours them, so that variants differ in colour only. Invariant: what lies outside the
blade is coloured like its edge, so that filtering at the outline brings in no foreign colour.
"""

import math
import random
from dataclasses import dataclass

from leaf import texture_position
from outlines import Blade

Color = tuple[float, float, float]
Map = list[list[float]]


@dataclass(frozen=True)
class Palette:
    """sRGB colours, 0..255, of one variant of a leaf."""

    name: str
    vein: Color
    heart: Color
    """Near the veins."""
    field: Color
    """Between them."""
    edge: Color
    spot: Color


PALETTES = [
    Palette("green_yellow", (222, 214, 120), (150, 160, 48), (196, 178, 44), (214, 164, 40), (104, 76, 30)),
    Palette("yellow", (250, 226, 132), (238, 188, 40), (246, 196, 34), (222, 142, 24), (134, 78, 22)),
    Palette("orange_red", (248, 190, 92), (232, 126, 26), (218, 82, 20), (166, 38, 16), (84, 28, 14)),
    Palette("brown", (190, 148, 92), (150, 98, 48), (134, 80, 36), (98, 56, 26), (58, 34, 18)),
]


def mix(a: Color, b: Color, t: float) -> Color:
    """From a at 0 to b at 1."""
    return (a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t)


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
            x0 + (y + 0.5 - y0) / (y1 - y0) * (x1 - x0) for (x0, y0), (x1, y1) in edges if (y0 > y + 0.5) != (y1 > y + 0.5)
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
                row[x] = min(row[x - 1] + straight, above[x] + straight, above[x - 1] + diagonal, above[x + 1] + diagonal)
    for y in range(size - 2, -1, -1):
        below, row = d[y + 1], d[y]
        for x in range(size - 2, 0, -1):
            if row[x]:
                row[x] = min(
                    row[x], row[x + 1] + straight, below[x] + straight, below[x + 1] + diagonal, below[x - 1] + diagonal
                )
    return d


def stamp_line(strength: Map, a, b, radius_a: float, radius_b: float, reach: float) -> None:
    """Raises `strength` along a tapered line to 1 at its middle, falling off over `reach` radii."""
    steps = max(2, int(math.dist(a, b) * 1.5))
    size = len(strength)
    for i in range(steps + 1):
        t = i / steps
        cx, cy, radius = a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t, radius_a + (radius_b - radius_a) * t
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

    edge_distance: Map
    vein: Map
    glow: Map
    """A wide, soft neighbourhood of the veins."""
    mottle: Map
    spots: Map


def leaf_maps(blade: Blade, size: int) -> LeafMaps:
    """Paints the maps of a species."""
    rng = random.Random(f"paint {blade.name}")

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
            twigs = max(2, int(math.dist(a, b) * 14))
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
    mottle = add_maps([(0.6, noise_map(size, size, 5, 5, rng)), (0.4, noise_map(size, size, 17, 17, rng))])
    spots = [[0.0] * size for _ in range(size)]
    for _ in range(34):
        x, y = rng.uniform(0, size), rng.uniform(0, size)
        radius = unit * 0.004 + unit * 0.016 * rng.random() ** 3
        stamp_line(spots, (x, y), (x + rng.uniform(-2, 2), y + rng.uniform(-2, 2)), radius, radius, 1.8)
    reach = unit * 0.16
    edge = [[min(1.0, d / reach) for d in row] for row in edge_distance]
    return LeafMaps(edge, vein, glow, mottle, spots)


def paint_leaf(maps: LeafMaps, palette: Palette) -> list[bytes]:
    """Colours a species' maps."""
    rows = []
    for edge, vein, glow, mottle, spots in zip(maps.edge_distance, maps.vein, maps.glow, maps.mottle, maps.spots):
        row = bytearray()
        for distance, v, g, m, s in zip(edge, vein, glow, mottle, spots):
            color = mix(palette.field, palette.heart, min(1.0, max(0.0, g * 0.8 + m * 0.35)))
            rim = (1 - distance) ** 2 * 0.85 + max(0.0, m) * 0.35
            color = mix(color, palette.edge, min(1.0, rim))
            color = mix(color, palette.spot, s * 0.75)
            color = mix(color, palette.vein, v * 0.72)
            shade = 1.0 + 0.07 * m
            # Even values only: half the file for a difference nobody sees.
            row += bytes(min(254, max(0, int(c * shade))) & 0xFE for c in color)
        rows.append(bytes(row))
    return rows


def paint_litter(blades: list[Blade], size: int) -> list[bytes]:
    """Fallen leaves on dark soil, repeating at the borders."""
    rng = random.Random("litter")
    soil = add_maps([(0.5, noise_map(size, size, 8, 8, rng)), (0.5, noise_map(size, size, 32, 32, rng))])
    picture = [[mix((44, 32, 20), (74, 52, 30), 0.5 + 0.5 * s) for s in row] for row in soil]
    colors = [(206, 140, 36), (190, 96, 28), (150, 62, 22), (128, 82, 40), (104, 66, 34), (88, 56, 30), (168, 134, 52), (70, 44, 26)]
    count = 700
    for index in range(count):
        blade = rng.choice(blades)
        color = rng.choice(colors)
        # What lies deeper is darker.
        depth = 0.45 + 0.55 * index / count
        x, y, turn, length = rng.uniform(0, size), rng.uniform(0, size), rng.uniform(0, math.tau), size * rng.uniform(0.05, 0.085)
        cos, sin = math.cos(turn) * length, math.sin(turn) * length
        flatten = rng.uniform(0.6, 1.0)
        box = int(length * 1.5)
        ox, oy = int(x) - box, int(y) - box

        def place(px: float, pz: float) -> tuple[float, float]:
            a, b = px * flatten, pz - 0.5
            return (x - ox + a * cos - b * sin, y - oy + a * sin + b * cos)

        mask = fill([place(*p) for p in blade.outline], 2 * box)
        for j, row in enumerate(mask):
            for i, inside in enumerate(row):
                if inside:
                    # The vein side of the blade catches a little more light than the other.
                    across = (i + ox - x) * math.cos(turn) + (j + oy - y) * math.sin(turn)
                    shade = depth * (0.92 + 0.22 * max(-1.0, min(1.0, across / (0.3 * length))) + 0.12 * (abs(across) < 0.7))
                    picture[(j + oy) % size][(i + ox) % size] = mix((0, 0, 0), color, shade)
    return [bytes(min(254, max(0, int(c))) & 0xFC for color in row for c in color) for row in picture]


def paint_bark(width: int, height: int) -> list[bytes]:
    """Furrowed bark with a touch of moss, repeating at the borders."""
    rng = random.Random("bark")
    ridges = add_maps([(0.55, noise_map(width, height, 18, 5, rng)), (0.45, noise_map(width, height, 40, 14, rng))])
    moss = add_maps([(0.7, noise_map(width, height, 3, 4, rng)), (0.3, noise_map(width, height, 24, 40, rng))])
    rows = []
    for ridge_row, moss_row in zip(ridges, moss):
        row = bytearray()
        for ridge, m in zip(ridge_row, moss_row):
            color = mix((38, 29, 22), (104, 84, 64), max(0.0, min(1.0, 0.5 + 1.1 * ridge)))
            color = mix(color, (72, 78, 34), max(0.0, min(0.6, 1.2 * m - 0.15)))
            row += bytes(int(c) & 0xFC for c in color)
        rows.append(bytes(row))
    return rows
