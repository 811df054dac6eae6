"""A scene to a .glb file: walked, recorded, put together, written.

In go a scene and a path, out come the file and what was found on the way. Invariant: the scene is left as it was.
"""

import bpy

from .. import extras
from ..losses import Finding
from ..materials.library import Library, custom
from . import counts, walk
from .assemble import Assembly
from .moments import Clock, Shutter, frames
from .record import Record
from .smoothness import Smoothness
from .values import Values


class Exported:
    """What was exported, for whoever counts it."""

    def __init__(self, scene, record, assembly, library):
        self.frames, self.record, self.assembly, self.library = list(frames(scene)), record, assembly, library
        self.materials = library.words()
        # What only the export found out.
        self.findings = list(library.findings())

    def compared(self, file):
        """What there should be by frame, and where the file differs."""
        expected = counts.of_record(self.record, self.frames)
        differences = list(counts.differences(expected, counts.of_file(file, self.frames)))
        differences += counts.different_materials(self.library.seen, file)
        return expected, [Finding(id, f"frame {frame}" if frame is not None else "", more) for id, frame, more in differences]


def export(scene, path):
    """Writes the file."""
    library, values, shutter = Library(), Values(scene), Shutter.of(scene)
    library.watch(bpy.data.materials)
    record = Record(library, values.watch)

    def visit(graph, frame, moment):
        record.visit(graph, frame, moment)
        values.see_scene(graph, frame, moment)
        if moment == 0.0:
            library.see(graph, frame)

    walk.walk(scene, frames(scene), shutter, visit, Smoothness(record).is_enough)
    record.finish()
    assembly = Assembly(record, frames(scene), shutter, Clock.of(scene))
    library.start(assembly.document, assembly.clock)
    try:
        assembly.add(library, values, lambda thing: properties(thing, path))
        assembly.document.scene_extras = custom(scene)
        assembly.add_view(values)
        assembly.tracks.write()
        values.write(assembly)
        assembly.document.asset_extras = {"materials": library.words()}
        assembly.document.write(path)
        return Exported(scene, record, assembly, library)
    finally:
        library.close()


def properties(thing, path):
    """The custom properties of a thing's node: its own, and ours also where they could not be stored (linked libraries, objects that
    only instances show). A portal is no light."""
    found = {**custom(thing.object), **extras.of_object(thing.object, path)}
    if thing.kind == "EMPTY" and thing.object.type == "LIGHT":
        found.pop("sunfleck_light", None)
    return found
