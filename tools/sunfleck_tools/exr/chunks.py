"""The chunks of a flat scan-line file: all there, each where the table says, none cut off.

Invariant: nothing is decompressed, and no more is read than the file holds.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from mmap import mmap

from .header import Header

ROWS_OF_COMPRESSION = {0: 1, 1: 1, 2: 1, 3: 16, 4: 32, 5: 16, 6: 32, 7: 32, 8: 32, 9: 256, 10: 256, 11: 32}


def chunk_faults(header: Header, data: bytes | mmap) -> Iterator[str]:
    """A sentence for each chunk that is not whole."""
    rows = ROWS_OF_COMPRESSION.get(header.compression)
    if rows is None:
        return
    top, height = header.data_window[1], header.size[1]
    count = -(-height // rows)
    table_end = header.end + 8 * count
    if table_end > len(data):
        yield f"the file ends within its table of {count} chunks"
        return
    for index, offset in enumerate(struct.unpack_from(f"<{count}Q", data, header.end)):
        y = top + index * rows
        last = min(y + rows, top + height) - 1
        name = f"chunk {index + 1} of {count} (rows {y} to {last})"
        if offset == 0:
            yield f"{name} was never written"
        elif offset < table_end or offset + 8 > len(data):
            yield f"{name} lies outside of the file, at byte {offset} of {len(data)}"
        else:
            begins, size = struct.unpack_from("<ii", data, offset)
            if begins != y:
                yield f"{name} says that it begins at row {begins}"
            elif size <= 0 or offset + 8 + size > len(data):
                yield f"{name} has {size} bytes, of which the file holds {len(data) - offset - 8}"
