"""Objects so near to a lamp that its extent is visible.

In go a lamp and objects, out comes whether any of them is near. Invariant: only unmodified meshes are
checked, those with many faces by their vertices.
"""

import numpy
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from .evaluated.attributes import numbers

MOST_FACES = 20_000


def is_near_to_any(lamp, others):
    reach, place = lamp.data.shadow_soft_size, lamp.matrix_world.translation
    return reach > 0.0 and any(distance(thing, place, reach) < reach for thing in others)


def distance(thing, place, reach):
    """Distance in the world; beyond `reach` it is any larger value."""
    if thing.type != "MESH" or thing.hide_render or not thing.data.polygons:
        return numpy.inf
    world = thing.matrix_world
    low, high = Vector(thing.bound_box[0]), Vector(thing.bound_box[6])
    radius = 0.5 * (high - low).length * max(map(abs, world.to_scale()))
    if (world @ (0.5 * (low + high)) - place).length - radius >= reach:
        return numpy.inf
    mesh, local = thing.data, world.inverted_safe() @ place
    if len(mesh.polygons) > MOST_FACES:
        places = numbers(mesh.vertices, "co", (len(mesh.vertices), 3), "f4")
        nearest = places[numpy.square(places - numpy.array(local)).sum(axis=1).argmin()]
    else:
        tree = BVHTree.FromPolygons([one.co for one in mesh.vertices], [one.vertices for one in mesh.polygons])
        nearest = tree.find_nearest(local)[0]
    return numpy.inf if nearest is None else float((world @ Vector(nearest) - place).length)
