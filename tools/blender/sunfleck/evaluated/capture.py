"""Capture of the graph's geometries, each once.

In go evaluated objects, out come numbers of geometries and the materials of their slots. Invariant:
constant geometry is captured once; an object without a surface is None, and its name is kept.
"""

import bpy
import numpy

from ..materials import dependence
from . import geometry, strands
from .attributes import GENERATED
from .heeding import nobody

# Attribute by which Cycles computes motion blur, metres a second.
VELOCITY = "velocity"
# Angles between shading and face normals, radians: above the first, Cycles' shadow terminator is visible
# (some half per cent of a picture lit from the side); above the second, custom normals do not follow the
# faces at all.
COARSE, LEANING = 0.15, 0.5


class Capture:
    """Captures geometries for a record."""

    def __init__(self, library, seconds_a_frame):
        # `library` knows the attributes of materials; velocities are scaled by the seconds a frame, 0 without
        # blur.
        self.library, self.seconds_a_frame = library, seconds_a_frame
        # Called repeatedly; raises to cancel.
        self.heed = nobody
        self.geometries, self.known, self.reaches = [], {}, {}
        # Geometries of this moment, and constant ones.
        self.here, self.still = {}, {}
        # Initial position of the camera, in the space of each object with hair.
        self.eye, self.eyes = None, {}
        # Scale of the current object in the world.
        self.size = 1.0
        # Names of objects without a surface, and of those with hair that needs attributes.
        self.unseen, self.colorless = set(), set()
        # Ids of losses and names of meshes that Cycles shades differently; each is checked once.
        self.otherwise, self.judged = set(), set()
        # Material override of the view layer, if any, for all slots.
        self.override = None
        # Objects with velocities have the frame's geometry at all moments of the frame.
        self.drifting, self.drifted, self.offset = {}, set(), 0.0
        # What things show at the frame whose deformation is not blurred, and whether that counts now.
        self.stiff, self.is_held = {}, False

    def begin(self, graph, offset, is_held):
        """Starts a new moment."""
        self.here, self.offset, self.is_held = {}, offset, is_held
        override = graph.view_layer.material_override
        self.override = override and override.original
        self.drifting = self.drifting if offset else {}
        if self.eye is None:
            camera = graph.scene.camera
            self.eye = numpy.array(
                camera.evaluated_get(graph).matrix_world.translation if camera else (0.0, 0.0, 1e3), float
            )

    def shown(self, thing, source, instance):
        """Parts of an instance, by name, with their geometries. The object itself has the empty name, hair
        that of its system."""
        self.size = abs(instance.matrix_world.determinant()) ** (1.0 / 3.0)
        if instance.show_self:
            found = self.at_frame(source, ("surface", thing.data.name), lambda: self.surface(thing, source))
            if found is not None:
                yield "", found
        if instance.show_particles and thing.particle_systems:
            for system in thing.particle_systems:
                if system.settings.type == "HAIR" and system.settings.render_type == "PATH":
                    found = self.at_frame(source, ("hair", system.name), lambda: self.hair(thing, source, system))
                    if found is not None:
                        yield system.name, found

    def at_frame(self, source, part, captured):
        """What is captured now, or was at the frame if its deformation is not blurred; parts have a kind and a name."""
        if source.bends:
            return captured()
        if not self.is_held or (source.names, part) not in self.stiff:
            self.stiff[source.names, part] = captured()
        return self.stiff[source.names, part]

    def surface(self, thing, source):
        """Index of an object's geometry and its materials; None for nothing."""
        key = (thing.data, source)
        if key not in self.here:
            is_still = cannot_change(source.original, thing.data)
            kept = (source.original.data, own_materials(thing)) if is_still else None
            self.here[key] = self.once(kept, lambda: self.captured(thing, source))
        return self.here[key]

    def once(self, kept, captured):
        """What is captured now, or was before if it is constant and kept by a key."""
        if kept is None:
            return captured()
        if kept not in self.still:
            self.still[kept] = captured()
        return self.still[kept]

    def captured(self, thing, source):
        key = (source.names, thing.type, thing.data.name)
        if key not in self.drifting:
            materials = self.materials_of(thing)
            made, velocities = self.made(thing, source, materials)
            if velocities is None:
                return self.kept(made, materials, source)
            self.drifting[key] = made, velocities, materials
            self.drifted.add(source.original.name)
        made, velocities, materials = self.drifting[key]
        return self.kept(made.drifted(velocities, self.offset * self.seconds_a_frame), materials, source)

    def materials_of(self, thing):
        found = [material.original if material else None for material in materials_of(thing, thing.data)]
        return [self.override] * max(1, len(found)) if self.override else found

    def made(self, thing, source, materials):
        """Geometry, and velocities of its corners if Cycles uses them for blur."""
        data = thing.data
        asked = {name for material in materials for name in self.library.colors_of(material)}
        has_velocities = self.seconds_a_frame and is_velocity(data.attributes.get(VELOCITY))
        colors = sorted(asked | {VELOCITY} if has_velocities else asked)
        if thing.type != "MESH":
            colors = [name for name in colors if name != GENERATED]
        if thing.type == "CURVES":
            is_flat = any(map(dependence.lets_through, materials))
            found = strands.of_curves(data, self.eye_in(thing, source), colors, is_flat)
        elif thing.type == "POINTCLOUD":
            found = strands.of_points(data, colors)
        else:
            uvs = {name for material in materials for name in self.library.uvs_of(material)}
            groups = {group.name: group.index for group in thing.vertex_groups} if colors else {}
            found = geometry.of_mesh(data, colors, sorted(uvs), groups, self.heed)
            if found is not None and source.original.name not in self.judged:
                self.judge(found, source.original, data.has_custom_normals)
        if found is None or not has_velocities:
            return found, None
        velocities = found.colors[VELOCITY] if VELOCITY in asked else found.colors.pop(VELOCITY)
        return found, velocities

    def judge(self, made, original, has_custom_normals):
        self.judged.add(original.name)
        apart = made.coarseness()
        if has_custom_normals and apart > LEANING:
            self.otherwise.add(("custom-normals", original.name))
        elif original.shadow_terminator_geometry_offset > 0.0 and apart > COARSE:
            self.otherwise.add(("shadow-terminator", original.name))

    def hair(self, thing, source, system):
        """Hair of a particle system; unsimulated strands on a constant mesh are constant."""
        key = (source, system.name)
        if key not in self.here:
            others = [modifier for modifier in source.original.modifiers if modifier.type != "PARTICLE_SYSTEM"]
            is_still = not system.use_hair_dynamics and not others and source.original.data.shape_keys is None
            kept = (source.original, system.name) if is_still else None
            self.here[key] = self.once(kept, lambda: self.captured_hair(thing, source, system))
        return self.here[key]

    def captured_hair(self, thing, source, system):
        materials = self.materials_of(thing)
        slot = min(max(system.settings.material - 1, 0), len(materials) - 1)
        is_flat = bool(materials) and dependence.lets_through(materials[slot])
        made = strands.of_particles(thing, system, self.eye_in(thing, source), is_flat)
        if materials and set(self.library.colors_of(materials[slot])) - {GENERATED}:
            self.colorless.add(source.original.name)
        return self.kept(made, materials[slot : slot + 1] if materials else [], source)

    def eye_in(self, thing, source):
        if source.original not in self.eyes:
            local = numpy.array(thing.matrix_world.inverted_safe(), float)
            self.eyes[source.original] = local[:3, :3] @ self.eye + local[:3, 3]
        return self.eyes[source.original]

    def kept(self, made, materials, source):
        """Index of a geometry; None if it has no faces."""
        if made is None:
            return None
        if not numpy.isfinite(made.positions).all():
            self.otherwise.add(("not-finite", source.original.name))
            return None
        used = {min(max(int(slot), 0), len(materials) - 1) for slot in numpy.unique(made.slots)}
        if materials and used and not any(self.library.is_seen(materials[slot]) for slot in used):
            self.unseen.add(source.original.name)
            return None
        sides = [self.library.sides.get(material, (material, material)) for material in materials]
        if any(front is not back for front, back in sides):
            made, materials = made.sided(len(materials)), [side[at] for at in (0, 1) for side in sides]
        if any(self.library.wants_atlas(material, made) for material in materials):
            made = made.unwrapped()
        number = self.known.setdefault(made.known_by(), len(self.geometries))
        if number == len(self.geometries):
            made.size = float(f"{self.size or 1.0:.2g}")
            self.geometries.append(made)
        return number, tuple(materials)

    def reach(self, number):
        """Maximum distance of a geometry from its origin."""
        if number not in self.reaches:
            positions = self.geometries[number].positions
            self.reaches[number] = float(numpy.linalg.norm(positions, axis=1).max(initial=0.0))
        return self.reaches[number]


