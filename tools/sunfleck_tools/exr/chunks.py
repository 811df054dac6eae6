"""Checks of the chunks of flat parts: present, at their offsets, complete, and not overwritten by zeros.

Invariant: nothing is decompressed, and no more is read than the file holds. Layout:
https://openexr.com/en/latest/OpenEXRFileLayout.html
"""

import struct
from collections.abc import Iterator
from mmap import mmap

from .header import BYTES_OF_TYPE, Header

ROWS_OF_COMPRESSION = {0: 1, 1: 1, 2: 1, 3: 16, 4: 32, 5: 16, 6: 32, 7: 32, 8: 32, 9: 256, 10: 256, 11: 32}
PIZ = 4
ONE_LEVEL = 0
LONGEST_ZEROS = 32
"""Length of a run of zero bytes that entropy coding never produces, as runs are coded as symbol and count."""


def chunk_faults(header: Header, data: bytes | mmap, part: int = 0) -> Iterator[str]:
    """Sentence for each damaged chunk of the part."""
    places = _places(header)
    if places is None:
        return
    table_end = header.end + 8 * len(places)
    if table_end > len(data):
        yield f"the file ends within its table of {len(places)} chunks"
        return
    in_part = f" of part `{header.name}`" if header.is_multipart else ""
    for index, offset in enumerate(struct.unpack_from(f"<{len(places)}Q", data, header.end)):
        name = f"chunk {index + 1} of {len(places)}{in_part} ({_words(header, places[index])})"
        if offset == 0:
            yield f"{name} was never written"
        elif offset < table_end or offset + _leader_bytes(header) > len(data):
            yield f"{name} lies outside of the file, at byte {offset} of {len(data)}"
        else:
            for fault in _chunk_fault(header, data, part, offset, places[index]):
                yield f"{name} {fault}"


Place = tuple[int, ...]
"""Place in a chunk's leader: its first row; or column and row of the tile, and level in x and y."""


def _places(header: Header) -> list[Place] | None:
    """Place of each chunk in the order of the table; `None` if the order is unknown."""
    top, (width, height) = header.data_window[1], header.size
    if not header.is_tiled:
        rows = ROWS_OF_COMPRESSION.get(header.compression)
        return None if rows is None else [(y,) for y in range(top, top + height, rows)]
    described = header.values.get("tiles")
    # Coarser levels are not shown, nor checked.
    if not isinstance(described, tuple) or min(described[:2]) < 1 or described[2] & 15 != ONE_LEVEL:
        return None
    columns, rows = -(-width // described[0]), -(-height // described[1])
    return [(x, y, 0, 0) for y in range(rows) for x in range(columns)]


def _words(header: Header, place: Place) -> str:
    if header.is_tiled:
        return f"tile {place[0]}, {place[1]}"
    last = min(place[0] + ROWS_OF_COMPRESSION[header.compression], header.data_window[3] + 1) - 1
    return f"rows {place[0]} to {last}"


def _leader_bytes(header: Header) -> int:
    return (4 if header.is_multipart else 0) + (20 if header.is_tiled else 8)


def _chunk_fault(header: Header, data: bytes | mmap, part: int, offset: int, place: Place) -> Iterator[str]:
    """Fault of a chunk whose leader lies within the file."""
    if header.is_multipart:
        (said,) = struct.unpack_from("<i", data, offset)
        if said != part:
            yield f"says that it belongs to part {said}, not {part}"
            return
        offset += 4
    *begins, size = struct.unpack_from("<5i" if header.is_tiled else "<2i", data, offset)
    at = offset + (20 if header.is_tiled else 8)
    if tuple(begins) != place:
        found = (
            f"row {begins[0]}"
            if len(begins) == 1
            else f"tile {begins[0]}, {begins[1]} of level {begins[2]}, {begins[3]}"
        )
        yield f"says that it begins at {found}"
    elif size <= 0 or at + size > len(data):
        yield f"has {size} bytes, of which the file holds {len(data) - at}"
    elif header.compression == PIZ and size < _raw_bytes(header, place):
        zeros = _blotted_out(data[at : at + size])
        if zeros is not None:
            yield f"has {LONGEST_ZEROS} zeros and more in a row at byte {at + zeros}, which PIZ does not write"


def _raw_bytes(header: Header, place: Place) -> int:
    """Uncompressed size of a chunk, as which it is stored if compression does not help."""
    left, top, right, bottom = header.data_window
    if header.is_tiled:
        described = header.values["tiles"]
        assert isinstance(described, tuple), "of others the places are not known"
        wide, high, _ = described
        columns = min(wide, right - left + 1 - place[0] * wide)
        rows = min(high, bottom - top + 1 - place[1] * high)
    else:
        columns, rows = right - left + 1, min(ROWS_OF_COMPRESSION[PIZ], bottom + 1 - place[0])
    return sum(
        BYTES_OF_TYPE[c.type] * -(-columns // c.sampling[0]) * -(-rows // c.sampling[1])
        for c in header.channels
    )


def _blotted_out(chunk: bytes) -> int | None:
    """Position of zeros in the coded part of a PIZ chunk: after the bitmap of values
    (ImfPizCompressor.cpp)."""
    if len(chunk) < 4:
        return None
    first, last = struct.unpack_from("<2H", chunk)
    # After the bitmap follow a length (4 bytes) and 5 numbers, the last of which is 0.
    start = 4 + max(0, last - first + 1) + 4 + 20
    found = chunk.find(bytes(LONGEST_ZEROS), start)
    return None if found < 0 else found
