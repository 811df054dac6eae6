"""Export of a scene to a .glb file: walk, record, assembly, writing.

In go a scene and a path, out come the file and findings. Invariant: the scene is restored.
"""

import bpy

from .. import extras, film, world, world_sun
from ..losses import Finding
from ..materials.library import Library
from ..stored import by_hand, custom
from . import coincident, counts, walk
from .assemble import Assembly
from .moments import Clock, Shutter, frames, seconds_a_frame
from .record import Record
from .values import Values, of_fog


class Exported:
    """Result of an export, for counts."""

    def __init__(self, wanted, record, assembly, library, values):
        self.frames, self.record, self.assembly, self.library = list(wanted), record, assembly, library
        self.materials = library.words()
        # Findings of the export itself.
        self.findings = [*library.findings(), *(Finding(id, f"`{name}`") for id, name in sorted(record.shapes))]
        self.findings += record.volumes.found
        self.findings += [Finding("fog-material", f"`{name}`") for name in sorted(values.otherwise)]
        self.findings += values.stays.findings()
        self.findings += [Finding("hair-attributes", f"`{name}`") for name in sorted(record.capture.colorless)]
        self.findings += [Finding(id, f"`{name}`") for id, name in sorted(record.capture.otherwise)]
        self.findings += [Finding("coincident-faces", f"`{name}`") for name in sorted(coincident.names(record))]
        self.findings += [] if coincident.is_whole(record) else [Finding("coincident-unknown")]
        if not assembly.shutter.is_centred:
            self.findings += [Finding("velocity-blur", f"`{name}`") for name in sorted(record.capture.drifted)]
        if not assembly.shutter.can_hold:
            self.findings += [Finding("motion-blur-off", f"`{name}`") for name in sorted(record.sharp)]
            moving = {thing.name for thing in record.things.values() if record.is_moving_light(thing)}
            self.findings += [Finding("light-blur", f"`{name}`") for name in sorted(moving | assembly.uncentred)]

    def compared(self, file):
        """Expected counts by frame, and differences in the file."""
        expected = counts.of_record(self.record, self.frames)
        expected.lights += self.assembly.suns_of_sky
        differences = list(counts.differences(expected, counts.of_file(file, self.frames)))
        differences += counts.different_materials(self.library.seen, file)
        return expected, [
            Finding(id, f"frame {frame}" if frame is not None else "", more)
            for id, frame, more in differences
        ]


def export(scene, path, only=None, judge=lambda shown: None):
    """Writes the file, with all frames or a single one; `judge` gets all objects that were seen, and raises to refuse."""
    with Job(scene, only) as job:
        walk.walk(scene, job.frames, job.shutter, job)
        judge(job.record.originals())
        return job.written(path, walk.view_layer(scene), custom(scene))


class Job:
    """Export in progress: `visit` is called for every moment, then `written`."""

    def __init__(self, scene, only=None):
        self.scene, self.only, self.frames = scene, only, frames(scene, only)
        self.library, self.shutter = Library(film.exposure(scene), only == scene.frame_current, scene.frame_current_final), Shutter.of(scene, only is not None)
        self.values = Values(scene, self.shutter)
        self.library.changes.watch(bpy.data.materials)
        blur_s = seconds_a_frame(scene.render) if self.shutter.length else 0.0
        self.record = Record(self.library, self.watch, self.shutter, blur_s)

    def __enter__(self):
        # No datablock may be created while Blender steps through frames.
        try:
            for material in list(bpy.data.materials):
                self.library.look(material)
        except BaseException:
            self.library.close()
            raise
        return self

    def __exit__(self, *_):
        self.record.volumes.close()
        self.library.close()

    def watch(self, key, instance, frame, offset):
        self.values.watch(key, instance, frame, offset)
        if instance.object.type == "VOLUME":
            self.values.see(key, frame, of_fog("sunfleck_fog_volume", self.record.volumes.see(key, instance, frame)))

    def visit(self, graph, frame, moment):
        self.record.visit(graph, frame, moment)
        self.values.see_scene(graph, frame, moment)
        if moment == 0.0:
            self.library.changes.see(graph, frame)

    def written(self, path, layer, scene_extras):
        """Writes the file of the record."""
        self.record.finish()
        clock = Clock.of(self.scene, self.frames)
        assembly = Assembly(self.record, self.frames, self.shutter, clock, layer)
        self.library.start(assembly.document, assembly.clock, self.shutter)
        assembly.add(self.library, self.values, lambda key, thing: self.properties(key, thing, path))
        assembly.document.scene_extras = scene_extras
        finish(self.scene, assembly, self.library, self.values, self.only)
        assembly.document.write(path)
        return Exported(self.frames, self.record, assembly, self.library, self.values)

    def properties(self, key, thing, path):
        """Custom properties of an object's node; None if it gets no node."""
        found = properties(thing, self.scene, path, self.values.said.get(key, {}))
        if thing.kind != "VOLUME":
            return found
        fog = self.record.volumes.properties(key, path)
        return None if fog is None else {**found, **fog}


def finish(scene, assembly, library, values, only):
    """Adds the scene's properties, and all keys."""
    sun = world_sun.of(scene.world, scene.frame_current_final) if world.has_sun(scene) else None
    if sun:
        world_sun.add(assembly.document, sun, film.exposure(scene))
        assembly.suns_of_sky = 1
    settle_frames(assembly, only)
    if values.fog:
        assembly.document.scene_extras["sunfleck_fog"] = values.fog
    assembly.add_view(values)
    assembly.tracks.write()
    values.write(assembly)
    assembly.document.asset_extras = {"materials": library.words()}


def settle_frames(assembly, only):
    """Sets the frames of the file, and the one at second 0."""
    said = assembly.document.scene_extras.setdefault("sunfleck", {})
    if assembly.clock.first:
        said["frame_at_zero"] = assembly.clock.first
    if only is not None:
        said["frame_start"] = said["frame_end"] = only


def properties(thing, scene, path, evaluated):
    """Custom properties of an object's node: its own, and the add-on's, even where they cannot be stored
    (linked libraries, objects that only instances show). Changing ones are evaluated. A portal is not a
    light, and what holds fog at other frames alone is none."""
    found = {**by_hand(thing.object), **extras.of_object(thing.object, scene, path)}
    for name, said in evaluated.items():
        found[name] = {**found.get(name, {}), **said} if isinstance(said, dict) else said
    if thing.kind == "EMPTY":
        found.pop("sunfleck_light" if thing.object.type == "LIGHT" else "sunfleck_fog_volume", None)
    if thing.kind == "SURFACE":
        found.pop("sunfleck_fog_volume", None)
    return found