def is_velocity(attribute):
    return attribute is not None and (attribute.domain, attribute.data_type) == ("POINT", "FLOAT_VECTOR")


def cannot_change(original, data):
    """Whether a mesh is the same at every moment: not keyed, not deformed and not changed by scripts; one
    made for instances may vary."""
    handlers = bpy.app.handlers
    return (
        original.type == "MESH"
        and not (handlers.frame_change_pre or handlers.frame_change_post)
        and not original.modifiers
        and original.data.shape_keys is None
        and original.data.animation_data is None
        and data.name == original.data.name
        and VELOCITY not in data.attributes
    )


def own_materials(thing):
    """Numbers and materials of slots that are linked to the object."""
    own = ((index, material_in(slot, thing, index)) for index, slot in enumerate(thing.material_slots) if slot.link == "OBJECT")
    return tuple((index, material.name_full if material else "") for index, material in own)


def materials_of(thing, data):
    """Material of each slot: the object's own if it is linked so, else the mesh's."""
    slots, of_data = thing.material_slots, list(data.materials)
    found = []
    for index in range(max(len(slots), len(of_data))):
        slot = slots[index] if index < len(slots) else None
        if slot is not None and (slot.link == "OBJECT" or index >= len(of_data)):
            found.append(material_in(slot, thing, index))
        else:
            found.append(of_data[index])
    return found


def material_in(slot, thing, index):
    """Where the object's own slot is empty, Python gives the mesh's material of an evaluated object, and so does Cycles
    of 5.0; later ones have none."""
    own = thing.original.material_slots
    is_empty = slot.link == "OBJECT" and index < len(own) and own[index].material is None
    return None if is_empty and bpy.app.version >= (5, 1) else slot.material
