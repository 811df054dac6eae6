"""Small pictures as PNG (third edition, W3C 2025), so that a report needs no package for them."""

import struct
import zlib

import numpy as np

from ..srgb import srgb_from_linear


def png(light: np.ndarray) -> bytes:
    """Rows of linear RGB as a file in sRGB; what is brighter than 1 is white, and what is no number black."""
    encoded = srgb_from_linear(np.clip(np.nan_to_num(light.astype(np.float32), nan=0.0), 0.0, 1.0))
    height, width, _ = light.shape
    rows = np.rint(encoded * 255).astype(np.uint8).reshape(height, 3 * width)
    # Each row less the one above ("Up", filter 2): gradients compress better so.
    above = np.vstack([np.zeros_like(rows[:1]), rows[:-1]])
    filtered = np.hstack([np.full((height, 1), 2, np.uint8), rows - above])
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    chunks = ((b"IHDR", head), (b"IDAT", zlib.compress(filtered.tobytes(), 6)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
        for kind, body in chunks
    )
