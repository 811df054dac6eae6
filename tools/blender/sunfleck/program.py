"""Path of the program `sunfleck`.

It comes from the preference, the environment's SUNFLECK, the extension, or the search path, in this order.
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
    """Path of the program, or None."""
    addon = bpy.context.preferences.addons.get(__package__)
    named = addon.preferences.program if addon and addon.preferences else ""
    if named:
        named = bpy.path.abspath(named)
        return named if os.access(named, os.X_OK) else None
    if "SUNFLECK" in os.environ:
        return shutil.which(os.environ["SUNFLECK"])
    return bundled() or shutil.which("sunfleck")


def bundled():
    """Executable program of the extension; None in an add-on without one. Blender unpacks a zip without
    permissions to execute."""
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
    """Copy of an extension's program, if the user cannot change the original."""
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


register, unregister = bpy.utils.register_classes_factory((SunfleckPreferences,))
