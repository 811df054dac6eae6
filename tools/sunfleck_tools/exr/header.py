"""Headers of an EXR file, one a part. In go bytes, out come attributes.

For a damaged file OpenEXR only reports that it has no part 0; this parser reports the fault, before a
decoder allocates anything. Invariant: every length is checked against the existing bytes. Layout:
https://openexr.com/en/latest/OpenEXRFileLayout.html
"""

import struct
from dataclasses import dataclass, replace
from fractions import Fraction
from mmap import mmap
from typing import Any

MAGIC = b"\x76\x2f\x31\x01"
TILED, DEEP, MULTIPART = 0x200, 0x800, 0x1000
BYTES_OF_TYPE = {0: 4, 1: 2, 2: 4}  # uint, half, float
COMPRESSIONS = (
    "none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab", "htj2k256", "htj2k32", "lj2k", "zstd",
)  # fmt: skip
LONGEST_NAME = 255
STILL_TYPES = ("scanlineimage", "tiledimage")
"""Types of flat parts; the others are deep."""


class HeaderError(ValueError):
    """The bytes are not a header, or an incomplete one."""


@dataclass(frozen=True)
class Channel:
    """Channel as in the header."""

    name: str
    type: int
    sampling: tuple[int, int]


@dataclass(frozen=True)
class Header:
    """Header of a part; `end` is the offset of its chunk table, which in a file of one part follows the
    header."""

    flags: int
    values: dict[str, object]
    channels: tuple[Channel, ...]
    data_window: tuple[int, int, int, int]
    display_window: tuple[int, int, int, int]
    compression: int
    end: int

    @property
    def name(self) -> str:
        """Name of the part; empty for a single part without one."""
        return self.text("name") or ""

    @property
    def is_multipart(self) -> bool:
        """True for a multi-part file, even with one part."""
        return bool(self.flags & MULTIPART)

    @property
    def is_tiled(self) -> bool:
        """True if chunks are tiles."""
        return (
            self.text("type") in ("tiledimage", "deeptile") if self.is_multipart else bool(self.flags & TILED)
        )

    @property
    def is_deep(self) -> bool:
        """True if the part is deep."""
        return self.text("type") not in STILL_TYPES if self.is_multipart else bool(self.flags & DEEP)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the data window."""
        return window_size(self.data_window)

    @property
    def pixel_bytes(self) -> int:
        """Decoded bytes of all channels at full resolution."""
        width, height = self.size
        return width * height * sum(BYTES_OF_TYPE[channel.type] for channel in self.channels)

    def text(self, name: str) -> str | None:
        """Value of a string attribute."""
        value = self.values.get(name)
        return value if isinstance(value, str) else None


def window_size(window: tuple[int, int, int, int]) -> tuple[int, int]:
    """Width and height of a window."""
    left, top, right, bottom = window
    return right - left + 1, bottom - top + 1


def parse_header(data: bytes | mmap) -> Header:
    """Header of the first part of `data`; raises `HeaderError`."""
    return parse_headers(data)[0]


def parse_headers(data: bytes | mmap) -> tuple[Header, ...]:
    """Headers of all parts, in the file's order; raises `HeaderError`."""
    if not data:
        raise HeaderError("the file is empty")
    if data[:4] != MAGIC:
        raise HeaderError("it does not begin like an EXR file")
    if len(data) < 8:
        raise HeaderError("the file ends within its header")
    version, flags = data[4], struct.unpack_from("<I", data, 4)[0]
    if version != 2:
        raise HeaderError(f"it has format version {version}, not 2")
    if not flags & MULTIPART:
        values, end = _attributes(data, 8)
        return (_header(flags, values, end),)
    at, headers = 8, []
    # An empty header ends the list.
    while data[at : at + 1] != b"\0":
        values, at = _attributes(data, at)
        headers.append(_header(flags, values, at))
    if not headers:
        raise HeaderError("the file has no part")
    return _with_tables(headers, at + 1)


def _with_tables(headers: list[Header], at: int) -> tuple[Header, ...]:
    """Headers with the offsets of their chunk tables, the first at `at`."""
    placed = []
    for header in headers:
        count = header.values.get("chunkCount")
        if not isinstance(count, int) or count < 1:
            raise HeaderError(f"the part `{header.name}` has no chunkCount")
        placed.append(replace(header, end=at))
        at += 8 * count
    return tuple(placed)


