"""Decoding of texture files, and encoding as PNG.

In go bytes of PNG, JPEG, TGA, WebP, TIFF, BMP or OpenEXR, out come rows of red, green, blue and alpha.
Invariant: an image whose header exceeds the limits is not decoded; any other fault of a file is a
`PictureError` with a message.
"""

import io
import tempfile
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image
from pxr import Ar

from ...exr.decode import DecodeError, claims_too_much, decode
from ...exr.header import MAGIC, HeaderError, parse_headers
from ...srgb import linear_from_srgb

MOST_BYTES = 2**29
"""Maximum bytes of a file."""
MOST_TEXELS = 2**27
"""Maximum texels in a header: 16384 x 8192."""
MOST_FLOATS = 2**25
"""Maximum texels of OpenEXR: 8192 x 4096."""
CARRIED = ("PNG", "JPEG")
"""Formats that glTF supports."""
CARRIED_MODES = ("1", "L", "LA", "P", "RGB", "RGBA", "I;16", "I")
"""Pillow's modes that every reader of these formats supports: not CMYK."""
QUICKLY = 1
"""Level of zlib: a fifth of the default's time, for an eighth more bytes."""
TAKEN = ("PNG", "JPEG", "TGA", "WEBP", "TIFF", "BMP")


class PictureError(Exception):
    """A picture cannot be read; the message has the reason."""


@dataclass(frozen=True)
class Picture:
    """File with its header's data: Pillow's format name (or `EXR`), width and height, channels, bits of
    each."""

    path: str
    data: bytes
    form: str
    size: tuple[int, int]
    channels: int
    bits: int
    is_carried: bool

    def texels(self, size: tuple[int, int], is_srgb: bool) -> np.ndarray:
        """Rows of linear RGBA at a width and height: 0 to 1 for integers, any value for floats. Raises
        `PictureError`."""
        found = _exr_texels(self.data) if self.form == "EXR" else _pillow_texels(self.data, size)
        if found.dtype == np.uint8:
            # A table, as there are only 256 values.
            levels = np.arange(256, dtype=np.float32) / 255
            color = linear_from_srgb(levels) if is_srgb else levels
            found = np.concatenate([color[found[..., :3]], levels[found[..., 3:]]], axis=-1)
        elif is_srgb:
            found = np.concatenate([linear_from_srgb(found[..., :3]), found[..., 3:]], axis=-1)
        return resized(found, size)


def open_picture(resolved: str) -> Picture:
    """Reads the header of a file, which may be in a package. Raises `PictureError`."""
    opened = Ar.GetResolver().OpenAsset(Ar.ResolvedPath(resolved)) if resolved else None
    if not opened:
        raise PictureError("there is no such file")
    if opened.GetSize() > MOST_BYTES:
        raise PictureError(f"has {opened.GetSize()} bytes, more than {MOST_BYTES}")
    data = bytes(opened.GetBuffer() or b"")
    return _exr_head(resolved, data) if data.startswith(MAGIC) else _pillow_head(resolved, data)


def _checked(size: tuple[int, int], most: int) -> tuple[int, int]:
    if min(size) < 1 or size[0] * size[1] > most:
        raise PictureError(
            f"claims {size[0]} x {size[1]} texels, and {most} are read at most: make it smaller"
        )
    return size


def _exr_head(resolved: str, data: bytes) -> Picture:
    try:
        headers = parse_headers(data)
    except HeaderError as error:
        raise PictureError(f"is a damaged OpenEXR file: {error}") from None
    if fault := claims_too_much(headers, len(data)):
        raise PictureError(fault)
    size = _checked(headers[0].size, MOST_FLOATS)
    return Picture(resolved, data, "EXR", size, min(len(headers[0].channels), 4), 32, False)


