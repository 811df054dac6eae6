"""What was seen at every moment: where each thing was and which geometry it showed.

In go graphs, out comes a `Record` of things by key. Invariant: a thing is the same from moment to moment if Blender says so: its
object, what instances it, and its persistent id among the instances; a geometry that several things show is there once.
"""

from dataclasses import dataclass, field

import numpy

from . import geometry

SURFACES = {"MESH", "CURVE", "SURFACE", "META", "FONT"}
KINDS = {**dict.fromkeys(SURFACES, "SURFACE"), "LIGHT": "LIGHT", "CAMERA": "CAMERA", "EMPTY": "EMPTY"}


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


class Record:
    """Grows as the graph is walked."""

    def __init__(self, colors_of, watch):
        """`colors_of` gives the names of colour attributes that materials look at; `watch` is told what is no surface."""
        self.colors_of, self.watch = colors_of, watch
        self.things, self.geometries, self.known = {}, [], {}
        # Frame and offset of each moment; places, one array for each.
        self.moments, self.matrices = [], []
        self.first_row = 0
        # Of meshes that cannot change: what they show.
        self.still, self.reaches = {}, {}

    def visit(self, graph, frame, offset):
        instances = graph.object_instances
        moment = len(self.moments)
        self.moments.append((frame, offset))
        count = len(instances)
        matrices, ids = numpy.empty((count, 16), "f4"), numpy.empty((count, 8), "i4")
        instances.foreach_get("matrix_world", matrices.ravel())
        instances.foreach_get("persistent_id", ids.ravel())
        self.matrices.append(matrices.reshape(count, 4, 4).swapaxes(1, 2))
        # What shares its key with another in the same moment, as realised groups may.
        seen, shown_here = {}, {}
        for row, instance in enumerate(instances):
            thing = instance.object
            kind = "EMPTY" if holds_fog(thing) else KINDS.get(thing.type)
            if kind is None or not instance.show_self:
                continue
            shown = self.shown(graph, thing, instance, shown_here) if kind == "SURFACE" else None
            if kind == "SURFACE" and shown is None:
                continue
            parent = instance.parent.original if instance.is_instance else None
            key = (thing.name_full, parent.name_full if parent else "", ids[row].tobytes() if parent else b"")
            seen[key] = seen.get(key, 0) + 1
            found = self.thing((*key, seen[key]), kind, thing, parent)
            found.moments.append(moment)
            found.rows.append(self.first_row + row)
            found.shown.append(shown)
            if kind != "SURFACE" and offset == 0.0:
                self.watch((*key, seen[key]), thing, frame)
        self.first_row += count

    def thing(self, key, kind, thing, parent):
        if key not in self.things:
            self.things[key] = Thing(thing.name, kind, thing.original, parent)
        return self.things[key]

    def shown(self, graph, thing, instance, shown_here):
        """The number of what an object shows and its materials; None for nothing."""
        data = thing.data
        original = (instance.instance_object or thing).original
        own_slots = tuple(slot.material.name_full if slot.material else "" for slot in thing.material_slots if slot.link == "OBJECT")
        # What is no mesh is made one by each object in its own way.
        here = (data.as_pointer(), own_slots, "" if thing.type == "MESH" else original.name_full)
        if here in shown_here:
            return shown_here[here]
        is_still = thing.type == "MESH" and cannot_change(original, data)
        if is_still and (data.original, own_slots) in self.still:
            found = self.still[data.original, own_slots]
        else:
            found = self.captured(thing)
            if is_still:
                self.still[data.original, own_slots] = found
        shown_here[here] = found
        return found

    def captured(self, thing):
        mesh = thing.data if thing.type == "MESH" else thing.to_mesh()
        if mesh is None:
            return None
        try:
            materials = materials_of(thing, mesh)
            made = geometry.of_mesh(mesh, sorted({name for material in materials for name in self.colors_of(material)}))
        finally:
            if thing.type != "MESH":
                thing.to_mesh_clear()
        if made is None:
            return None
        number = self.known.setdefault(made.known_by(), len(self.geometries))
        if number == len(self.geometries):
            self.geometries.append(made)
        return number, tuple(material.original if material else None for material in materials)

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
        """Puts the places of all moments together."""
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
