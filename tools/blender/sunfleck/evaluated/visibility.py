"""Ray visibility of objects, as the fields of `sunfleck_object` (docs/scene-format.md).

In go Blender's objects, out comes a dictionary of values other than the defaults. Invariant: a ray sees an
instance if both it and its instancer allow that. As in Cycles, other flags are the instancer's alone.
"""

import bpy


def of_thing(
    thing: bpy.types.Object, instancer: bpy.types.Object | None, layer: bpy.types.ViewLayer
) -> dict[str, bool]:
    """Ray visibility of an object, or of an instance, in a view layer."""
    parent = instancer or thing
    said = {}
    if not (thing.visible_camera and parent.visible_camera) or parent.indirect_only_get(view_layer=layer):
        said["visible_to_camera"] = False
    if not (thing.visible_shadow and parent.visible_shadow):
        said["casts_shadow"] = False
    if parent.holdout_get(view_layer=layer):
        said["holdout"] = True
    return said