def _exr_texels(data: bytes) -> np.ndarray:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "texture.exr"
        path.write_bytes(data)
        try:
            channels = decode(path)
        except DecodeError as error:
            raise PictureError(f"cannot be decoded: {error}") from None
    grey = channels.get("Y", next(iter(channels.values())))
    rows = [channels.get(name, grey if name != "A" else np.ones_like(grey)) for name in "RGBA"]
    if len({row.shape for row in rows}) > 1:
        raise PictureError("has channels of different sizes")
    return np.nan_to_num(np.stack(rows, axis=-1).astype(np.float32), nan=0.0, posinf=65504.0, neginf=0.0)


def _pillow_head(resolved: str, data: bytes) -> Picture:
    with _opened(data) as image:
        channels = len(image.getbands()) if image.mode != "P" else 3 + image.has_transparency_data
        is_deep = image.mode.startswith("I") or (image.format == "PNG" and data[24] == 16)
        bits = 16 if is_deep else 32 if image.mode == "F" else 8
        is_carried = image.format in CARRIED and image.mode in CARRIED_MODES
        size = _checked(image.size, MOST_TEXELS)
        picture = Picture(resolved, data, image.format or "", size, channels, bits, is_carried)
    if is_carried:
        _verify(data)
    return picture


def _verify(data: bytes) -> None:
    """Checks quickly that an unchanged file can be decoded."""
    with _opened(data) as image:
        if image.format == "PNG":
            image.verify()
        else:
            image.draft("L", (max(image.width // 8, 1), max(image.height // 8, 1)))
            image.load()


def _pillow_texels(data: bytes, size: tuple[int, int]) -> np.ndarray:
    """Texels as stored: bytes, or floats from 0 to 1 for more bits."""
    with _opened(data) as image:
        if image.mode == "F":
            grey: np.ndarray = np.asarray(image, np.float32)
        elif image.mode.startswith("I"):
            grey = np.asarray(image, np.float32) / 65535
        else:
            colors = image.convert("RGBA")
            if size[0] * size[1] < image.width * image.height:
                # Resized as bytes, as floats take four times the memory.
                colors = colors.resize(size, Image.Resampling.BILINEAR)
            return np.asarray(colors)
    return np.stack([grey, grey, grey, np.ones_like(grey)], axis=-1)


class _opened:
    """Pillow's image of bytes; its errors become `PictureError`."""

    def __init__(self, data: bytes):
        self.data = data

    def __enter__(self) -> Image.Image:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                self.image = Image.open(io.BytesIO(self.data), formats=TAKEN)
        except Image.DecompressionBombError:
            raise PictureError(
                f"claims more texels than the {MOST_TEXELS} that are read at most: make it smaller"
            ) from None
        except Image.UnidentifiedImageError:
            raise PictureError(f"is none of OpenEXR, {', '.join(TAKEN)}: convert it") from None
        except (OSError, SyntaxError, ValueError) as error:
            raise PictureError(f"is damaged: {error}") from None
        return self.image

    def __exit__(self, kind, error, trace) -> None:
        self.image.close()
        if isinstance(error, (OSError, SyntaxError, ValueError, EOFError, MemoryError)):
            raise PictureError(f"is damaged: {error}") from None


def resized(texels: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Texels at another width and height: averages for fewer, linear interpolation for more."""
    if (texels.shape[1], texels.shape[0]) == size:
        return texels
    planes = [
        Image.fromarray(np.ascontiguousarray(texels[..., channel], np.float32))
        for channel in range(texels.shape[2])
    ]
    return np.stack([np.asarray(plane.resize(size, Image.Resampling.BILINEAR)) for plane in planes], axis=-1)


def png(texels: np.ndarray) -> bytes:
    """Encodes RGB or RGBA from 0 to 1, rounded to 256 levels."""
    file = io.BytesIO()
    Image.fromarray(np.round(np.clip(texels, 0, 1) * 255).astype(np.uint8)).save(
        file, "PNG", compress_level=QUICKLY
    )
    return file.getvalue()
