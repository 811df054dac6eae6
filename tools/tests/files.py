"""Sequences and single files for the tests, made from a few good frames in `data`.

What OpenEXR for Python cannot write (rational numbers) is put into the bytes here.
"""

import shutil
import struct
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import numpy as np
import OpenEXR

from sunfleck_tools.exr.decode import decode
from sunfleck_tools.exr.file_hash import HEAD, file_hash
from sunfleck_tools.exr.header import parse_header
from sunfleck_tools.exr.pixel_hash import pixel_hash

DATA = Path(__file__).parent / "data"
TEXTS = ("version", "sceneHash", "settingsHash", "seed", "samples", "pixelHash")
Channels = dict[str, np.ndarray]


def good_sequence(folder: Path, name: str = "leaf") -> Path:
    """Copies the good frames of that name into `folder`, which is made."""
    folder.mkdir(parents=True, exist_ok=True)
    for path in sorted(DATA.glob(f"{name}.*.exr")):
        shutil.copy(path, folder / path.name)
    return folder


def frame_path(folder: Path, number: int, name: str = "leaf") -> Path:
    """The file of a frame of `good_sequence`."""
    return folder / f"{name}.{number:04d}.exr"


def rewrite(
    path: Path,
    pixels: Callable[[Channels], Channels | None] = lambda channels: None,
    texts: dict[str, str] | None = None,
    fps: Fraction | None = Fraction(24),
    counter: int | None = None,
    compression: int = 3,
    extra: dict[str, object] | None = None,
    sign: bool = True,
) -> None:
    """Decodes a file, changes it, and writes it with a pixel hash that fits (unless not `sign`ed)."""
    header = parse_header(path.read_bytes())
    channels = {name: values.copy() for name, values in decode(path).items()}
    channels = pixels(channels) or channels
    attributes: dict[str, object] = {f"sunfleck:{name}": header.text(f"sunfleck:{name}") for name in TEXTS}
    attributes.update({f"sunfleck:{name}": value for name, value in (texts or {}).items()})
    attributes["imageCounter"] = header.values["imageCounter"] if counter is None else counter
    attributes.update(
        compression=OpenEXR.Compression(compression), type=OpenEXR.scanlineimage, **(extra or {})
    )
    attributes = {name: value for name, value in attributes.items() if value is not None}
    if sign:
        # Lossy compressions: the hash is of what comes back.
        _write(path, attributes, channels)
        attributes["sunfleck:pixelHash"] = pixel_hash(decode(path))
    _write(path, attributes, channels)
    if fps is not None:
        add_attribute(path, "framesPerSecond", "rational", struct.pack("<iI", fps.numerator, fps.denominator))


def _write(path: Path, attributes: dict[str, object], channels: Channels) -> None:
    stored = {name: OpenEXR.Channel(np.ascontiguousarray(values), 1, 1) for name, values in channels.items()}
    with OpenEXR.File(dict(attributes), stored) as file:
        file.write(str(path))


def add_attribute(path: Path, name: str, kind: str, value: bytes) -> None:
    """Puts an attribute at the end of a header and moves all chunks."""
    data = path.read_bytes()
    end = parse_header(data).end
    record = name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value
    (first,) = struct.unpack_from("<Q", data, end)
    count = (first - end) // 8
    offsets = [offset + len(record) for offset in struct.unpack_from(f"<{count}Q", data, end)]
    path.write_bytes(data[: end - 1] + record + b"\0" + struct.pack(f"<{count}Q", *offsets) + data[first:])


def seal(path: Path) -> None:
    """Gives a file the hash of all its bytes, as the renderer does."""
    add_attribute(path, "sunfleck:fileHash", "string", b"0" * 64)
    data = path.read_bytes()
    path.write_bytes(data.replace(HEAD + b"0" * 64, HEAD + file_hash(data)[1].encode()))


def flip(path: Path, at: int, bits: int = 0xFF) -> None:
    """Flips bits of a byte; negative places count from the end."""
    data = bytearray(path.read_bytes())
    data[at] ^= bits
    path.write_bytes(bytes(data))


