"""What lies so near to a lamp that its extent shows.

In go a lamp and things, out comes whether one of them is there. Invariant: only what its own mesh tells is looked at,
without modifiers, of many faces by its vertices.
"""

import numpy
from mathutils import Vector
from mathutils.bvhtree import BVHTree

# Cycles' disc of soft falloff, turned to what it lights, is darker than a sphere by the square of radius by distance.
SOFT_RADII = 10.0
MOST_FACES = 20_000


def is_near_to_any(lamp, others):
    light = lamp.data
    reach = light.shadow_soft_size * (SOFT_RADII if light.use_soft_falloff else 1.0)
    place = lamp.matrix_world.translation
    return reach > 0.0 and any(distance(thing, place, reach) < reach for thing in others)


def distance(thing, place, reach):
    """In the world; beyond a reach it may be any."""
    if thing.type != "MESH" or thing.hide_render or not thing.data.polygons:
        return numpy.inf
    corners = numpy.array([thing.matrix_world @ Vector(corner) for corner in thing.bound_box])
    beyond = numpy.maximum(corners.min(axis=0) - numpy.array(place), numpy.array(place) - corners.max(axis=0)).max()
    if beyond >= reach:
        return numpy.inf
    mesh, local = thing.data, thing.matrix_world.inverted_safe() @ place
    if len(mesh.polygons) > MOST_FACES:
        found = numpy.empty(3 * len(mesh.vertices), "f4")
        mesh.vertices.foreach_get("co", found)
        nearest = found.reshape(-1, 3)[numpy.square(found.reshape(-1, 3) - numpy.array(local)).sum(axis=1).argmin()]
    else:
        tree = BVHTree.FromPolygons([one.co for one in mesh.vertices], [one.vertices for one in mesh.polygons])
        nearest = tree.find_nearest(local)[0]
    return numpy.inf if nearest is None else float((thing.matrix_world @ Vector(nearest) - place).length)
