"""Texels of inputs as linear numbers: several textures at one size, UDIM tiles side by side.

Invariant: a picture has at most `MOST_BAKED` texels; reductions are reported.
"""

from collections.abc import Sequence

import numpy as np

from .losses import Losses
from .networks import Fed
from .texels import PictureError
from .textures import Placement, Texture, Textures

MOST_BAKED = 2**24
"""Maximum texels of a baked picture: 4096 x 4096."""
CLAMP = 33071
LARGEST = np.float32(1e6)
"""Maximum scale of a texture."""


class Planes:
    """Reads the texels of one stage's textures."""

    def __init__(self, textures: Textures, lost: Losses):
        self.textures, self.lost = textures, lost

    def is_srgb(self, texture: Texture, is_color: bool) -> bool:
        """For `auto`, by the specification: eight bits of three or four channels are sRGB if they are
        colours."""
        picture = self.textures.picture(texture.files[0][1])
        return texture.space == "sRGB" or (
            texture.space == "auto" and is_color and picture.bits == 8 and picture.channels >= 3
        )

    def mean(self, fed: Fed) -> tuple[float, ...]:
        """Mean of an input over its texture."""
        texels = self._texels(fed, len(fed.numbers) == 3, self._size([fed]), _grid([fed]))
        return tuple(float(each) for each in texels.mean(axis=(0, 1), dtype=np.float64)[: len(fed.numbers)])

    def _size(self, inputs: Sequence[Fed]) -> tuple[int, int]:
        """Size of a tile: the largest of all pictures, or less if that is too much, which is reported."""
        pictures = [self.textures.picture(path) for fed in inputs for _, path in fed.map.files]
        wide, high = (max(picture.size[axis] for picture in pictures) for axis in (0, 1))
        columns, rows = _grid(inputs)
        shrink = min(1.0, (MOST_BAKED / (wide * high * columns * rows)) ** 0.5)
        if shrink < 1:
            what = f"{columns * wide} x {rows * high} texels are made fewer"
            self.lost.add("usd-texture-size", inputs[0].map.place, what)
        return max(int(wide * shrink), 1), max(int(high * shrink), 1)

    def read(
        self, inputs: Sequence[Fed], are_colors: Sequence[bool]
    ) -> tuple[object, list[np.ndarray], Placement]:
        """Texels of each input at one size, their dependencies, and their placement."""
        size, grid = self._size(inputs), _grid(inputs)
        planes = [self._texels(fed, is_color, size, grid) for fed, is_color in zip(inputs, are_colors)]
        return (tuple(inputs), size), planes, _placed(inputs[0].map.placement, grid)

    def _texels(self, fed: Fed, is_color: bool, size: tuple[int, int], grid: tuple[int, int]) -> np.ndarray:
        """Values of an input at each texel: UDIM tiles side by side, the first row at the bottom."""
        texture, (wide, high), (columns, rows) = fed.map, size, grid
        whole = np.zeros((rows * high, columns * wide, 3 if fed.output == "rgb" else 1), np.float32)
        for (column, row), path in texture.files:
            try:
                texels = self.textures.picture(path).texels(size, self.is_srgb(texture, is_color))
            except PictureError as error:
                self.lost.add("usd-texture", texture.place, f"a texture is black: {error}")
                continue
            texels = texels * np.clip(np.array(texture.scale, np.float32), -LARGEST, LARGEST) + np.array(
                texture.bias or (0.0,) * 4, np.float32
            )
            first = 0 if fed.output == "rgb" else "rgba".index(fed.output)
            top = (rows - 1 - row) * high
            whole[top : top + high, column * wide : (column + 1) * wide] = texels[
                ..., first : first + whole.shape[2]
            ]
        # One channel becomes all three of a colour.
        if fed.output == "rgb" or len(fed.numbers) == 3:
            return whole * np.array(fed.numbers, np.float32)
        return whole * fed.numbers[0]


def _grid(inputs: Sequence[Fed]) -> tuple[int, int]:
    """Columns and rows of tiles; equal numbers if the placement rotates, as it must not stretch."""
    tiles = [tile for fed in inputs for tile, _ in fed.map.files]
    columns, rows = 1 + max(column for column, _ in tiles), 1 + max(row for _, row in tiles)
    moved = inputs[0].map.placement.moved
    return (max(columns, rows),) * 2 if moved is not None and moved[1] else (columns, rows)


def _placed(placement: Placement, grid: tuple[int, int]) -> Placement:
    """Placement of all tiles together: coordinates of the first, lower left tile span one tile."""
    if grid == (1, 1):
        return placement
    columns, rows = grid
    (x, y), angle, (wide, high) = placement.moved or ((0.0, 0.0), 0.0, (1.0, 1.0))
    # glTF counts v from the top: v' = v / rows + 1 - 1 / rows.
    offset = (x / columns, y / rows + 1 - 1 / rows)
    return Placement(placement.layer, (offset, angle, (wide / columns, high / rows)), (CLAMP, CLAMP))
