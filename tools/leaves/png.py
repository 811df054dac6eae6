"""PNG: rows of bytes in, a file out. Invariant: the same pixels give the same bytes."""

import struct
import zlib
from pathlib import Path


def filtered(row: bytes, above: bytes) -> bytes:
    """The row under whichever of the filters none, sub, up and Paeth leaves the smallest differences (PNG
    specification, 12.8)."""
    left = bytes(3) + row[:-3]
    above_left = bytes(3) + above[:-3]
    candidates = [
        (0, row),
        (1, bytes((x - a) & 255 for x, a in zip(row, left))),
        (2, bytes((x - b) & 255 for x, b in zip(row, above))),
        (4, bytes((x - paeth(a, b, c)) & 255 for x, a, b, c in zip(row, left, above, above_left))),
    ]
    kind, best = min(candidates, key=lambda candidate: sum(min(d, 256 - d) for d in candidate[1]))
    return bytes([kind]) + best


def paeth(a: int, b: int, c: int) -> int:
    """The neighbour nearest to a + b - c (PNG specification, 9.4)."""
    pa, pb, pc = abs(b - c), abs(a - c), abs(a + b - 2 * c)
    if pa <= pb and pa <= pc:
        return a
    return b if pb <= pc else c


def write_png(path: Path, rows: list[bytes], is_color: bool = True) -> None:
    """Writes 8-bit rows, three bytes a pixel, top row first: sRGB if they are colours, plain numbers else."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    above = [bytes(len(rows[0])), *rows]
    data = b"".join(filtered(row, previous) for row, previous in zip(rows, above))
    path.write_bytes(
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", struct.pack(">IIBBBBB", len(rows[0]) // 3, len(rows), 8, 2, 0, 0, 0))
        + (chunk(b"sRGB", b"\0") if is_color else b"")
        + chunk(b"IDAT", zlib.compress(data, 9))
        + chunk(b"IEND", b"")
    )
