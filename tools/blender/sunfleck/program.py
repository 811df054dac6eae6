"""Where the program `sunfleck` is.

The preference says so, or the environment's SUNFLECK, or it came with the extension, or it is on the search path:
the first of these that holds.
"""

import os
import shutil
import stat
from pathlib import Path

import bpy
from bpy.props import StringProperty


class SunfleckPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    program: StringProperty(
        name="Program",
        description="The program sunfleck; found by the search path if empty",
        subtype="FILE_PATH",
    )

    def draw(self, _context):
        self.layout.prop(self, "program")


def find():
    """The program's path, or None."""
    addon = bpy.context.preferences.addons.get(__package__)
    named = addon.preferences.program if addon and addon.preferences else ""
    if named:
        named = bpy.path.abspath(named)
        return named if os.access(named, os.X_OK) else None
    if "SUNFLECK" in os.environ:
        return shutil.which(os.environ["SUNFLECK"])
    return bundled() or shutil.which("sunfleck")


def bundled():
    """The program in the extension, ready to run; None in an add-on without one. Blender unpacks a zip without
    the bits that say what can be run."""
    name = "sunfleck.exe" if os.name == "nt" else "sunfleck"
    inside = Path(__file__).parent / "bin" / name
    if not inside.is_file():
        return None
    if os.access(inside, os.X_OK):
        return str(inside)
    try:
        make_runnable(inside)
        return str(inside)
    except OSError:
        return str(copied(inside))


def make_runnable(path):
    path.chmod(path.stat().st_mode | stat.S_IXUSR | stat.S_IXGRP | stat.S_IXOTH)


def copied(inside):
    """Of an extension that is not this user's to change: a copy that is."""
    own = Path(bpy.utils.extension_path_user(__package__, path="bin", create=True)) / inside.name
    if not (own.is_file() and own.stat().st_mtime >= inside.stat().st_mtime):
        part = own.with_suffix(".part")
        shutil.copyfile(inside, part)
        make_runnable(part)
        part.replace(own)
    return own


MISSING = (
    "the program sunfleck was not found: name it in the add-on's preferences, or put it into the search path"
)


def register():
    bpy.utils.register_class(SunfleckPreferences)


def unregister():
    bpy.utils.unregister_class(SunfleckPreferences)