def _attributes(data: bytes | mmap, at: int) -> tuple[dict[str, object], int]:
    """Attributes of a header by name, and the offset after it."""
    values: dict[str, object] = {}
    while True:
        name, at = _name(data, at)
        if not name:
            return values, at
        kind, at = _name(data, at)
        (size,) = struct.unpack("<i", _take(data, at, 4))
        if size < 0:
            raise HeaderError(f"the attribute `{name}` has the size {size}")
        raw = _take(data, at + 4, size)
        at += 4 + size
        try:
            values[name] = _value(kind, raw)
        except (struct.error, ValueError) as error:
            raise HeaderError(f"the attribute `{name}` is damaged") from error


def _header(flags: int, values: dict[str, object], end: int) -> Header:
    def required(name: str, kind: type) -> Any:
        if not isinstance(values.get(name), kind):
            raise HeaderError(f"the header has no {name}")
        return values[name]

    channels = required("channels", tuple)
    data, display = required("dataWindow", tuple), required("displayWindow", tuple)
    compression = required("compression", int)
    if data[2] < data[0] or data[3] < data[1]:
        raise HeaderError("the data window is empty or inside out")
    if not channels or any(channel.type not in BYTES_OF_TYPE for channel in channels):
        raise HeaderError("there are no channels, or channels of an unknown type")
    if any(step < 1 for channel in channels for step in channel.sampling):
        raise HeaderError("a channel has samples every 0 pixels")
    if compression >= len(COMPRESSIONS):
        raise HeaderError(f"the compression {compression} is unknown")
    return Header(flags, values, channels, data, display, compression, end)


def _take(data: bytes | mmap, at: int, size: int) -> bytes:
    if at + size > len(data):
        raise HeaderError("the file ends within its header")
    return data[at : at + size]


def _name(data: bytes | mmap, at: int) -> tuple[str, int]:
    end = data.find(b"\0", at, at + LONGEST_NAME + 1)
    if end < 0:
        raise HeaderError(
            "the file ends within its header" if at + LONGEST_NAME >= len(data) else "a name has no end"
        )
    return data[at:end].decode("utf-8", "replace"), end + 1


LAYOUTS = {
    "int": "<i", "float": "<f", "double": "<d", "compression": "<B", "lineOrder": "<B", "box2i": "<4i", "chromaticities": "<8f",
    "tiledesc": "<IIB", "rational": "<iI", "timecode": "<II",
}  # fmt: skip
"""Types of attributes with a fixed number of numbers."""


def _value(kind: str, raw: bytes) -> object:
    if kind == "string":
        return raw.decode("utf-8", "replace")
    if kind == "chlist":
        return _channels(raw)
    if kind not in LAYOUTS:
        return raw
    first, *others = numbers = struct.unpack(LAYOUTS[kind], raw)
    if kind == "rational":
        return Fraction(*numbers) if others[0] else raw
    if kind == "timecode":
        return TimeCode(first)
    return numbers if others else first


@dataclass(frozen=True)
class TimeCode:
    """SMPTE 12M time and flags: binary-coded decimals."""

    packed: int

    def frame(self, fps: int) -> int:
        """Frames since 00:00:00:00, without drop frames."""

        def decimal(shift: int, tens_bits: int) -> int:
            return (self.packed >> shift & 15) + 10 * (self.packed >> (shift + 4) & ((1 << tens_bits) - 1))

        frames, seconds, minutes, hours = decimal(0, 2), decimal(8, 3), decimal(16, 3), decimal(24, 2)
        return ((hours * 60 + minutes) * 60 + seconds) * fps + frames


def _channels(raw: bytes) -> tuple[Channel, ...]:
    channels: list[Channel] = []
    at = 0
    while True:
        name, at = _name(raw, at)
        if not name:
            return tuple(channels)
        kind, _linear, x, y = struct.unpack("<iB3xii", _take(raw, at, 16))
        channels.append(Channel(name, kind, (x, y)))
        at += 16
