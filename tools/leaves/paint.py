"""Pictures: maps and ages in, rows of sRGB bytes out.

A leaf ages from green to brown at every point at its own pace: ahead at the edge, behind along the veins,
mottled between. `palettes` has the colours on the way. Invariant: what lies outside the blade is coloured
like its edge. So filtering at the outline brings in no foreign colour.
"""

import math
import random
from collections.abc import Callable
from dataclasses import dataclass

from maps import LeafMaps, Map, add_maps, fill, noise_map
from outlines import Blade
from palettes import RAMPS, Color, Ramp, mix


EVEN = 0.26
"""Patchiness of most leaves."""
RIM = 0.16
"""How far from the edge a blade thickens towards it, as a share of `edge_distance`: 2.5 % of its length."""


def local_ages(maps: LeafMaps, age: float, patchiness: float) -> Map:
    """How far each point has aged; `patchiness` is how far patches are ahead of one another
    and of the veins."""
    return [
        [age + patchiness * (m - 0.17 / 0.26 * g) + 0.20 * (1 - d) ** 2 + 0.02 for d, g, m in zip(*row)]
        for row in zip(maps.edge_distance, maps.glow, maps.mottle)
    ]


def painted(maps: LeafMaps, ramp: Ramp, age: float, patchiness: float, shade: Callable) -> list[bytes]:
    """A picture: `shade` has a point's color on the ramp, vein, net, spots, mottle and distance from the edge."""
    elsewhere = packed(ramp.at(age + 0.2))
    ages = local_ages(maps, age, patchiness)
    parts = (maps.margin, ages, maps.vein, maps.net, maps.spots, maps.mottle, maps.edge_distance)
    return [
        b"".join(
            packed(shade(ramp.at(local), *point)) if here else elsewhere for here, local, *point in zip(*row)
        )
        for row in zip(*parts)
    ]


def paint_leaf(maps: LeafMaps, ramp: Ramp, age: float, patchiness: float = EVEN) -> list[bytes]:
    """What a leaf reflects."""

    def shade(color: Color, v: float, n: float, s: float, m: float, d: float) -> Color:
        color = mix(color, ramp.spot, min(1.0, s * 0.75 + 0.10 * n))
        color = mix(color, mix(color, ramp.vein, 0.8), v * 0.8)
        light = 1.0 + 0.07 * m
        return tuple(c * light for c in color)

    return painted(maps, ramp, age, patchiness, shade)


def packed(color: Color) -> bytes:
    """Three bytes, every fourth value only: half the file for a difference nobody sees."""
    return bytes(min(252, max(0, int(c))) & 0xFC for c in color)


def paint_light_through(maps: LeafMaps, ramp: Ramp, age: float, patchiness: float = EVEN) -> list[bytes]:
    """What a leaf lets through: twice through the pigments, so deeper in colour; veins, spots and the
    thicker rim hold light back."""

    def shade(color: Color, v: float, n: float, s: float, m: float, d: float) -> Color:
        most = max(color)
        held = (1 - 0.50 * v) * (1 - 0.18 * n) * (1 - 0.75 * s) * (1 - 0.55 * max(0.0, 1 - d / RIM))
        # Brighter than the reflectance by the share that the surface does not reflect.
        return tuple(1.12 * most * (c / most) ** 1.5 * held for c in color)

    return painted(maps, ramp, age, patchiness, shade)


def relief(maps: LeafMaps) -> Map:
    """Height of the upper side over a flat blade in pixels, half as many a side as `maps` have: veins lie in
    furrows, between which it bulges."""
    size = len(maps.vein) // 2
    shares = [(-0.0045, maps.vein), (-0.0100, maps.glow), (-0.0010, maps.net), (0.0020, maps.mottle)]

    def height(x: int, y: int) -> float:
        return size * sum(
            0.25 * share * sum(part[2 * y][2 * x : 2 * x + 2] + part[2 * y + 1][2 * x : 2 * x + 2])
            for share, part in shares
        )

    return [[height(x, y) for x in range(size)] for y in range(size)]


def facing(right: float, up: float) -> bytes:
    """A pixel of a normal map where the surface rises by these slopes."""
    length = math.sqrt(right * right + up * up + 1.0)
    return bytes(round(127.5 + 127.5 * part / length) for part in (-right, -up, 1.0))


def paint_normals(maps: LeafMaps) -> list[bytes]:
    """Where the upper side faces, as glTF's normal maps have it: x to the right, y up, z
    out of the picture."""
    heights = relief(maps)
    last = len(heights) - 1
    rows = []
    for y, here in enumerate(heights):
        above, below = heights[max(0, y - 1)], heights[min(last, y + 1)]
        row = bytearray()
        for x in range(len(here)):
            shown = maps.margin[2 * y][2 * x]
            right = 0.5 * (here[min(last, x + 1)] - here[max(0, x - 1)]) if shown else 0.0
            up = 0.5 * (above[x] - below[x]) if shown else 0.0
            row += facing(right, up)
        rows.append(bytes(row))
    return rows


@dataclass(frozen=True)
class Strewn:
    """How leaves lie on soil."""

    count: int
    length: tuple[float, float]
    """Of the picture's side."""
    youngest: float
    """Age of the last to fall, of 1."""
    light: float
    """How bright the first to fall are still, of 1."""


# A park's; of a wood, what the wind has heaped, and what has lain since last year.
FLOORS = {
    "litter": Strewn(900, (0.05, 0.085), 0.35, 0.45),
    "drift": Strewn(1000, (0.035, 0.08), 0.5, 0.5),
    "soil": Strewn(800, (0.03, 0.075), 0.85, 0.3),
}


def paint_floor(kind: str, blades: list[Blade], size: int) -> list[bytes]:
    """Fallen leaves on dark soil, repeating at the borders."""
    rng, strewn = random.Random(kind), FLOORS[kind]
    soil = add_maps([(0.5, noise_map(size, size, 8, 8, rng)), (0.5, noise_map(size, size, 32, 32, rng))])
    picture = [[mix((44, 32, 20), (74, 52, 30), 0.5 + 0.5 * s) for s in row] for row in soil]
    for index in range(strewn.count):
        late = index / strewn.count
        blade = rng.choice(blades)
        # The longest down are the brownest.
        likeliest = max(strewn.youngest, 1.0 - 0.3 * late)
        color = RAMPS[blade.name].at(rng.triangular(strewn.youngest, 1.0, likeliest))
        # What lies deeper is darker.
        depth = strewn.light + (1.0 - strewn.light) * late
        x, y, turn = rng.uniform(0, size), rng.uniform(0, size), rng.uniform(0, math.tau)
        length = size * rng.uniform(*strewn.length)
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
                    shade = depth * (
                        0.92
                        + 0.22 * max(-1.0, min(1.0, across / (0.3 * length)))
                        + 0.12 * (abs(across) < 0.7)
                    )
                    picture[(j + oy) % size][(i + ox) % size] = mix((0, 0, 0), color, shade)
    return [b"".join(map(packed, row)) for row in picture]
