"""What was seen at every moment: where each thing was and which geometry it showed.

In go graphs, out comes a `Record` of things by key. Invariant: a thing is the same from moment to moment if Blender says so: its
object, what instances it, and its persistent id among the instances; a geometry that several things show is there once.
"""

from dataclasses import dataclass, field

import numpy

from ..materials import instances
from . import geometry

# Curves, texts and metaballs are among the instances a second time, as the meshes that they make.
KINDS = {"MESH": "SURFACE", "LIGHT": "LIGHT", "CAMERA": "CAMERA", "EMPTY": "EMPTY"}


@dataclass
class Thing:
    """Something that is placed; parallel lists tell of every moment at which it is there."""

    name: str
    kind: str
    # The object in the file, and the one that instances it, if any.
    object: object
    instancer: object
    moments: list = field(default_factory=list)
    rows: list = field(default_factory=list)
    # Numbers of geometries, with the materials of their slots.
    shown: list = field(default_factory=list)
    # What materials may ask of it.
    facts: object = None


@dataclass(eq=False)
class Source:
    """What of an instance goes for all that share object and instancer: asking Blender takes its time."""

    kind: str | None
    original: object
    parent: object

    def __post_init__(self):
        self.names = (self.original.name_full, self.parent.name_full if self.parent else "")


class Here:
    """What is known within one moment."""

    def __init__(self, ids, names):
        self.ids = numpy.ascontiguousarray(ids).view("V32").ravel().tolist()
        self.sources, self.shown = {}, {}
        # Attributes of instances that materials ask for; of each instancer how many instances came, and theirs.
        self.names, self.orders, self.tables = names, {}, {}
        # How many have the same key, as realised groups may.
        self.seen = {}

    def source(self, instance, thing):
        if not instance.is_instance:
            return Source(kind_of(thing), thing.original, None)
        key = (instance.instance_object, instance.parent, thing.type)
        found = self.sources.get(key)
        if found is None:
            original = (instance.instance_object or thing).original
            found = self.sources[key] = Source(kind_of(thing), original, instance.parent.original)
        return found

    def count(self, instance):
        if self.names and instance.is_instance:
            self.orders[instance.parent] = self.orders.get(instance.parent, -1) + 1

    def attributes(self, instance):
        """Names and values of an instance's; instances come in the order in which their geometry has them."""
        if not self.names or not instance.is_instance:
            return ()
        parent = instance.parent
        if parent not in self.tables:
            self.tables[parent] = instances.attributes_of(parent, self.names)
        table, order = self.tables[parent], self.orders[parent]
        return table[order] if table and order < len(table) else ()

    def key(self, row, source):
        key = (*source.names, self.ids[row] if source.parent else b"", 0)
        count = self.seen[key] = self.seen.get(key, -1) + 1
        return key if count == 0 else (*key[:3], count)


def kind_of(thing):
    return "EMPTY" if holds_fog(thing) else KINDS.get(thing.type)


