"""Simulations: detection, and filling of their caches.

A render graph reads the caches of simulations and never steps them; the viewport's graph steps them, frame
by frame. So it evaluates all frames first, with simulated objects visible. Invariant: visibility is
restored afterwards.
"""

from collections import deque
from contextlib import contextmanager
from functools import cache

import bpy

from ..keys import trees_of

PHYSICS = {"CLOTH", "SOFT_BODY", "FLUID", "DYNAMIC_PAINT", "PARTICLE_SYSTEM", "EXPLODE"}


def any_in(scene):
    world = scene.rigidbody_world
    return bool(world and world.enabled) or any(True for _ in objects(scene))


def objects(scene):
    """Simulated objects of the scene and its background sets, and of what these show."""
    things = []
    while scene is not None:
        things += scene.objects
        scene = scene.background_set
    # Many objects share a group of nodes.
    named, steps = cache(named_in), cache(has_zone)
    return (one for one in with_those(things, lambda thing: shown_by(thing, named)) if simulates(one, steps))


def with_instanced(things, is_there=lambda thing: True):
    """Objects and those of the collections that they show, each once, as far as they are there."""
    return with_those(things, lambda thing: [thing.instance_collection] if thing.instance_type == "COLLECTION" else [], is_there)


def with_those(things, shown, is_there=lambda thing: True):
    """Objects and what they show, breadth first, each once."""
    seen, waiting = set(), deque(things)
    while waiting:
        thing = waiting.popleft()
        if thing in seen or not is_there(thing):
            continue
        seen.add(thing)
        yield thing
        for one in shown(thing):
            if isinstance(one, bpy.types.Object):
                waiting.append(one)
            elif isinstance(one, bpy.types.Collection) and one not in seen:
                seen.add(one)
                waiting.extend(one.all_objects)


def shown_by(thing, named):
    """Objects and collections that an object shows, or that its nodes ask for; and what else these ask for."""
    if thing.instance_type == "COLLECTION":
        yield thing.instance_collection
    for system in thing.particle_systems:
        yield system.settings.instance_object
        yield system.settings.instance_collection
    for modifier in thing.modifiers:
        if modifier.type == "NODES" and modifier.node_group is not None:
            yield from inputs_of(modifier)
            yield from named(modifier.node_group)


def named_in(group):
    """Objects and collections that sockets of nodes name."""
    sockets = (socket for tree in trees_of(group) for node in tree.nodes for socket in node.inputs)
    return [socket.default_value for socket in sockets if socket.type in {"OBJECT", "COLLECTION"}]


def inputs_of(modifier):
    """Values of a modifier of nodes; custom properties in Blender 5.0."""
    if not hasattr(modifier, "properties"):
        return modifier.values()
    inputs = modifier.properties.inputs
    return [getattr(getattr(inputs, one.identifier), "value", None) for one in inputs.bl_rna.properties if one.type == "POINTER"]


def simulates(thing, steps):
    return any(is_simulated(modifier, steps) for modifier in thing.modifiers)


def is_simulated(modifier, steps):
    return modifier.type in PHYSICS or (modifier.type == "NODES" and steps(modifier.node_group))


def has_zone(group):
    """Whether nodes, or a group of theirs, have a simulation zone."""
    return any(node.bl_idname == "GeometryNodeSimulationOutput" for tree in trees_of(group) for node in tree.nodes)


@contextmanager
def run(scene, layer, frames):
    """Caches stay full during the block; any change of visibility would empty them."""
    switched, steps = [], cache(has_zone)

    def switch(owner, name, value):
        if getattr(owner, name) != value:
            switched.append((owner, name, getattr(owner, name)))
            setattr(owner, name, value)

    try:
        for thing in objects(scene):
            switch(thing, "hide_viewport", False)
            for modifier in thing.modifiers:
                if modifier.show_render and is_simulated(modifier, steps):
                    switch(modifier, "show_viewport", True)
            for collection in thing.users_collection:
                switch(collection, "hide_viewport", False)
        for collection in layer_collections(layer.layer_collection):
            if any(simulates(thing, steps) for thing in collection.collection.objects):
                switch(collection, "hide_viewport", False)
        forget_skipped(scene)
        for frame in frames:
            scene.frame_set(frame)
        yield
    finally:
        for owner, name, value in reversed(switched):
            setattr(owner, name, value)


def forget_skipped(scene):
    """Has what was simulated across frames that nobody looked at simulated anew: it is not exact."""
    holders = [one for thing in objects(scene) for one in (*thing.modifiers, *thing.particle_systems)]
    for cache in (getattr(holder, "point_cache", None) for holder in holders):
        if cache and cache.is_frame_skip and not (cache.is_baked or cache.use_external):
            # What is set, to whatever, makes it outdated.
            cache.frame_step = cache.frame_step


def layer_collections(top):
    """A layer collection and all its descendants."""
    yield top
    for child in top.children:
        yield from layer_collections(child)
