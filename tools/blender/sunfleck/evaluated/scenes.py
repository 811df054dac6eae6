"""A scene to a .glb file: walked, recorded, put together, written.

In go a scene and a path, out come the file and what was found on the way. Invariant: the
scene is left as it was.
"""

import bpy

from .. import extras, film, world, world_sun
from ..losses import Finding
from ..materials.library import Library, custom
from . import counts, walk
from .assemble import Assembly
from .moments import Clock, Shutter, frames, seconds_a_frame
from .record import Record
from .smoothness import Smoothness
from .values import Values


class Exported:
    """What was exported, for whoever counts it."""

    def __init__(self, wanted, record, assembly, library):
        self.frames, self.record, self.assembly, self.library = list(wanted), record, assembly, library
        self.materials = library.words()
        # What only the export found out.
        self.findings = [*library.findings(), *(Finding(id, f"`{name}`") for id, name in sorted(record.shapes))]
        self.findings += [Finding("hair-attributes", f"`{name}`") for name in sorted(record.capture.colorless)]
        if not assembly.shutter.is_centred:
            self.findings += [Finding("velocity-blur", f"`{name}`") for name in sorted(record.capture.drifted)]

    def compared(self, file):
        """What there should be by frame, and where the file differs."""
        expected = counts.of_record(self.record, self.frames)
        expected.lights += self.assembly.suns_of_sky
        differences = list(counts.differences(expected, counts.of_file(file, self.frames)))
        differences += counts.different_materials(self.library.seen, file)
        return expected, [
            Finding(id, f"frame {frame}" if frame is not None else "", more)
            for id, frame, more in differences
        ]


def export(scene, path, only=None):
    """Writes the file, of all frames or of one alone."""
    wanted = frames(scene, only)
    library, values, shutter = Library(film.exposure(scene)), Values(scene), Shutter.of(scene)
    library.watch(bpy.data.materials)
    record = Record(library, values.watch, seconds_a_frame(scene.render) if shutter.length else 0.0)

    def visit(graph, frame, moment):
        record.visit(graph, frame, moment)
        values.see_scene(graph, frame, moment)
        if moment == 0.0:
            library.see(graph, frame)

    try:
        # Nothing is to be made while Blender renders.
        for material in list(bpy.data.materials):
            library.look(material)
        walk.walk(scene, wanted, shutter, visit, Smoothness(record).is_enough)
        record.finish()
        assembly = Assembly(record, wanted, shutter, Clock.of(scene, wanted), walk.view_layer(scene))
        library.start(assembly.document, assembly.clock)
        assembly.add(library, values, lambda thing: properties(thing, scene, path))
        finish(scene, assembly, library, values, only)
        assembly.document.write(path)
        return Exported(wanted, record, assembly, library)
    finally:
        library.close()


def finish(scene, assembly, library, values, only):
    """What belongs to the scene, and keys of everything."""
    sun = world_sun.of(scene.world) if world.has_sun(scene) else None
    if sun:
        world_sun.add(assembly.document, sun, film.exposure(scene))
        assembly.suns_of_sky = 1
    assembly.document.scene_extras = custom(scene)
    settle_frames(assembly, only)
    assembly.add_view(values)
    assembly.tracks.write()
    values.write(assembly)
    assembly.document.asset_extras = {"materials": library.words()}


def settle_frames(assembly, only):
    """Which frames the file has, and which of them is at second 0."""
    said = assembly.document.scene_extras.setdefault("sunfleck", {})
    if assembly.clock.first:
        said["frame_at_zero"] = assembly.clock.first
    if only is not None:
        said["frame_start"] = said["frame_end"] = only


def properties(thing, scene, path):
    """The custom properties of a thing's node: its own, and ours also where they could not be stored (linked
    libraries, objects that only instances show). A portal is no light."""
    found = {**custom(thing.object), **extras.of_object(thing.object, scene, path)}
    if thing.kind == "EMPTY" and thing.object.type == "LIGHT":
        found.pop("sunfleck_light", None)
    return found
