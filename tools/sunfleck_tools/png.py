"""Rows of RGB bytes as PNG, and many of them as an animated one.

Formats: PNG third edition (W3C 2025), chunks acTL, fcTL and fdAT for what moves.
"""

from __future__ import annotations

import struct
import zlib
from fractions import Fraction
from typing import BinaryIO

import numpy as np

SIGNATURE = b"\x89PNG\r\n\x1a\n"
UP = 2
"""The filter of all rows: each less the one above."""


def png(pixels: np.ndarray) -> bytes:
    """A picture as a file."""
    return SIGNATURE + _head(pixels.shape) + _chunk(b"IDAT", _packed(pixels)) + _chunk(b"IEND", b"")


class AnimatedPng:
    """A file that is written frame by frame; programs that know no animation show the first."""

    def __init__(self, file: BinaryIO, frames: int, fps: Fraction):
        self._file, self._frames, self._fps = file, frames, fps
        self._sequence = 0

    def add(self, pixels: np.ndarray) -> None:
        """The next frame, of the same size as the first."""
        height, width, _ = pixels.shape
        if self._sequence == 0:
            # Played for ever.
            self._file.write(
                SIGNATURE + _head(pixels.shape) + _chunk(b"acTL", struct.pack(">II", self._frames, 0))
            )
        delay = 1 / self._fps.limit_denominator(65535)
        control = struct.pack(">IIIIHHBB", width, height, 0, 0, delay.numerator, delay.denominator, 0, 0)
        self._file.write(_chunk(b"fcTL", self._number() + control))
        packed = _packed(pixels)
        if self._sequence == 1:
            self._file.write(_chunk(b"IDAT", packed))
        else:
            self._file.write(_chunk(b"fdAT", self._number() + packed))

    def close(self) -> None:
        """The end of the file."""
        self._file.write(_chunk(b"IEND", b""))

    def _number(self) -> bytes:
        self._sequence += 1
        return struct.pack(">I", self._sequence - 1)


def _head(shape: tuple[int, ...]) -> bytes:
    return _chunk(b"IHDR", struct.pack(">IIBBBBB", shape[1], shape[0], 8, 2, 0, 0, 0))


def _packed(pixels: np.ndarray) -> bytes:
    height, width, _ = pixels.shape
    rows = np.empty((height, 1 + 3 * width), np.uint8)
    rows[:, 0] = UP
    flat = pixels.reshape(height, 3 * width)
    rows[0, 1:] = flat[0]
    np.subtract(flat[1:], flat[:-1], out=rows[1:, 1:])
    return zlib.compress(rows.tobytes(), 6)


def _chunk(kind: bytes, body: bytes) -> bytes:
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
