"""Pictures of the file: Blender's own image files if they are PNG, JPEG or WebP with the right contents, else
new files.

In go images and channels, out come indices of glTF images. Invariant: colours are in sRGB, data are
linear; new files have 16 bits a channel unless the source has 8.
"""

import struct
import zlib
from dataclasses import replace
from pathlib import Path

import bpy
import numpy

from ..evaluated.document import Document
from . import sources
from .colours import rec709

KINDS = {b"\x89PNG": "image/png", b"\xff\xd8\xff": "image/jpeg"}
# Blender's names of colour spaces: with sRGB's curve, and for data.
IN_SRGB = {"sRGB"}
# Difference of light that is not worth a new file.
UNSEEN = 1e-3
PLAIN = {"Non-Color"}


class Images:
    """Images of a document, each once."""

    def __init__(self, document: Document):
        self.document, self.known, self.pixels_of = document, {}, {}

    def whole(self, picture, is_color, is_deep=False):
        """Image with all its channels, colours or data; None if it cannot be read. Baked images have 8
        bits, or 16 if `is_deep`."""
        image, is_as_it_is = picture.image, self.is_as_it_is(picture)
        key = (image, is_color, is_as_it_is or picture.by_alpha)
        if key not in self.known:
            is_baked = hasattr(image, "values_of_texels")
            data = None if is_baked or not is_as_it_is else self.own_bytes(image, is_color)
            if data is None:
                pixels, deep = self.pixels(picture), is_deep if is_baked else wants_depth(image, is_color)
                data = None if pixels is None else self.encoded(pixels, is_color, deep)
            self.known[key] = None if data is None else self.add(image.name, data)
        return self.known[key]

    def composed(self, name, pixels, is_deep=False):
        """Image of pixels (rows from the bottom, columns, 3 or 4), with the file's values."""
        return self.add(name, png(pixels, is_deep))

    def add(self, name, data):
        kind = next((kind for start, kind in KINDS.items() if data.startswith(start)), "image/webp")
        if kind == "image/webp":
            self.document.extensions.add("EXT_texture_webp")
        key = ("image", data)
        if key not in self.known:
            said = {"name": name, "mimeType": kind, "bufferView": self.document.view(data)}
            self.known[key] = self.document.add("images", said), kind
        return self.known[key]

    def own_bytes(self, image, is_color):
        """The image's own file, if glTF reads the right contents from it."""
        is_right = image.colorspace_settings.name in (IN_SRGB if is_color else PLAIN)
        if image.is_dirty or image.source != "FILE" or not is_right or image.alpha_mode not in {"STRAIGHT", "CHANNEL_PACKED"}:
            return None
        data = packed(image)
        return data if data and (any(map(data.startswith, KINDS)) or data[8:12] == b"WEBP") else None

    def is_as_it_is(self, picture):
        """Whether alpha changes its colours nowhere, or invisibly."""
        if not picture.by_alpha:
            return True
        pixels = self.pixels(replace(picture, by_alpha=""))
        if pixels is None or bool(numpy.all(pixels[..., 3] >= 1.0)):
            return True
        if picture.by_alpha != "there and back":
            return False
        seen = [(one[..., :3] * pixels[..., 3:]).sum() for one in (pixels, self.pixels(picture))]
        return bool(seen[0] - seen[1] <= UNSEEN * seen[0])

    def pixels(self, picture):
        """Scene-linear or plain values, rows from the bottom; None if there are none."""
        image = picture.image
        if hasattr(image, "values_of_texels"):
            return image.values_of_texels
        key = (image, picture.by_alpha)
        if key not in self.pixels_of:
            found = None
            if all(image.size) and image.channels:
                found = texels_of(image)
                if image.alpha_mode == "NONE":
                    found[..., 3] = 1.0
                found[..., :3] = by_alpha(found[..., :3], found[..., 3:], picture.by_alpha, image.is_float)
                # Blender gives byte images as stored.
                if not image.is_float and image.colorspace_settings.name in IN_SRGB:
                    found[..., :3] = linear(found[..., :3])
                elif image.is_float and image.colorspace_settings.name not in PLAIN:
                    found = numpy.concatenate([rec709(found[..., :3]), found[..., 3:]], axis=-1)
            self.pixels_of[key] = found
        return self.pixels_of[key]

    def encoded(self, pixels, is_color, deep):
        values = numpy.concatenate([srgb(pixels[..., :3]), pixels[..., 3:]], axis=-1) if is_color else pixels
        return png(values[..., :3] if numpy.all(values[..., 3] >= 1.0) else values, deep)


