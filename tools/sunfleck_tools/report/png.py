"""PNG encoder for small pictures (third edition, W3C 2025), so that a report needs no package."""

import struct
import zlib

import numpy as np

from ..srgb import srgb_from_linear


def png(light: np.ndarray) -> bytes:
    """Encodes rows of linear RGB in sRGB; values above 1 are white, and NaN is black."""
    encoded = srgb_from_linear(np.clip(np.nan_to_num(light.astype(np.float32), nan=0.0), 0.0, 1.0))
    height, width, _ = light.shape
    rows = np.rint(encoded * 255).astype(np.uint8).reshape(height, 3 * width)
    # Filter 2 ("Up"), the difference from the row above, compresses gradients better.
    above = np.vstack([np.zeros_like(rows[:1]), rows[:-1]])
    filtered = np.hstack([np.full((height, 1), 2, np.uint8), rows - above])
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    chunks = ((b"IHDR", head), (b"IDAT", zlib.compress(filtered.tobytes(), 6)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
        for kind, body in chunks
    )
