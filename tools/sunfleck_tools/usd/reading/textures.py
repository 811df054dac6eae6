"""Nodes that read textures. In go shader nodes, out come files, placements and conversions. Invariant: a
`Texture` has a readable file."""

import math
from dataclasses import dataclass

import numpy as np
from pxr import Ar, Sdf, Usd, UsdShade

from .changes import changes
from .losses import Losses
from .numbers import numbers_in
from .texels import Picture, PictureError, open_picture

WRAPS = {"repeat": 10497, "clamp": 33071, "mirror": 33648, "black": 33071}
SRGB = ("srgb", "g22_rec709", "gamma22")
LINEAR = ("raw", "data", "identity", "none", "unknown", "lin_rec709", "lin_srgb", "linear")
"""Prefixes of names of linear colour spaces, in lower case."""
FIRST_TILE = 1001
MOVES = {"rotation": 0.0, "scale": (1.0, 1.0), "translation": (0.0, 0.0)}
"""Inputs of UsdTransform2d, and their defaults."""
UDIM_COLUMNS = 10
COORDINATE_NODES = ("UsdPrimvarReader_", "ND_UsdPrimvarReader_", "ND_geompropvalue_", "ND_texcoord_")
INPUTS = {"file", "filename", "st", "texcoord", "wrapS", "wrapT", "fallback", "default", "scale", "bias",
          "sourceColorSpace", "uaddressmode", "vaddressmode", "filtertype", "uvtiling", "uvoffset",
          "realworldimagesize", "realworldtilesize"}  # fmt: skip
"""Inputs of a texture node that are read, and its filters, which are the renderer's own."""
READERS = {
    "UsdUVTexture": "file",
    "ND_UsdUVTexture": "file",
    "ND_UsdUVTexture_23": "file",
    "arnold:image": "filename",
}
"""Nodes that read a file, and the input that names it; those of MaterialX begin with `ND_image`
or `ND_tiledimage`."""


@dataclass(frozen=True)
class Placement:
    """Placement of a texture: the set of coordinates, KHR_texture_transform's (offset, rotation, scale),
    wrapping along each axis."""

    layer: int
    moved: tuple[tuple[float, float], float, tuple[float, float]] | None
    wraps: tuple[int, int]


@dataclass(frozen=True)
class Texture:
    """Texture node: its path, its files by column and row of UDIM tiles, `sRGB`, `raw` or `auto`, and its
    scale and bias."""

    place: str
    files: tuple[tuple[tuple[int, int], str], ...]
    space: str
    scale: tuple[float, ...]
    bias: tuple[float, ...] | None
    placement: Placement


def file_input(shader: UsdShade.Shader) -> str | None:
    """Input with the file of a node that reads one."""
    kind = str(shader.GetIdAttr().Get())
    return "file" if kind.startswith(("ND_image", "ND_tiledimage")) else READERS.get(kind)


