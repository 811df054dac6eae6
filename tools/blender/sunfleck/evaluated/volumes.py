"""Volumes as fog by OpenVDB files, frame by frame.

In go evaluated volumes, out come custom properties. A file that Blender has read is referenced in place;
volumes from modifiers and nodes are written beside the .glb file. Invariant: a file has the number of its
frame, or is the same at all frames.
"""

import hashlib
import os
import re
import shutil
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import quote

import bpy

from .. import volumes
from ..losses import Finding

# Size of an OpenVDB file's header with its unique id.
HEAD_BYTES = 57
# Blender's own density below which voxels are empty: next to nothing.
CLIPPING = 1.001e-3
# Custom properties that may be animated.
CHANGING = {"density", "albedo", "anisotropy", "emission"}


@dataclass
class Seen:
    """One volume."""

    name: str
    said: dict = None
    # Files by frame.
    files: dict = field(default_factory=dict)


class Volumes:
    """Volumes of a scene, by key."""

    def __init__(self, is_blurred=False):
        self.is_blurred = is_blurred
        self.seen, self.found, self.made, self.named = {}, {}, {}, set()
        self.folder = None

    def is_there(self, thing):
        """Whether an evaluated volume has any grid at the moment."""
        grids = thing.data.grids
        if not grids.load():
            self.say("volume", thing.name, "its file cannot be read")
        return len(grids) > 0

    def see(self, key, instance, frame):
        """Records a frame; returns the animated custom properties, none if it is not rendered."""
        thing = instance.object
        try:
            said = self.looked_at(thing, instance.matrix_world)
        except volumes.NotFog as problem:
            self.say("volume", thing.name, str(problem))
            return {}
        seen = self.seen.setdefault(key, Seen(thing.name, said))
        seen.files[frame] = self.file(thing)
        return {field: value for field, value in said.items() if field in CHANGING}

    def looked_at(self, thing, matrix):
        data = thing.data
        kinds = {grid.name: grid.data_type for grid in data.grids}
        look = volumes.look(thing).within(kinds)
        if kinds.get(look.grid) != "FLOAT":
            raise volumes.NotFog(f"it has no grid of floats `{look.grid}`")
        for lost in look.lost:
            # Only existing grids can be lost.
            colors = re.search("`(.*)`", lost)
            if colors is None or colors[1] in kinds:
                self.say("volume-lost", thing.name, lost)
        if self.is_blurred and data.velocity_grid in kinds:
            self.say("volume-lost", thing.name, "its blur by velocities")
        if data.render.clipping > CLIPPING:
            self.say("volume-lost", thing.name, "its clipping: thin voxels are not empty")
        return look.fog(thing, matrix)

    def say(self, id, name, more):
        self.found.setdefault(Finding(id, f"`{name}`", more))

    def file(self, thing):
        """File of the current frame."""
        grids = thing.data.grids
        is_changed = any(modifier.show_render for modifier in thing.original.modifiers) or not grids.frame_filepath
        return self.written(grids) if is_changed else Path(bpy.path.abspath(grids.frame_filepath)).resolve()

    def written(self, grids):
        if self.folder is None:
            self.folder = Path(tempfile.mkdtemp(prefix="sunfleck_grids_"))
        path = self.folder / f"{len(self.made)}.vdb"
        if not grids.save(str(path)):
            raise RuntimeError(f"{path}: Blender cannot write an OpenVDB file: {grids.error_message}")
        known = self.made.setdefault(hashlib.sha256(path.read_bytes()[HEAD_BYTES:]).digest(), path)
        if known != path:
            path.unlink()
        return known

    def properties(self, key, path):
        """Custom properties of a node in the file at `path`; None if there is no such fog."""
        seen = self.seen.get(key)
        if seen is None:
            return None
        return {"sunfleck_fog_volume": {**seen.said, "vdb": self.uri(seen, Path(path).resolve())}}

    def uri(self, seen, path):
        files = seen.files
        if len(set(files.values())) > 1:
            file = numbered(files) or self.laid_beside(seen, path)
        else:
            file = next(iter(files.values()))
            if file.parent == self.folder:
                file = Path(shutil.copyfile(file, self.beside(path, seen.name, "")))
        return quote(os.path.relpath(file, path.parent).replace(os.sep, "/"))

    def beside(self, path, name, number):
        """Unique name among the volumes of this file."""
        stem = re.sub(r"[^\w.-]+", "_", name)
        while (stem, path) in self.named:
            stem += "_"
        self.named.add((stem, path))
        return path.with_name(f"{path.name}.{stem}{number}.vdb")

    def laid_beside(self, seen, path):
        """Files by frame: links if possible, else copies. A gap keeps the earlier file."""
        pattern = self.beside(path, seen.name, ".####")
        before, after = pattern.name.split("####")
        for old in path.parent.iterdir():
            if re.fullmatch(re.escape(before) + r"-?\d+" + re.escape(after), old.name):
                old.unlink()
        shown = None
        for frame in range(min(seen.files), max(seen.files) + 1):
            shown = seen.files.get(frame, shown)
            target = pattern.with_name(f"{before}{frame:04d}{after}")
            try:
                os.link(shown, target)
            except OSError:
                shutil.copyfile(shown, target)
        return pattern

    def close(self):
        if self.folder is not None:
            shutil.rmtree(self.folder, ignore_errors=True)
            self.folder = None


def numbered(files):
    """Path with a placeholder for the number, if files are named by their frames without a gap."""
    frame, file = next(iter(files.items()))
    name = re.fullmatch(r"(.*?)(\d+)(\.vdb)", file.name)
    if name is None or int(name[2]) != frame:
        return None
    before, digits, after = name.groups()
    pattern = file.with_name(f"{before}{'#' * len(digits)}{after}")
    called = lambda frame: file.with_name(f"{before}{frame:0{len(digits)}d}{after}")
    if any(called(frame) != file for frame, file in files.items()):
        return None
    there = (re.fullmatch(re.escape(before) + r"(\d+)" + re.escape(after), other.name) for other in file.parent.iterdir())
    numbers = sorted(int(one[1]) for one in there if one and called(int(one[1])).name == one[0])
    return pattern if numbers == list(range(numbers[0], numbers[-1] + 1)) else None
