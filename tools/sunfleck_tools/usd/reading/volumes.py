"""Volumes of a stage. In go a `Volume` and its fields, out come file and grid of fog's density. Invariant:
unsupported fields and materials are reported.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from pxr import Sdf, Usd, UsdVol

from ..volumes import FOG, USUAL_GRID, numbered, uri
from .bindings import bound_material
from .losses import Losses
from .nodes import Nodes
from .places import is_placed, local_matrices
from .source import Source

FIELDS = ("OpenVDBAsset", "Field3DAsset")
"""Types of a volume's fields."""


@dataclass(frozen=True)
class Volume:
    """Prim with the density, and its file: with a placeholder for the number in a sequence."""

    field: Usd.Prim
    file: Path
    grid: str


class Volumes:
    """Adds volumes to nodes of a file in `folder`."""

    def __init__(self, nodes: Nodes, folder: Path):
        self.nodes, self.folder = nodes, folder
        self.count = 0

    def place(self, prim: Usd.Prim, node: int, take_extras: Callable[[Usd.Prim, int], None]) -> None:
        """Puts a volume at a node, which may be that of its parent."""
        nodes = self.nodes
        volume = read_volume(prim, nodes.source, nodes.lost)
        if volume is None:
            return
        if FOG not in nodes.of(node).get("extras", {}):
            take_extras(prim, node)
        fog = nodes.of(node).get("extras", {}).pop(FOG, None)
        if fog is None:
            said = "is taken to scatter what meets it, 1 a unit of the stage where its density is 1"
            nodes.lost.add("usd-volume", prim, said)
            fog = {"density": 1.0 / nodes.source.metres}
        at = node
        if is_placed(volume.field, nodes.source):
            at = nodes.add(f"{nodes.of(node)['name']} (field)", node)
            at = nodes.place(at, *local_matrices(volume.field, nodes.source))
        nodes.extra(at, FOG, {**fog, "vdb": uri(volume.file, self.folder), "grid": volume.grid})
        self.count += 1


def read_volume(prim: Usd.Prim, source: Source, lost: Losses) -> Volume | None:
    """Volume of a prim; None, after a report, without a density in an existing file."""
    place = prim.GetPath()
    paths = UsdVol.Volume(prim).GetFieldPaths()
    fields = {name: prim.GetStage().GetPrimAtPath(path) for name, path in paths.items()}
    read = {name: field for name, field in fields.items() if field and field.GetTypeName() == "OpenVDBAsset"}
    name = USUAL_GRID if USUAL_GRID in read else next(iter(read)) if len(read) == 1 else None
    for other in sorted(set(fields) - {name}):
        lost.add("usd-volume", place, f"its field `{other}` is not carried, only a density in an OpenVDB file is")
    if name is None:
        if not fields:
            lost.add("usd-volume", place, "has no field")
        return None
    asset = UsdVol.OpenVDBAsset(read[name])
    if asset.GetFieldIndexAttr().Get(source.first):
        lost.add("usd-volume", place, "of several grids of one name the first is taken")
    file = _file(asset.GetFilePathAttr(), source, lost)
    if file is None:
        return None
    if bound_material(prim) is not None:
        lost.add("usd-volume", place, "its material is not carried")
    return Volume(read[name], file, str(asset.GetFieldNameAttr().Get(source.first) or name))


def _file(attribute: Usd.Attribute, source: Source, lost: Losses) -> Path | None:
    first, last = source.frames
    rate = float(source.codes_per_second / source.fps)
    changes = attribute.GetNumTimeSamples() > 1
    frames = range(first, last + 1) if changes else [first]
    named = {frame: attribute.Get(frame * rate) for frame in frames}
    for asset in named.values():
        if not (isinstance(asset, Sdf.AssetPath) and asset.resolvedPath):
            said = f"the file `{getattr(asset, 'path', '')}` is not there"
            lost.add("usd-missing", attribute.GetPrim().GetPath(), said)
            return None
    files = {frame: Path(asset.resolvedPath) for frame, asset in named.items()}
    if len(set(files.values())) == 1:
        return files[first]
    pattern = _pattern(files)
    if pattern is None:
        said = "its files are not numbered as frames are: that of the first frame is taken"
        lost.add("usd-volume", attribute.GetPrim().GetPath(), said)
    return pattern or files[first]


def _pattern(files: dict[int, Path]) -> Path | None:
    """Path with a placeholder for the number; before the first file and after the last these stay."""
    distinct = sorted(set(files.values()))
    name = re.fullmatch(r"(.*?)(\d+)(\D*)", distinct[0].name)
    if name is None:
        return None
    pattern = distinct[0].with_name(f"{name[1]}{'#' * len(name[2])}{name[3]}")
    numbers = {numbered(pattern, frame): frame for frame in files}
    there = [numbers[file] for file in distinct if file in numbers]
    if len(there) != len(distinct):
        return None
    least, most = min(there), max(there)
    shown = {frame: numbered(pattern, min(max(frame, least), most)) for frame in files}
    return pattern if shown == files else None
