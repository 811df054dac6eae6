"""Bark: a kind in, rows of sRGB bytes and a normal map out.

Invariant: pictures repeat at their borders, and relief lies where the colours have it.
"""

import random
from dataclasses import dataclass

from maps import Map, add_maps, noise_map
from paint import facing, packed
from palettes import mix

# How deep furrows are, metres; and how wide and high a picture is on a trunk, about.
FURROWS_M = {"oak": 0.028, "maple": 0.010, "birch": 0.004}
PICTURE_M = (0.75, 2.0)


@dataclass(frozen=True)
class Bark:
    """What the pictures of a kind share; every map is as large as they are."""

    kind: str
    wide: Map
    fine: Map
    grain: Map
    moss: Map
    bands: Map
    patches: Map

    @classmethod
    def grown(cls, kind: str, width: int, height: int) -> "Bark":
        """The maps of a kind, by its name."""
        rng = random.Random(f"bark {kind}")

        def noise(cells_x: int, cells_y: int) -> Map:
            return noise_map(width, height, cells_x, cells_y, rng)

        wide, fine, grain = noise(9, 3), noise(21, 7), noise(64, 40)
        moss = add_maps([(0.7, noise(3, 4)), (0.3, noise(24, 40))])
        return cls(kind, wide, fine, grain, moss, noise(4, 46), noise(3, 7))

    def plate(self, x: int, y: int) -> float:
        """How far a point is from a furrow, 0 to 1: furrows run where noise crosses 0, as cracks between
        plates do."""
        wide, fine = self.wide[y][x], self.fine[y][x]
        return min(1.0, 2.6 * abs(wide + 0.5 * fine)) * min(1.0, 0.35 + 2.4 * abs(fine))

    def height(self, x: int, y: int) -> float:
        """Height over the furrows' ground, of 1: plates are round at their rims."""
        if self.kind == "birch":
            return max(-1.0, 1.0 - max(0.0, 5.0 * self.bands[y][x] - 2.0)) + 0.2 * self.grain[y][x]
        plate = self.plate(x, y)
        return plate * (2.0 - plate) + 0.12 * self.grain[y][x]


def paint_bark(bark: Bark) -> list[bytes]:
    """Colours: of `oak` deeply furrowed, of `maple` grey and finely cracked, of `birch` white with dark bands."""
    rows = []
    for y, (grains, mosses, bands, patches, wides) in enumerate(
        zip(bark.grain, bark.moss, bark.bands, bark.patches, bark.wide)
    ):
        row = bytearray()
        for x, (g, m, band, patch, wide) in enumerate(zip(grains, mosses, bands, patches, wides)):
            furrow = bark.plate(x, y)
            if bark.kind == "oak":
                color = mix((26, 20, 15), (112, 96, 78), furrow * (0.82 + 0.25 * g))
                color = mix(color, (84, 92, 40), max(0.0, min(0.55, 1.3 * m - 0.1)))
            elif bark.kind == "maple":
                color = mix((54, 48, 42), (128, 118, 104), 0.35 + 0.45 * min(1.0, furrow) + 0.20 * g)
                color = mix(color, (150, 152, 128), max(0.0, min(0.5, 2.0 * patch - 0.5)))
                color = mix(color, (88, 98, 46), max(0.0, min(0.45, 1.2 * m - 0.2)))
            else:
                dark = max(0.0, min(1.0, 5.0 * (band + 0.35 * g) - 2.3))
                scar = max(0.0, min(1.0, 4.0 * (patch + 0.3 * wide) - 2.0))
                color = mix((214, 206, 190), (236, 230, 218), 0.5 + 0.5 * g)
                color = mix(mix(color, (64, 54, 46), dark), (44, 38, 34), scar)
            row += packed(color)
        rows.append(bytes(row))
    return rows


def paint_bark_normals(bark: Bark) -> list[bytes]:
    """Where bark faces, as glTF's normal maps have it."""
    rows, columns = len(bark.wide), len(bark.wide[0])
    deep = FURROWS_M[bark.kind]
    heights = [[deep * bark.height(x, y) for x in range(columns)] for y in range(rows)]
    across, along = 2.0 * PICTURE_M[0] / columns, 2.0 * PICTURE_M[1] / rows
    def normal(x: int, y: int) -> bytes:
        right = heights[y][(x + 1) % columns] - heights[y][x - 1]
        up = heights[y - 1][x] - heights[(y + 1) % rows][x]
        return facing(right / across, up / along)

    return [b"".join(normal(x, y) for x in range(columns)) for y in range(rows)]
