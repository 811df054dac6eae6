"""PNG files to arrays: what the package and the renderer write, nothing else."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator

import numpy as np


def chunks(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Kinds and bodies, their checksums asked."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at = 8
    while at < len(data):
        (size,) = struct.unpack_from(">I", data, at)
        kind, body = data[at + 4 : at + 8], data[at + 8 : at + 8 + size]
        assert struct.unpack_from(">I", data, at + 8 + size)[0] == zlib.crc32(kind + body)
        yield kind, body
        at += 12 + size


def pixels(data: bytes) -> np.ndarray:
    """The (first) picture: 8 bits, RGB, not interlaced."""
    found = list(chunks(data))
    width, height, bits, colors, *rest = struct.unpack(">IIBBBBB", found[0][1])
    assert (bits, colors, rest) == (8, 2, [0, 0, 0])
    return unpacked(b"".join(body for kind, body in found if kind == b"IDAT"), height, width)


def unpacked(packed: bytes, height: int, width: int) -> np.ndarray:
    """Rows of one picture, their filters undone (PNG, section 9)."""
    rows = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 1 + 3 * width)
    result = np.zeros((height, 3 * width), np.uint8)
    before = np.zeros(3 * width, np.uint8)
    for y, row in enumerate(rows):
        kind, line = row[0], row[1:].copy()
        if kind == 2:
            line += before
        elif kind:
            for x in range(3 * width):
                left = int(line[x - 3]) if x >= 3 else 0
                corner = int(before[x - 3]) if x >= 3 else 0
                above = int(before[x])
                nearest = min((left, above, corner), key=lambda value: abs(left + above - corner - value))
                line[x] = (int(line[x]) + {1: left, 3: (left + above) // 2, 4: nearest}[int(kind)]) % 256
        result[y] = before = line
    return result.reshape(height, width, 3)
