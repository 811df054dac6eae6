"""A linear picture to the bytes of a PNG in sRGB."""

from __future__ import annotations

import struct
import zlib

import numpy as np


def srgb(linear: np.ndarray) -> np.ndarray:
    """IEC 61966-2-1, as bytes; values outside of 0 to 1 are clipped."""
    value = np.clip(np.nan_to_num(linear.astype(np.float32)), 0.0, 1.0)
    curved = np.where(value <= 0.0031308, 12.92 * value, 1.055 * np.power(value, 1 / 2.4) - 0.055)
    return np.rint(255 * curved).astype(np.uint8)


def png(pixels: np.ndarray) -> bytes:
    """Rows of RGB bytes as PNG."""
    height, width, _ = pixels.shape
    rows = b"".join(b"\0" + row.tobytes() for row in pixels)

    def chunk(kind: bytes, body: bytes) -> bytes:
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows, 6)) + chunk(b"IEND", b"")
