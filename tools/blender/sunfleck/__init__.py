"""Blender add-on for sunfleck: panels, export, render engine, frames. See docs/blender.md."""

from . import command, engine, export, frames, importing, names, panels, program, properties, render

PARTS = (properties, program, export, importing, render, frames, panels, engine, command, names)


def register():
    for part in PARTS:
        part.register()


def unregister():
    for part in reversed(PARTS):
        part.unregister()
