"""Fog from OpenVDB files as UsdVol. In go extras of glTF, out comes a `Volume` with its field. Invariant:
the stage refers to the same files.
"""

import os
import re
from pathlib import Path
from urllib.parse import quote

from pxr import Sdf

from ..errors import SceneError
from ..gltf.nodes import Node
from ..gltf.scene import Gltf
from .prims import Names, Prim, Types
from .properties import write_properties
from .samples import Sampler

FOG = "sunfleck_fog_volume"
OF_FILE = ("vdb", "grid")
USUAL_GRID = "density"


def write_volume(prim: Prim, node: Node, gltf: Gltf, sampler: Sampler, names: Names, folder: Path | None) -> None:
    """Writes the fog of a node with a file; the stage is in `folder`, or packages its files."""
    fog = node.extras.group(FOG)
    volume = prim.child(names.new(f"{node.name}_volume"), "Volume")
    fields = {name: value for name, value in fog.raw.items() if name not in OF_FILE}
    write_properties(volume, FOG, fields, node.name, gltf, sampler)
    grid = fog.text_at("grid", USUAL_GRID)
    field = volume.child(names.new(grid), "OpenVDBAsset")
    field.set("fieldName", Types.Token, grid)
    path = gltf.container.beside(fog.need("vdb"))
    named = lambda file: Sdf.AssetPath(str(file) if folder is None else "./" + relative(file, folder))
    if path.is_file() or "#" not in path.name:
        field.set("filePath", Types.Asset, named(path))
    else:
        numbers = numbers_of(path)
        frames = [frame for frame in sampler.frames if float(frame).is_integer()]
        shown = [min(max(int(frame), numbers[0]), numbers[-1]) for frame in frames]
        field.animate("filePath", Types.Asset, frames, [named(numbered(path, number)) for number in shown])
    volume.relate(f"field:{grid}" if grid.isidentifier() else "field:density", field.path)


def relative(file: Path, folder: Path) -> str:
    """Path of a file relative to a folder."""
    return os.path.relpath(os.path.realpath(file), os.path.realpath(folder)).replace(os.sep, "/")


def uri(file: Path, folder: Path) -> str:
    """The same as glTF's URI."""
    return quote(relative(file, folder))


def numbered(path: Path, number: int) -> Path:
    """File of a sequence, whose name has a placeholder for the number."""
    before, digits, after = _parts(path)
    return path.with_name(f"{before}{number:0{digits}d}{after}")


def numbers_of(path: Path) -> list[int]:
    """Numbers of the existing files."""
    before, _, after = _parts(path)
    try:
        files = [file.name for file in path.parent.iterdir()]
    except OSError as error:
        raise SceneError(f"{path.parent}: cannot be read: {error.strerror}") from None
    found = (re.fullmatch(re.escape(before) + r"(-?\d+)" + re.escape(after), name) for name in files)
    numbers = sorted(int(one[1]) for one in found if one and numbered(path, int(one[1])).name == one[0])
    if not numbers:
        raise SceneError(f"{path}: no file is called so, with a number in the place of the signs")
    return numbers


def _parts(path: Path) -> tuple[str, int, str]:
    """Text before the last placeholder, its digits, and the text after it."""
    found = re.fullmatch(r"(.*?)(#+)([^#]*)", path.name)
    assert found is not None, "whoever asks has seen signs"
    before, signs, after = found.groups()
    return before, len(signs), after