def marked_sky(path: Path) -> None:
    """An image of the sky that tells in red how far to the right, in green how far down one looks."""
    right, down = np.meshgrid(
        (np.arange(64, dtype=np.float32) + 0.5) / 64, (np.arange(32, dtype=np.float32) + 0.5) / 32
    )
    with OpenEXR.File(
        {"type": OpenEXR.scanlineimage}, {"R": right, "G": down, "B": np.ones_like(right)}
    ) as file:
        file.write(str(path))


def write_frame(path: Path, channels: Channels, **header: object) -> Path:
    """A frame as another renderer writes it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    attributes = {"type": OpenEXR.scanlineimage, "compression": OpenEXR.ZIP_COMPRESSION, **header}
    stored = {name: OpenEXR.Channel(np.ascontiguousarray(values)) for name, values in channels.items()}
    with OpenEXR.File(attributes, stored) as file:
        file.write(str(path))
    return path


def write_sampled(path: Path, channels: dict[str, tuple[np.ndarray, int]], width: int, height: int) -> Path:
    """An uncompressed frame of floats, each channel with a value every so many pixels, each way; OpenEXR for
    Python writes none."""

    def attribute(name: str, kind: str, value: bytes) -> bytes:
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value

    named = sorted(channels.items())
    listed = (
        b"".join(
            name.encode() + b"\0" + struct.pack("<iB3xii", 2, 0, step, step) for name, (_, step) in named
        )
        + b"\0"
    )
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    header = (
        b"\x76\x2f\x31\x01\x02\0\0\0"
        + attribute("channels", "chlist", listed)
        + attribute("compression", "compression", b"\0")
    )
    header += attribute("dataWindow", "box2i", window) + attribute("displayWindow", "box2i", window)
    header += attribute("lineOrder", "lineOrder", b"\0") + attribute(
        "pixelAspectRatio", "float", struct.pack("<f", 1)
    )
    header += (
        attribute("screenWindowCenter", "v2f", bytes(8))
        + attribute("screenWindowWidth", "float", struct.pack("<f", 1))
        + b"\0"
    )
    chunks = []
    for y in range(height):
        row = b"".join(
            values[y // step].astype("<f4").tobytes() for _, (values, step) in named if y % step == 0
        )
        chunks.append(struct.pack("<2i", y, len(row)) + row)
    at = len(header) + 8 * height
    offsets = [at + sum(map(len, chunks[:y])) for y in range(height)]
    path.write_bytes(header + struct.pack(f"<{height}Q", *offsets) + b"".join(chunks))
    return path


def write_parts(path: Path, parts: dict[str, Channels]) -> Path:
    """A frame of several parts by name."""
    made = []
    height, width = next(iter(next(iter(parts.values())).values())).shape
    for name, channels in parts.items():
        header = {"name": name, "type": OpenEXR.scanlineimage, "compression": OpenEXR.ZIP_COMPRESSION}
        header["displayWindow"] = (np.array([0, 0], np.int32), np.array([width - 1, height - 1], np.int32))
        made.append(
            OpenEXR.Part(
                header, {key: OpenEXR.Channel(np.ascontiguousarray(v)) for key, v in channels.items()}, name
            )
        )
    with OpenEXR.File(made) as file:
        file.write(str(path))
    return path


def scene(number: int, width: int = 64, height: int = 48) -> Channels:
    """RGBA of a ball that moves across a lit ground, frame by frame; no two frames are alike,
    nothing is black."""
    x, y = np.meshgrid(np.arange(width), np.arange(height))
    ball = np.exp(-((x - 12 - 3 * number) ** 2 + (y - height / 2) ** 2) / 60)
    light = 0.1 + 0.2 * y / height + ball
    channels = {
        name: (light * share).astype(np.float16) for name, share in (("R", 1.0), ("G", 0.7), ("B", 0.4))
    }
    return {**channels, "A": np.ones((height, width), np.float16)}