def texels_of(image):
    """Values as Blender has them, rows from the bottom."""
    width, height = image.size
    found = numpy.empty((height, width, 4), "f4")
    image.pixels.foreach_get(found.ravel())
    return found


def by_alpha(colors, alpha, way, is_float):
    """Colours as Blender gives them by what Cycles does to them (`pictures.by_alpha`)."""
    left = numpy.where(alpha > 0.0, alpha, 1.0)
    if way == "times" and is_float:
        # With 16 bits, Blender's are premultiplied, while Cycles multiplies the stored ones.
        return linear(alpha * srgb(colors / left))
    found = colors
    if way in {"times", "there and back"}:
        # Cycles truncates to 8 bits; the tolerance covers single precision.
        found = numpy.floor(255.0 * alpha * colors + 1e-3) / 255.0
    if way in {"over", "there and back"}:
        # Invisible texels keep their colours, which interpolation mixes into neighbours.
        found = numpy.where(alpha > 0.0, found / left, colors)
    return found


def is_plain(image):
    """Whether its file holds the numbers unchanged."""
    return not hasattr(image, "values_of_texels") and image.colorspace_settings.name in PLAIN


def has_codes(picture):
    """Whether Cycles interpolates its colours as stored in sRGB."""
    image = picture and picture.image
    return image is not None and not hasattr(image, "values_of_texels") and image.colorspace_settings.name in IN_SRGB


def wants_depth(image, is_color):
    """Whether 8 bits a channel are too few."""
    return image.is_float or image.depth > 32 or (is_color and image.colorspace_settings.name not in IN_SRGB)


def packed(image):
    if image.packed_file:
        return bytes(image.packed_file.data)
    path = Path(bpy.path.abspath(image.filepath, library=image.library)) if image.filepath else None
    return path.read_bytes() if path and path.is_file() else None


def srgb(values):
    values = numpy.clip(values, 0.0, 1.0)
    return numpy.where(values <= 0.0031308, 12.92 * values, 1.055 * numpy.maximum(values, 1e-12) ** (1.0 / 2.4) - 0.055)


def linear(values):
    return numpy.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4).astype("f4")


def png(pixels, is_deep):
    """PNG file of values from 0 to 1, rows from the bottom, with three or four channels of 8 or 16 bits."""
    height, width, channels = pixels.shape
    largest, kind = (65535.0, ">u2") if is_deep else (255.0, "u1")
    values = numpy.rint(numpy.clip(pixels[::-1], 0.0, 1.0) * largest).astype(kind)
    rows = values.reshape(height, -1).view("u1")
    # Filter 2 ("Up"), the difference from the row above, compresses pictures better.
    above = numpy.concatenate([numpy.zeros((1, rows.shape[1]), "u1"), rows[:-1]])
    data = numpy.concatenate([numpy.full((height, 1), 2, "u1"), rows - above], axis=1).tobytes()
    header = struct.pack(">IIBBBBB", width, height, 16 if is_deep else 8, 6 if channels == 4 else 2, 0, 0, 0)
    # Of 16 bits more work makes files smaller by 2 %.
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(data, 1 if is_deep else 6)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))
        for name, body in chunks
    )


FILTERS = {"Closest": 9728}
WRAPS = {"REPEAT": 10497, "EXTEND": 33071, "CLIP": 33071, "MIRROR": 33648}


def texture(document, image, picture: sources.Picture):
    """The number of a texture that shows a picture's image as its node does; `image` is a
    number and a kind."""
    number, kind = image
    wrap = WRAPS[picture.extension]
    sampler = {"magFilter": FILTERS.get(picture.interpolation, 9729), "minFilter": 9987, "wrapS": wrap, "wrapT": wrap}
    source = {"source": number}
    source = {"extensions": {"EXT_texture_webp": source}} if kind == "image/webp" else source
    return document.once("textures", {"sampler": document.once("samplers", sampler), **source})
