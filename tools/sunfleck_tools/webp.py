"""Pictures as an animated WebP, by Pillow.

Invariant: a frame begins within half a millisecond of its time, however many there are:
WebP counts whole ones.
"""

from __future__ import annotations

from fractions import Fraction
from typing import BinaryIO

import numpy as np

from .errors import ToolError

MOST_BYTES = 2 << 30
"""Of pictures: Pillow wants all of them at the same time."""


class Webp:
    """A file that is written once all pictures are there."""

    QUALITY = 85

    def __init__(self, file: BinaryIO, fps: Fraction):
        self._file, self._fps = file, fps
        self._pictures: list = []
        self._bytes = 0

    def add(self, pixels: np.ndarray) -> None:
        """The next picture."""
        from PIL import Image

        self._bytes += pixels.nbytes
        if self._bytes > MOST_BYTES:
            raise ToolError(
                f"{len(self._pictures)} frames of this size are all that Pillow can hold: choose a smaller "
                "--width, or install ffmpeg"
            )
        self._pictures.append(Image.fromarray(pixels))

    def close(self) -> None:
        """Writes all, played for ever."""
        if not self._pictures:
            return
        starts = [round(1000 * index / self._fps) for index in range(len(self._pictures) + 1)]
        durations = [end - start for start, end in zip(starts, starts[1:])]
        first, *others = self._pictures
        first.save(
            self._file,
            "WEBP",
            save_all=True,
            append_images=others,
            duration=durations,
            loop=0,
            quality=self.QUALITY,
            method=4,
        )
