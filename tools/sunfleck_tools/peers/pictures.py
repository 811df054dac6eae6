"""Pictures for other renderers: base colour textures, and backgrounds.

Invariant: they are the original files, which each renderer decodes itself; only gradients are made here.
"""

import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..exr.decode import LARGEST_COMPRESSION
from ..exr.header import HeaderError, parse_header
from ..exr.write import write_colors
from ..gltf.container import DISPLAY_PICTURES, LINEAR_PICTURES, ending_of
from ..gltf.scene import Gltf
from ..gltf.sky import read_sky
from ..gltf.values import Value

KINDS = {**DISPLAY_PICTURES, **LINEAR_PICTURES}
MOST_TEXELS = 1 << 26
"""Maximum number of texels, as in the renderer."""
WRAPS = {10497: "repeat", 33071: "clamp", 33648: "mirror"}


@dataclass(frozen=True)
class Picture:
    """Bytes of a file, and its extension."""

    data: bytes
    ending: str

    def file(self, folder: Path, stem: str) -> Path:
        """Writes the file."""
        path = folder / f"{stem}{self.ending}"
        path.write_bytes(self.data)
        return path


@dataclass(frozen=True)
class Texture:
    """Picture in sRGB, its wrap mode, and its placement on a set of coordinates: `offset + turn * (scale *
    uv)`."""

    picture: Picture
    wrap: str
    layer: int
    offset: np.ndarray
    linear: np.ndarray

    def placed(self, uvs: np.ndarray) -> np.ndarray:
        """Coordinates in the picture, from its upper left corner."""
        return uvs @ self.linear.T + self.offset


@dataclass(frozen=True)
class PeerSky:
    """Like `gltf.sky.Sky`, with a picture of the gradient."""

    lights: str
    radiance: np.ndarray
    picture: Picture | None
    rotation_rad: float


def read_background(gltf: Gltf) -> PeerSky | None:
    """Background of the scene."""
    sky = read_sky(gltf)
    if sky is None:
        return None
    picture = None
    if sky.image is not None:
        picture = _picture(gltf.container.linked(sky.image), sky.image)
    elif sky.gradient is not None:
        with tempfile.TemporaryDirectory() as folder:
            write_colors(Path(folder, "sky.exr"), sky.gradient)
            picture = Picture(Path(folder, "sky.exr").read_bytes(), ".exr")
    return PeerSky(sky.lights, sky.radiance, picture, sky.rotation_rad)


def read_texture(gltf: Gltf, info: Value) -> Texture:
    """The texture of a material."""
    document = gltf.document
    textures, images, samplers = (document.items(name) for name in ("textures", "images", "samplers"))
    texture = info.need("index").item_of(textures, "texture")
    image = texture.need("source").item_of(images, "image")
    sampler = texture.member("sampler")
    wrap = 10497 if sampler is None else sampler.item_of(samplers, "sampler").number_at("wrapS", 10497)
    layer, linear = info.number_at("texCoord", 0, 0, 7), np.eye(2)
    offset: np.ndarray = np.zeros(2)
    if (moved := info.extension("KHR_texture_transform")) is not None:
        layer = moved.number_at("texCoord", layer, 0, 7)
        scale = moved.numbers_at("scale", 1.0, 1.0)
        angle = moved.number_at("rotation", 0.0)
        turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        linear = turn @ np.diag(scale)
        offset = np.array(moved.numbers_at("offset", 0.0, 0.0))
    picture = _picture(gltf.container.picture(image), image)
    return Texture(picture, WRAPS.get(int(wrap), "repeat"), int(layer), offset, linear)


def _picture(data: bytes, source: Value) -> Picture:
    ending = ending_of(data, KINDS, source, "other renderers get PNG, JPEG, OpenEXR and Radiance HDR")
    # Formats whose few bytes can declare any size.
    if ending == ".png" and len(data) >= 24:
        pixels, most = int.from_bytes(data[16:20], "big") * int.from_bytes(data[20:24], "big"), MOST_TEXELS
    elif ending == ".exr":
        try:
            pixels, most = parse_header(data).pixel_bytes, len(data) * LARGEST_COMPRESSION
        except HeaderError as error:
            source.fail(f"is damaged: {error}")
    else:
        pixels, most = 0, 0
    if pixels > most:
        source.fail("claims to be larger than it can be")
    return Picture(data, ending)
