"""Where the program `sunfleck` is: the preference, else the environment's SUNFLECK, else the search path."""

import os
import shutil

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
    return shutil.which(os.environ.get("SUNFLECK", "sunfleck"))


MISSING = (
    "the program sunfleck was not found: name it in the add-on's preferences, or put it into the search path"
)


def register():
    bpy.utils.register_class(SunfleckPreferences)


def unregister():
    bpy.utils.unregister_class(SunfleckPreferences)
