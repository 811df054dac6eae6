"""Record of the graph at every moment: placements and geometries.

In go graphs, out comes a `Record` of objects and instances by key. Invariants: an instance is identified
by its object, its instancer, its persistent id and its kind. A geometry that several show is stored once.
"""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy

from ..film import is_a_portal, of_cycles
from ..materials import instances
from ..stored import fields_by_hand, is_by_hand
from .attributes import numbers
from .capture import Capture
from .moments import steps_of
from .volumes import Volumes

# Curves, texts and metaballs are also among the instances as meshes.
KINDS = {
    **dict.fromkeys(("MESH", "CURVES", "POINTCLOUD"), "SURFACE"), **{kind: kind for kind in ("LIGHT", "CAMERA", "VOLUME", "EMPTY")},
}
# Beside these `FOG`, of an empty or a mesh while it holds fog.
BLURRED = {"SURFACE", "CAMERA"}
# Losses for these types, which nodes of a mesh may create too.
SHAPES = {"GREASEPENCIL": "grease-pencil", "CURVES": "hair", "POINTCLOUD": "point-cloud"}


@dataclass
class Thing:
    """Object or instance; parallel lists have an entry for every moment of its existence."""

    name: str
    kind: str
    # Object in the file, and its instancer, if any.
    object: object
    instancer: object
    moments: list = field(default_factory=list)
    rows: list = field(default_factory=list)
    # Indices of geometries, with the materials of their slots.
    shown: list = field(default_factory=list)
    # Facts for materials, at the frame of each moment.
    facts: list = field(default_factory=list)


@dataclass(eq=False)
class Source:
    """Data shared by all instances of an object and instancer, as queries to Blender are slow."""

    kind: str | None
    original: object
    parent: object

    def __post_init__(self):
        self.names = (self.original.name_full, self.parent.name_full if self.parent else "")
        owners = [one for one in (self.original, self.parent) if one]
        self.steps = steps_of(*owners)
        self.bends = self.steps > 0 and all(of_cycles(one, "use_deform_motion", True) for one in owners)


class Here:
    """Data of one moment."""

    def __init__(self, graph, ids, names):
        self.scene, self.layer = graph.scene_eval, graph.view_layer_eval
        self.frame = self.scene.frame_current_final
        self.ids = numpy.ascontiguousarray(ids).view("V32").ravel().tolist()
        self.sources, self.shown = {}, {}
        # Attributes of instances for materials, and those of each instancer.
        self.names, self.tables = names, {}
        # Count for each key, as realised groups may repeat keys.
        self.seen, self.lamps = {}, 0

    def source(self, instance, thing):
        if not instance.is_instance:
            return Source(kind_of(thing), thing.original, None)
        key = (instance.instance_object, instance.parent, thing.type)
        found = self.sources.get(key)
        if found is None:
            original = (instance.instance_object or thing).original
            found = self.sources[key] = Source(kind_of(thing), original, instance.parent.original)
        return found

    def attributes(self, instance):
        """Attribute values of an instance, by name."""
        if not self.names:
            return {}
        parent = instance.parent
        if parent not in self.tables:
            self.tables[parent] = instances.Attributed(parent, self.names)
        path = [number for number in instance.persistent_id if number != instances.NO_NUMBER]
        return self.tables[parent].of(path[::-1], instance.instance_object)

    def key(self, row, source, part):
        key = (*source.names, part, self.ids[row] if source.parent else b"", source.kind, 0)
        count = self.seen[key] = self.seen.get(key, -1) + 1
        return key if count == 0 else (*key[:-1], count)


class Seen(NamedTuple):
    """Instance of the graph while it is valid."""

    row: int
    instance: object
    thing: object
    source: Source
    here: Here


def kind_of(thing):
    """Kind of an object: portals only guide Cycles' sampling."""
    is_portal = thing.type == "LIGHT" and is_a_portal(thing.data)
    return "FOG" if holds_fog(thing) else "EMPTY" if is_portal else KINDS.get(thing.type)


