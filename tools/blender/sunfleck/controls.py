"""Settings that change over time, as empties that move: glTF animates nodes, so `ctl_*` empties with the property
`sunfleck_ctl` carry numbers in their translation (docs/scene-format.md, "Values that change").

In goes a scene, for the time of a `with` block there are such empties in it. Invariant: the scene is then as before.
"""

import math
from contextlib import contextmanager

import bpy

from . import extras


def values(scene):
    """Every number that may change, by its target: one number, or three for a colour."""
    found = {}
    own = scene.sunfleck_settings
    if own.use_fog:
        fog(found, "scene.sunfleck_fog", own)
        found["scene.sunfleck_fog.scale_height"] = own.scale_height
    for thing in scene.objects:
        if thing.sunfleck_settings.is_fog:
            fog(found, f"{thing.name}.sunfleck_fog_volume", thing.sunfleck_settings)
        if thing.type == "LIGHT":
            light(found, thing)
        if thing.type == "CAMERA" and thing.data.type == "PERSP":
            camera(found, thing, scene)
        found[f"{thing.name}.sunfleck_node.visible"] = 0.0 if thing.hide_render else 1.0
    return found


def fog(found, owner, own):
    found[f"{owner}.density"] = own.density
    found[f"{owner}.albedo"] = tuple(own.albedo)
    found[f"{owner}.anisotropy"] = own.anisotropy


def light(found, thing):
    said = extras.light(thing.data, thing.sunfleck_settings)
    field = "strength_w_m2" if thing.data.type == "SUN" else "power_w"
    owner = f"{thing.name}.sunfleck_light"
    found[f"{owner}.{field}"] = tuple(said[field] * channel for channel in thing.data.color)
    for number in ("angle", "radius", "picture_rotation"):
        if number in said:
            found[f"{owner}.{number}"] = said[number]
    for part in ("real", "imaginary") if "fractal" in said else ():
        found[f"{owner}.fractal_{part}"] = said["fractal"][part]


def camera(found, thing, scene):
    owner = f"{thing.name}.sunfleck_camera"
    data = thing.data
    if data.dof.use_dof:
        found[f"{owner}.fstop"] = data.dof.aperture_fstop
        found[f"{owner}.focus_distance"] = extras.focus_distance(data, scene)
    # Blender's angle is that of the fitted side; tangents of half angles go with the sides.
    _, height = extras.picture_sides(scene)
    sensor = data.sensor_height if data.sensor_fit == "VERTICAL" else data.sensor_width
    found[f"{owner}.yfov"] = 2.0 * math.atan(0.5 * sensor / data.lens * height / extras.fitted_side(data, scene))


def may_change(scene):
    """Whether anything here is animated at all: stepping through all frames takes its time."""
    owners = [scene]
    for thing in scene.objects:
        owners.append(thing)
        if thing.type in {"LIGHT", "CAMERA"}:
            owners += [thing.data, *(target for target in [focus_of(thing)] if target)]
    return any(owner.animation_data and (owner.animation_data.action or owner.animation_data.drivers) for owner in owners)


def focus_of(thing):
    return thing.data.dof.focus_object if thing.type == "CAMERA" else None


def changing(scene):
    """Targets whose value changes, with its value at each frame."""
    if not may_change(scene):
        return {}
    before, tracks = scene.frame_current, {}
    for frame in range(scene.frame_start, scene.frame_end + 1):
        scene.frame_set(frame)
        for target, value in values(scene).items():
            tracks.setdefault(target, []).append(value)
    scene.frame_set(before)
    return {target: track for target, track in tracks.items() if any(value != track[0] for value in track)}


@contextmanager
def empties(scene):
    """There are empties that carry every changing value."""
    made = [carrier(scene, target, track) for target, track in changing(scene).items()]
    try:
        yield made
    finally:
        for empty in made:
            action = empty.animation_data.action
            bpy.data.objects.remove(empty)
            bpy.data.actions.remove(action)


def carrier(scene, target, track):
    empty = bpy.data.objects.new(f"ctl_{target}", None)
    scene.collection.objects.link(empty)
    is_colour = isinstance(track[0], tuple)
    empty["sunfleck_ctl"] = {"target": target, "channel": "translation" if is_colour else "translation.x"}
    for frame, value in enumerate(track, scene.frame_start):
        # The exporter turns (x, y, z) into (x, z, -y).
        empty.location = (value[0], -value[2], value[1]) if is_colour else (value, 0.0, 0.0)
        empty.keyframe_insert("location", frame=frame)
    return empty
