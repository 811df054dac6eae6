"""Keyed and driven properties of Blender's data.

In goes an owner of animation data, out come curves: of drivers, of the action and of every NLA strip,
nested ones included. Invariant: nodes inside groups are included.
"""

from collections.abc import Iterator

import bpy


def curves_of(owner: bpy.types.ID) -> Iterator[bpy.types.FCurve]:
    """F-curves and drivers of an owner itself."""
    data = getattr(owner, "animation_data", None)
    if data is None:
        return
    yield from data.drivers
    yield from of_action(data.action, data.action_slot)
    for track in data.nla_tracks:
        for strip in strips_of(track):
            yield from of_action(strip.action, strip.action_slot)
            yield from strip.fcurves


def strips_of(owner: bpy.types.NlaTrack | bpy.types.NlaStrip) -> Iterator[bpy.types.NlaStrip]:
    """Strips of a track, or of a strip that contains others."""
    for strip in owner.strips:
        yield strip
        yield from strips_of(strip)


def of_action(
    action: bpy.types.Action | None, slot: bpy.types.ActionSlot | None
) -> Iterator[bpy.types.FCurve]:
    if action is None or slot is None:
        return
    for layer in action.layers:
        for strip in layer.strips:
            bag = strip.channelbag(slot)
            yield from bag.fcurves if bag else ()


def trees_of(first: bpy.types.NodeTree | None) -> list[bpy.types.NodeTree]:
    """A node tree, and all groups in it."""
    found: list[bpy.types.NodeTree] = []
    waiting = [first]
    while waiting:
        tree = waiting.pop()
        if tree is not None and tree not in found:
            found.append(tree)
            waiting += [getattr(node, "node_tree", None) for node in tree.nodes]
    return found


def moves(thing: bpy.types.Object) -> bool:
    """Whether an object, or what it hangs on, is keyed, driven or constrained."""
    return (
        any(True for _ in curves_of(thing)) or bool(thing.constraints) or (thing.parent is not None and moves(thing.parent))
    )


def changes(owner: bpy.types.ID) -> bool:
    """Whether any property of a material, light or world is keyed or driven, or an object of its nodes may move."""
    return any(True for one in (owner, *trees_of(getattr(owner, "node_tree", None))) for _ in curves_of(one)) or any(map(moves, objects_of(owner)))


def objects_of(owner: bpy.types.ID) -> Iterator[bpy.types.Object]:
    """Objects in whose space a material, light or world has a texture."""
    for tree in trees_of(getattr(owner, "node_tree", None)):
        for node in tree.nodes:
            thing = getattr(node, "object", None)
            if isinstance(thing, bpy.types.Object):
                yield thing