class Record:
    """Grows during the walk."""

    def __init__(self, library, watch, shutter, seconds_a_frame=0.0):
        """`library` knows the attributes of materials; `watch` gets all instances without a surface; for the
        last see `Capture`."""
        self.capture, self.watch, self.questions = Capture(library, seconds_a_frame), watch, library.questions()
        # Names of objects that are not blurred, or whose deformation is not.
        self.shutter, self.sharp = shutter, set()
        # Attributes that materials read from instances, and whether any may change.
        self.attributes = {name for kind, of, name in self.questions if (kind, of) == ("ATTRIBUTE", "INSTANCER")}
        self.changes = not set(self.questions) <= instances.STILL
        self.things, self.volumes = {}, Volumes(seconds_a_frame > 0.0)
        # Ids of losses and names of objects with unsupported or converted shapes; all objects, in order.
        self.shapes, self.met = set(), {}
        # For each moment: frame and offset, placements of all instances, first rows, rows by geometry, and
        # lights.
        self.moments, self.matrices, self.first_rows, self.placed, self.lamps = [], [], [], [], []

    def heed(self):
        self.capture.heed()

    @property
    def geometries(self):
        return self.capture.geometries

    def visit(self, graph, frame, offset):
        seen = graph.object_instances
        count = len(seen)
        matrices, ids = numbers(seen, "matrix_world", (count, 4, 4), "f4"), numbers(seen, "persistent_id", (count, 8), "i4")
        self.first_rows.append(self.first_rows[-1] + len(self.matrices[-1]) if self.moments else 0)
        self.moments.append((frame, offset))
        self.matrices.append(matrices.swapaxes(1, 2))
        is_number = numpy.isfinite(matrices).all(axis=(1, 2))
        here = Here(graph, ids, self.attributes)
        self.capture.begin(graph, offset, self.shutter.holds(offset, 0))
        rows = []
        for row, instance in enumerate(seen):
            self.heed()
            thing = instance.object
            source = here.source(instance, thing)
            if not self.shutter.is_step(offset, source.steps):
                continue
            if instance.show_self:
                self.met[source.original] = None
            if not is_number[row]:
                self.shapes.add(("not-finite", source.original.name))
                continue
            if source.kind in BLURRED and not source.bends:
                self.sharp.add(source.original.name)
            if instance.show_self and thing.type in SHAPES:
                is_splat = getattr(thing.data, "type", "POINTS") != "POINTS"
                self.shapes.add(("point-splats" if is_splat else SHAPES[thing.type], source.original.name))
            if source.kind == "SURFACE":
                for part, shown in self.capture.shown(thing, source, instance):
                    self.add(here.key(row, source, part), Seen(row, instance, thing, source, here), shown)
                    rows.append((row, shown[0]))
            elif source.kind == "VOLUME" and not self.volumes.is_there(thing):
                continue
            elif source.kind == "FOG" and not self.matrices[-1][row, :3, :3].any():
                # A box without any side holds nothing.
                continue
            elif source.kind is not None and instance.show_self:
                key = here.key(row, source, "")
                self.add(key, Seen(row, instance, thing, source, here), None)
                here.lamps += is_light(source.kind, thing)
                # Zooms blur; other parameters are those of the frame.
                if offset == 0.0 or source.kind == "CAMERA":
                    self.watch(key, instance, frame, offset)
        self.placed.append(numpy.array(rows, int).reshape(-1, 2).T)
        self.lamps.append(here.lamps)

    def add(self, key, seen, shown):
        """Adds an instance at this moment."""
        found, (frame, offset) = self.things.get(key), self.moments[-1]
        if found is None:
            name, source = seen.thing.name, seen.source
            name = f"{name} {key[2]}" if key[2] else name
            found = self.things[key] = Thing(name, source.kind, source.original, source.parent)
        is_new = not found.facts
        if found.kind == "SURFACE" and (is_new or (self.changes and offset == 0.0)):
            found.facts.append(instances.facts(seen.instance, seen.thing, self.questions, seen.here))
        else:
            found.facts += found.facts[-1:]
        is_held = found.rows and self.moments[found.moments[-1]][0] == frame and self.shutter.holds(offset, seen.source.steps)
        found.moments.append(len(self.moments) - 1)
        found.rows.append(found.rows[-1] if is_held else self.first_rows[-1] + seen.row)
        found.shown.append(shown)

    def originals(self):
        """Objects that are shown at some moment, whether or not the file can have them."""
        return list(self.met)

    def places(self, thing):
        """Placements at each moment, (moments, 4, 4)."""
        return self.all_matrices[thing.rows].astype(float)

    def is_moving_light(self, thing):
        return thing.kind == "LIGHT" and float(numpy.ptp(self.places(thing), axis=0).max()) > 1e-6

    def finish(self):
        """Joins the placements of all moments, and sorts moments by time; the frame itself is visited
        first."""
        if self.shutter.is_alone:
            self.hold_ends()
        for thing in self.things.values() if any(offset for _, offset in self.moments) else ():
            order = sorted(range(len(thing.moments)), key=lambda at: sum(self.moments[thing.moments[at]]))
            for name in ("moments", "rows", "shown", "facts"):
                values = getattr(thing, name)
                setattr(thing, name, [values[at] for at in order] if values else values)
        self.all_matrices = (
            numpy.concatenate(self.matrices) if self.matrices else numpy.empty((0, 4, 4), "f4")
        )
        self.matrices = []

    def hold_ends(self):
        """What is not there when a frame's shutter opens or closes is as it first or last is in that shutter, as in
        Cycles: else it would come from where it was when it vanished."""
        ends = {}
        for moment, (frame, offset) in enumerate(self.moments):
            if offset != 0.0 and offset in self.shutter.ends:
                ends.setdefault(frame, []).append((moment, offset))
        for thing in self.things.values():
            if len(thing.moments) < len(self.moments):
                self.hold_ends_of(thing, ends)

    def hold_ends_of(self, thing, ends):
        there = {}
        for at, moment in enumerate(thing.moments):
            there.setdefault(self.moments[moment][0], []).append(at)
        present = set(thing.moments)
        for frame, places in there.items():
            for moment, offset in ends.get(frame, ()):
                if moment in present:
                    continue
                nearest = min(places, key=lambda at: abs(self.moments[thing.moments[at]][1] - offset))
                thing.moments.append(moment)
                for values in (thing.rows, thing.shown, thing.facts):
                    values.extend(values[nearest : nearest + 1])


def is_light(kind, thing):
    """Whether the file has it as a light: area lights may be empties with a property by hand, as the import makes them."""
    is_area = is_by_hand(thing, "sunfleck_light") and fields_by_hand(thing, "sunfleck_light").get("type") == "area"
    return kind == "LIGHT" or (is_area and thing.type != "LIGHT")


def holds_fog(thing):
    """Whether an object is fog, whose mesh only shows its place to the author."""
    return thing.type in {"EMPTY", "MESH"} and (
        thing.sunfleck_settings.is_fog or is_by_hand(thing, "sunfleck_fog_volume")
    )
