"""Where small scenes are set that are rendered beside Cycles: what stands there, and lamps."""

import math

import bpy
import numpy
import scenes
import stages

SIZE = (96, 54)


def stage(size=SIZE):
    """A floor, a wall that leans, and a card above the floor to throw a shadow; all matte."""
    scene = scenes.empty(stages.FRAMES, size)
    scenes.camera(scene)
    scenes.quad(scene, "floor", 8.0, scenes.material("floor", (0.6, 0.5, 0.4)))
    wall = scenes.quad(scene, "wall", 6.0, scenes.material("wall", (0.3, 0.5, 0.7)), (0.0, 3.0, 1.0))
    wall.rotation_euler = (math.radians(80.0), 0.0, 0.0)
    scenes.quad(scene, "card", 0.8, scenes.material("card", (0.7, 0.2, 0.1)), (0.3, 0.2, 0.9))
    return scene


def lamp(scene, kind, **values):
    data = bpy.data.lights.new(kind.lower(), kind)
    for name, value in values.items():
        setattr(data, name, value)
    made = scenes.add(scene, kind.lower(), data, (1.2, -0.8, 2.2), (0.0, 0.6, 0.2))
    made.visible_camera = False
    return made


def with_uv(thing):
    thing.data.uv_layers.new(name="UVMap").uv.foreach_set(
        "vector", numpy.array([0, 0, 1, 0, 1, 1, 0, 1], "f4")
    )
    return thing


def shaded(name, tree):
    """The floor or the wall, with a material."""
    thing = with_uv(bpy.data.objects[name])
    thing.data.materials[0] = tree.material
    return thing