class Textures:
    """Reads the texture nodes of one stage; each file is opened once."""

    def __init__(self, lost: Losses, codes: np.ndarray):
        self.lost, self.codes, self.code = lost, codes, float(codes[0])
        self._pictures: dict[str, Picture | None] = {}

    def picture(self, resolved: str) -> Picture:
        """Picture of a file of a `Texture`."""
        picture = self._pictures[resolved]
        assert picture is not None, "a `Texture` has files that open"
        return picture

    def read(self, shader: UsdShade.Shader, layers: list[str]) -> Texture | None:
        """Texture of a node; None, after a report, without a readable file."""
        found = shader.GetInput(file_input(shader))
        producers = found.GetValueProducingAttributes() if found else []
        files = self._files(producers[0], str(shader.GetPath())) if producers else {}
        if not producers:
            self.lost.add("usd-texture", shader, "has no file")
        if not files:
            return None
        space = self._space(shader, producers[0])
        bias = self._numbers(shader, "bias", None)
        scale = self._numbers(shader, "scale", (1.0,) * 4)
        path, placement = str(shader.GetPath()), self._placement(shader, layers)
        return Texture(path, tuple(sorted(files.items())), space, scale, bias, placement)

    def fallback(self, shader: UsdShade.Shader) -> tuple[float, ...] | None:
        """Fallback of a node for an unreadable file, if it has one."""
        return self._numbers(shader, "fallback", None)

    def _value(self, shader: UsdShade.Shader, name: str, default):
        found = shader.GetInput(name)
        producers = found.GetValueProducingAttributes() if found else []
        value = producers[0].Get(self.code) if producers else None
        if producers and changes(producers[0], self.codes):
            what = f"its {name} changes over time; that of the first frame is taken"
            self.lost.add("usd-material-animated", shader, what)
        return default if value is None else value

    def _numbers(self, shader: UsdShade.Shader, name: str, default):
        found = numbers_in(self._value(shader, name, None), 4)
        return default if found is None else found

    def _files(self, attribute: Usd.Attribute, place: str) -> dict[tuple[int, int], str]:
        """Readable files by column and row of their tiles; column 0, row 0 without tiles."""
        value = attribute.Get(self.code)
        if changes(attribute, self.codes):
            what = "its file changes over time; that of the first frame is taken"
            self.lost.add("usd-material-animated", place, what)
        named, resolved = (
            (value.path, value.resolvedPath) if isinstance(value, Sdf.AssetPath) else (str(value or ""), "")
        )
        layer = attribute.GetPropertyStack(self.code)[0].layer
        if UsdShade.UdimUtils.IsUdimIdentifier(named):
            tiles = UsdShade.UdimUtils.ResolveUdimTilePaths(named, layer)
            listed = {divmod(int(tile) - FIRST_TILE, UDIM_COLUMNS)[::-1]: path for path, tile in tiles}
        else:
            # A text, which some exporters write in place of an asset, is also relative to its layer.
            resolved = (
                resolved or Ar.GetResolver().Resolve(layer.ComputeAbsolutePath(named)).GetPathString()
                if named
                else ""
            )
            listed = {(0, 0): resolved}
        found = {tile: path for tile, path in listed.items() if self._opens(path, named, place)}
        if not listed:
            self.lost.add("usd-texture", place, f"the texture `{named}` has no tiles")
        return found

    def _opens(self, resolved: str, named: str, place: str) -> bool:
        if resolved in self._pictures and self._pictures[resolved] is not None:
            return True
        try:
            self._pictures[resolved] = open_picture(resolved)
        except PictureError as error:
            self._pictures[resolved] = None
            self.lost.add("usd-texture", place, f"the texture `{named}` is left out: {error}")
        return self._pictures[resolved] is not None

    def _space(self, shader: UsdShade.Shader, attribute: Usd.Attribute) -> str:
        """`sRGB`, `raw` or `auto`: from the node, else from the attribute of its file; primaries other
        than Rec. 709's are reported."""
        names = (
            str(self._value(shader, "sourceColorSpace", "auto")),
            str(attribute.GetColorSpace() or "auto"),
        )
        name = next((name for name in names if name != "auto"), "auto")
        if name.lower().startswith(SRGB):
            return "sRGB"
        if name != "auto" and not name.lower().startswith(LINEAR):
            what = f"the colour space `{name}` is not known: its numbers are taken as linear Rec. 709"
            self.lost.add("usd-material-input", shader, what)
        return "raw" if name != "auto" else "auto"

    def _placement(self, shader: UsdShade.Shader, layers: list[str]) -> Placement:
        """Set of coordinates and their transform; layer -1 for a mesh without coordinates."""
        wraps = [str(self._value(shader, f"wrap{axis}", "repeat")) for axis in "ST"]
        if "black" in wraps:
            said = "black around a texture is not carried: its edges go on"
            self.lost.add("usd-texture-wrap", shader, said)
        wraps = self._address_modes(shader, wraps)
        node, moved = _before(shader, "st") or _before(shader, "texcoord"), None
        if node and node.GetIdAttr().Get() == "UsdTransform2d":
            moved, node = self._moved(node), _before(node, "in")
        moved = self._tiled(shader, moved)
        self._say_unknown(shader, node)
        layer = 0 if layers else -1
        if node and node.GetInput("varname"):
            name = str(self._value(node, "varname", ""))
            if name in layers:
                layer = layers.index(name)
            elif layers:
                what = f"a texture by the coordinates `{name}`, which the mesh does not have, takes others"
                self.lost.add("usd-material-input", shader, what)
        across, up = (WRAPS.get(wrap, WRAPS["repeat"]) for wrap in wraps)
        return Placement(layer, moved, (across, up))

    def _address_modes(self, shader: UsdShade.Shader, wraps: list[str]) -> list[str]:
        """Wrap modes of MaterialX nodes, as UsdUVTexture's."""
        modes = [self._value(shader, f"{axis}addressmode", None) for axis in "uv"]
        said = {"periodic": "repeat", "clamp": "clamp", "mirror": "mirror", "constant": "black"}
        if "constant" in modes:
            what = "one value around a texture is not carried: its edges go on"
            self.lost.add("usd-texture-wrap", shader, what)
        return [wrap if mode is None else said.get(str(mode), wrap) for wrap, mode in zip(wraps, modes)]

    def _tiled(self, shader: UsdShade.Shader, moved: tuple | None) -> tuple | None:
        """Transform of MaterialX's `tiledimage`: times `uvtiling`, minus `uvoffset`, and both by the ratio
        of the tile's to the picture's size."""
        pairs = {"uvtiling": (1.0, 1.0), "uvoffset": (0.0, 0.0), "realworldimagesize": (1.0, 1.0), "realworldtilesize": (1.0, 1.0)}  # fmt: skip
        if not any(shader.GetInput(name) for name in pairs):
            return moved
        said = [numbers_in(self._value(shader, name, rest), 2) for name, rest in pairs.items()]
        found = [each for each in said if each is not None]
        if None in said or 0 in found[2] or moved is not None:
            what = "its tiling is moved by another node too, or is no numbers, and is left out"
            self.lost.add("usd-material-input", shader, what)
            return moved
        tiling, offset, picture, tile = (np.array(each) for each in found)
        wide, high = (tiling * tile / picture).tolist()
        x, y = (-offset * tile / picture).tolist()
        return (x, round(1 - y - high, 7)), 0.0, (wide, high)

    def _say_unknown(self, shader: UsdShade.Shader, node: UsdShade.Shader | None) -> None:
        """Reports unsupported nodes before a texture, and unsupported inputs of it."""
        kind = str(node.GetIdAttr().Get()) if node else ""
        if node and not kind.startswith(COORDINATE_NODES):
            what = f"takes its coordinates through a {kind or 'node without a kind'}, which is passed over"
            self.lost.add("usd-material-input", shader, what)
        for given in shader.GetInputs():
            name = given.GetBaseName()
            if name not in INPUTS and given.GetValueProducingAttributes():
                self.lost.add("usd-material-input", shader, f"its {name} is not carried")

    def _moved(self, shader: UsdShade.Shader) -> tuple | None:
        """Inverse of the export's transform: glTF rotates about the upper left corner, USD about the lower
        left one."""
        given = {name: self._value(shader, name, rest) for name, rest in MOVES.items()}
        said = [numbers_in(value, 1 if name == "rotation" else 2) for name, value in given.items()]
        numbers = [each for each in said if each is not None]
        if None in said:
            what = "moves a texture by what are no numbers, and is left out"
            self.lost.add("usd-material-input", shader, what)
            return None
        (degrees,), (wide, high), (x, y) = numbers
        angle = math.radians(degrees)
        offset = np.round([x - high * math.sin(angle), 1 - y - high * math.cos(angle)], 7).tolist()
        return tuple(offset), angle, (wide, high)


def _before(shader: UsdShade.Shader, name: str) -> UsdShade.Shader | None:
    """Shader that an input is connected to."""
    found = shader.GetInput(name)
    attributes = found.GetValueProducingAttributes() if found else []
    return UsdShade.Shader(attributes[0].GetPrim()) if attributes else None
