"""A scene to a .glb file: walked, recorded, put together, written.

In go a scene and a path, out come the file and what was found on the way. Invariant: the scene is left as it was.
"""

import bpy

from ..materials.library import Library, custom
from . import walk
from .assemble import Assembly
from .moments import Clock, Shutter, frames
from .record import Record
from .smoothness import Smoothness
from .values import Values


class Exported:
    """What was exported, for whoever counts it."""

    def __init__(self, record, assembly, library, values):
        self.record, self.assembly, self.library, self.values = record, assembly, library, values


def export(scene, path):
    """Writes the file."""
    library, values, shutter = Library(), Values(scene), Shutter.of(scene)
    library.watch(bpy.data.materials)
    record = Record(library.colors_of, values.watch)

    def visit(graph, frame, moment):
        record.visit(graph, frame, moment)
        if moment == 0.0:
            values.see_scene(graph, frame)
            library.see(graph, frame)

    walk.walk(scene, frames(scene), shutter, visit, Smoothness(record).is_enough)
    record.finish()
    assembly = Assembly(record, frames(scene), shutter, Clock.of(scene))
    library.start(assembly.document, assembly.clock)
    assembly.add(library, values, lambda thing: custom(thing.object))
    values.write(assembly)
    assembly.document.scene_extras = custom(scene)
    assembly.document.write(path)
    return Exported(record, assembly, library, values)
