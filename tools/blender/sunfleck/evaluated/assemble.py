"""The record of a scene as a glTF document.

In go a record, materials and values that change, out comes the document. Invariant: every object recorded
at a frame is a node that is visible at that frame, with its placement, and at no other frame.
"""

from collections import Counter
from dataclasses import dataclass, field

import numpy

from . import places, visibility
from .document import Document
from .meshes import Meshes
from .shapes import Bend
from .tracks import Tracks


# Files of volumes keep Blender's axes.
LOOKS = {"LIGHT", "CAMERA", "VOLUME"}


def turned(matrices, things):
    """Placements in glTF's axes: one for each object, or all of one object."""
    looks = numpy.array([thing.kind in LOOKS for thing in things], bool)[:, None, None]
    return numpy.where(looks, places.in_gltf(matrices, True), places.in_gltf(matrices, False))


@dataclass
class United:
    """Shapes by moment, and their conversion."""

    shapes: dict = field(default_factory=dict)
    bend: object = None


class Assembly:
    """Makes nodes of objects, one after the other; `tracks.write` makes channels of their motion at the
    end."""

    def __init__(self, record, frames, shutter, clock, layer):
        self.record, self.frames, self.shutter, self.clock = record, frames, shutter, clock
        self.layer = layer
        self.document = Document()
        self.tracks = Tracks(self.document, clock)
        self.times = numpy.array([frame + offset for frame, offset in record.moments])
        self.is_frame = numpy.array([offset == 0.0 for _, offset in record.moments])
        self.frame_of = numpy.array([frame for frame, _ in record.moments])
        self.names, self.bends, self.lamps, self.lenses = {}, {}, {}, {}
        # Lights of the file that are not objects.
        self.nodes, self.suns_of_sky = {}, 0
        # Objects whose placements shear, which takes two nodes, and names of lights that change within a
        # shutter that is not centred on the frame.
        self.sheared, self.uncentred = set(), set()

    def name(self, thing):
        """Name of an object's node; instances get a number."""
        is_own = thing.instancer in (None, thing.object)
        wanted = thing.name if is_own else f"{thing.name} of {thing.instancer.name}"
        self.names[wanted] = count = self.names.get(wanted, 0) + 1
        return wanted if is_own and count == 1 else f"{wanted} {count}"

    def add(self, materials, values, custom):
        """Adds all objects, in the order of their appearance, objects before instances, which give way in
        names."""
        self.meshes, self.materials = Meshes(self.document, materials, self.record.heed), materials
        materials.heed = self.record.heed
        things = sorted(self.record.things.items(), key=lambda item: item[1].instancer is not None)
        materials.prepare(Counter(
            (material, facts)
            for _, thing in things
            for shown, facts in set(zip(thing.shown, thing.facts))
            if shown
            for material in shown[1]
        ))
        for _, thing in things:
            self.record.heed()
            self.unite_shapes(thing)
        self.still = self.still_places(things)
        for key, thing in things:
            self.record.heed()
            self.add_thing(key, thing, values, custom)

    def still_places(self, things):
        """Of what is there at one moment alone, by key."""
        still = [(key, thing) for key, thing in things if len(thing.rows) == 1]
        matrices = self.record.all_matrices[[thing.rows[0] for _, thing in still]].astype(float)
        return dict(zip((key for key, _ in still), places.each(turned(matrices, [thing for _, thing in still]))))

    def add_thing(self, key, thing, values, custom):
        there = self.is_frame[thing.moments]
        if not there.any():
            return
        written = custom(key, thing)
        if written is None:
            return
        node = {"name": self.name(thing)}
        number = self.nodes[key] = self.document.add("nodes", node)
        if written:
            node["extras"] = written
        parts = self.still.get(key) or places.parts(turned(self.record.places(thing), [thing]))
        times = self.times[thing.moments]
        holder = number
        if parts.inner is not None:
            self.sheared.add(key)
            # The named node is the inner one: its place is the thing's.
            holder = self.document.add("nodes", {"name": f"{node['name']} (shear)", "children": [number]})
            inner = places.Places(0.0 * parts.translation, parts.inner, 0.0 * parts.scale + 1.0)
            self.tracks.place(number, times, inner, self.reach(thing))
        self.tracks.place(holder, times, parts, self.reach(thing))
        seen = set(self.frame_of[thing.moments][there].tolist())
        self.tracks.visible(
            holder, self.frames, [frame in seen for frame in self.frames], self.shutter.switch
        )
        if thing.kind == "SURFACE":
            self.show(number, thing)
        elif thing.kind == "LIGHT":
            self.shine(node, thing, values.lights[key])
        elif thing.kind == "CAMERA":
            self.look(node, thing, values.cameras[key])

    def node_name(self, key):
        """Of a thing's node; None if it has none."""
        return self.document.lists["nodes"][self.nodes[key]]["name"] if key in self.nodes else None

    def reach(self, thing):
        """How far from its origin a thing has anything."""
        shown = {shown[0] for shown in thing.shown if shown is not None}
        return max((self.record.capture.reach(number) for number in shown), default=1.0)

    # Surfaces.

    def groups(self, thing):
        """What a thing shows by topology, materials and what these are on it: moments and geometries; only
        what it shows at a frame itself."""
        groups, known = {}, {}
        for moment, (geometry, materials), facts in zip(thing.moments, thing.shown, thing.facts):
            here = known.get((materials, facts))
            if here is None:
                here = tuple(self.materials.on_instance(material, facts) for material in materials)
                known[materials, facts] = here
            key = (self.record.geometries[geometry].topology, materials, here)
            groups.setdefault(key, {})[moment] = geometry
        return {key: group for key, group in groups.items() if any(self.is_frame[moment] for moment in group)}

    def unite_shapes(self, thing):
        """Things that show the same object's shapes at the same moments bend alike, whenever each
        of them is there."""
        if thing.kind != "SURFACE":
            return
        for key, group in self.groups(thing).items():
            if len(set(group.values())) == 1:
                continue
            united = self.bends.setdefault((thing.object, key[:2]), [])
            fitting = (
                one
                for one in united
                if all(one.shapes.get(moment, shape) == shape for moment, shape in group.items())
            )
            found = next(fitting, None)
            if found is None:
                united.append(found := United())
            found.shapes.update(group)

    def show(self, number, thing):
        """Puts a mesh at a node, or several in turn where the topology or the materials change."""
        groups = self.groups(thing)
        name = self.document.lists["nodes"][number]["name"]
        rays = visibility.of_thing(thing.object, thing.instancer, self.layer)
        for index, (key, group) in enumerate(groups.items()):
            child = number
            if len(groups) > 1:
                child = self.document.add("nodes", {"name": f"{name} ({index + 1})"})
                self.document.lists["nodes"][number].setdefault("children", []).append(child)
                there = {self.frame_of[moment] for moment in group if self.is_frame[moment]}
                self.tracks.visible(
                    child, self.frames, [frame in there for frame in self.frames], self.shutter.switch
                )
            if rays:
                self.document.lists["nodes"][child].setdefault("extras", {})["sunfleck_object"] = rays
            self.show_group(child, key[2], group, self.bend(thing, key[:2], group))

    def show_group(self, node, materials, group, bend):
        said = self.document.lists["nodes"][node]
        first = self.record.geometries[next(iter(group.values()))]
        mesh = self.meshes.number(bend.base if bend else first, materials, bend)
        if mesh is None:
            return
        said["mesh"] = mesh
        if bend is None:
            return
        for material in materials:
            self.materials.bend(material)
        times, weights = bend.keys()
        self.document.lists["meshes"][mesh]["weights"] = weights[0].tolist()
        if len(times) > 1:
            self.document.node_channel(node, "weights", self.clock.seconds(times), weights.ravel())

    def bend(self, thing, key, group):
        """Deformation of an object's mesh; None if its shape is constant."""
        if len(set(group.values())) == 1:
            return None
        fits = lambda one: all(one.shapes.get(moment) == shape for moment, shape in group.items())
        united = next(filter(fits, self.bends[thing.object, key]))
        if united.bend is None:
            moments = sorted(united.shapes, key=lambda moment: self.times[moment])
            united.bend = Bend(
                self.times[moments], [united.shapes[moment] for moment in moments], self.record.geometries
            )
        return united.bend

    # Lights and cameras.

    def shine(self, node, thing, said):
        if said.punctual is None:
            return
        key = repr(said.punctual)
        if key not in self.lamps:
            self.lamps[key] = self.document.light(said.punctual)
        node.setdefault("extensions", {})["KHR_lights_punctual"] = {"light": self.lamps[key]}

    def add_view(self, values):
        """Adds a camera that follows the one that renders, unless that is always the same node."""
        views = sorted(values.views, key=lambda view: view.time)
        eyes = {view.eye for view in views}
        if not eyes or views[0].said.camera is None:
            return
        names = {
            thing.object: self.node_name(key)
            for key, thing in self.record.things.items()
            if thing.instancer is None
        }
        said = self.document.scene_extras.setdefault("sunfleck", {})
        if len(eyes) == 1 and names.get(views[0].eye):
            # Blender's own name may be that of a camera of another library.
            said["camera"] = names[views[0].eye]
            return
        node = {"name": "camera of markers" if len(eyes) > 1 else views[0].eye.name}
        number = self.nodes["view"] = self.document.add("nodes", node)
        matrices = numpy.stack([view.matrix for view in views])
        times = numpy.array([view.time for view in views])
        self.tracks.place(number, times, places.parts(places.in_gltf(matrices, looks=True)), 1.0)
        self.look(node, None, views[0].said)
        for view in views:
            values.see("view", view.time, view.fields)
        said["camera"] = node["name"]

    def look(self, node, thing, said):
        if said.camera is None:
            return
        written = {**said.camera, "extras": said.extras} if said.extras else said.camera
        node["camera"] = self.document.once("cameras", written)