class Record:
    """Grows as the graph is walked."""

    def __init__(self, library, watch):
        """`library` knows what materials look at; `watch` is told what is no surface."""
        self.library, self.watch = library, watch
        self.attributes = library.attributes_of_instances()
        self.things, self.geometries, self.known = {}, [], {}
        # Frame and offset of each moment; places and numbers of geometries (-1 is none), one array for each.
        self.moments, self.matrices, self.numbers = [], [], []
        self.first_row, self.first_rows, self.lamps = 0, [], []
        # Of meshes that cannot change: what they show.
        self.still, self.reaches = {}, {}
        # Names of what has no surface.
        self.unseen = set()

    def visit(self, graph, frame, offset):
        seen = graph.object_instances
        moment = len(self.moments)
        self.moments.append((frame, offset))
        count = len(seen)
        matrices, ids = numpy.empty((count, 16), "f4"), numpy.empty((count, 8), "i4")
        seen.foreach_get("matrix_world", matrices.ravel())
        seen.foreach_get("persistent_id", ids.ravel())
        self.matrices.append(matrices.reshape(count, 4, 4).swapaxes(1, 2))
        here, numbers = Here(ids, self.attributes), numpy.full(count, -1)
        self.numbers.append(numbers)
        self.first_rows.append(self.first_row)
        self.lamps.append(0)
        for row, instance in enumerate(seen):
            thing = instance.object
            source = here.source(instance, thing)
            here.count(instance)
            if source.kind is None or not instance.show_self:
                continue
            shown = self.shown(thing, source, here) if source.kind == "SURFACE" else None
            if source.kind == "SURFACE" and shown is None:
                continue
            if shown is not None:
                numbers[row] = shown[0]
            self.lamps[-1] += source.kind == "LIGHT"
            key = here.key(row, source)
            found = self.things.get(key)
            if found is None:
                found = self.things[key] = Thing(thing.name, source.kind, source.original, source.parent)
                if source.kind == "SURFACE":
                    found.facts = instances.facts(instance, thing, here.attributes(instance))
            found.moments.append(moment)
            found.rows.append(self.first_row + row)
            found.shown.append(shown)
            if source.kind != "SURFACE" and offset == 0.0:
                self.watch(key, thing, frame)
        self.first_row += count

    def shown(self, thing, source, here):
        """The number of what an object shows and its materials; None for nothing."""
        data = thing.data
        key = (data, source)
        if key in here.shown:
            return here.shown[key]
        slots = tuple(slot.material.name_full if slot.material else "" for slot in thing.material_slots if slot.link == "OBJECT")
        is_still = cannot_change(source.original, data)
        if is_still and (data.original, slots) in self.still:
            found = self.still[data.original, slots]
        else:
            found = self.captured(thing)
        if is_still:
            self.still[data.original, slots] = found
        here.shown[key] = found
        return found

    def captured(self, thing):
        mesh = thing.data
        materials = [material.original if material else None for material in materials_of(thing, mesh)]
        colors = {name for material in materials for name in self.library.colors_of(material)}
        made = geometry.of_mesh(mesh, sorted(colors))
        if made is None:
            return None
        slots = {min(max(int(slot), 0), len(materials) - 1) for slot in numpy.unique(made.slots)} if materials else set()
        if slots and not any(self.library.is_seen(materials[slot]) for slot in slots):
            self.unseen.add(thing.original.name)
            return None
        if any(self.library.wants_atlas(material, made) for material in materials):
            made = made.unwrapped()
        number = self.known.setdefault(made.known_by(), len(self.geometries))
        if number == len(self.geometries):
            self.geometries.append(made)
        return number, tuple(materials)

    def places(self, thing):
        """Of each moment, (moments, 4, 4)."""
        return self.all_matrices[thing.rows].astype(float)

    def reach(self, number):
        """How far a geometry reaches from its origin."""
        if number not in self.reaches:
            positions = self.geometries[number].positions
            self.reaches[number] = float(numpy.linalg.norm(positions, axis=1).max(initial=0.0))
        return self.reaches[number]

    def finish(self):
        """Puts the places of all moments together, and moments into the order of time: a frame itself is seen first."""
        for thing in self.things.values() if any(offset for _, offset in self.moments) else ():
            order = sorted(range(len(thing.moments)), key=lambda at: sum(self.moments[thing.moments[at]]))
            for name in ("moments", "rows", "shown"):
                values = getattr(thing, name)
                setattr(thing, name, [values[at] for at in order])
        self.all_matrices = numpy.concatenate(self.matrices) if self.matrices else numpy.empty((0, 4, 4), "f4")
        self.matrices = []


def holds_fog(thing):
    """Its mesh, if it has one, only shows its author where the fog is."""
    return thing.type in {"EMPTY", "MESH"} and (thing.sunfleck_settings.is_fog or "sunfleck_fog_volume" in thing)


def cannot_change(original, data):
    """A mesh that is neither keyed nor bent shows the same at every moment; one that is made for instances may be any."""
    return (
        original.type == "MESH"
        and not original.modifiers
        and original.data.shape_keys is None
        and original.data.animation_data is None
        and data.original == original.data
    )


def materials_of(thing, mesh):
    """Of each slot: the object's own where it says so, else the mesh's."""
    slots, of_mesh = thing.material_slots, list(mesh.materials)
    found = []
    for index in range(max(len(slots), len(of_mesh))):
        slot = slots[index] if index < len(slots) else None
        if slot is not None and (slot.link == "OBJECT" or index >= len(of_mesh)):
            found.append(slot.material)
        else:
            found.append(of_mesh[index])
    return found
