"""Of the scenes of `kinds` those of hair."""

import bpy
import mathutils
import numpy
import scenes
from kinds_parts import matte


def hair(scene):
    """Twenty straight hairs, lit from the front and from above."""
    data = bpy.data.hair_curves.new("hair")
    data.add_curves([6] * 20)
    points = numpy.array([[0.12 * (at - 10), 0.0, 0.4 * step] for at in range(20) for step in range(6)], "f4")
    data.position_data.foreach_set("vector", points.ravel())
    data.attributes.new("radius", "FLOAT", "POINT").data.foreach_set("value", numpy.full(120, 0.03, "f4"))
    data.materials.append(matte().material)
    scenes.add(scene, "hair", data)


def hair_from_the_side(scene):
    """Light goes along its row, at 2 degrees; Cycles has it as round as it is here."""
    hair(scene)
    scene.cycles_curves.shape = "THICK"
    scene.objects["sun"].rotation_euler = mathutils.Vector((1.0, 0.035, 0.0)).to_track_quat("-Z", "Y").to_euler()


def hair_of_children(scene):
    """Of particles; their children are shorter, and Cycles has them as round as they are here."""
    head = scenes.quad(scene, "head", 2.0, matte().material, (0.0, 0.0, 0.6))
    settings = head.modifiers.new("hair", "PARTICLE_SYSTEM").particle_system.settings
    settings.type, settings.count, settings.use_advanced_hair = "HAIR", 15, True
    settings.hair_length, settings.root_radius, settings.radius_scale = 1.0, 3.0, 0.01
    settings.child_type, settings.rendered_child_count, settings.child_length = "SIMPLE", 4, 0.7
    scene.cycles_curves.shape = "THICK"
