"""Cameras of Blender as cameras of glTF.

In goes an evaluated camera and the picture's shape, out comes glTF's. Invariant: angles are of the
picture's height, whatever side Blender fits them to.
"""

import math
from typing import Any

import bpy

from .. import extras


def camera(data: bpy.types.Camera, scene: bpy.types.Scene) -> dict[str, Any] | None:
    """glTF camera; None for types that glTF lacks."""
    width, height = extras.picture_sides(scene)
    near, far = max(data.clip_start, 1e-9), data.clip_end
    if data.type == "PERSP":
        said = {"aspectRatio": width / height, "yfov": field_of_view(data, scene), "znear": near, "zfar": far}
        return {"name": data.name, "type": "perspective", "perspective": said}
    if data.type == "ORTHO":
        half = 0.5 * data.ortho_scale / extras.fitted_side(data, scene)
        said = {"xmag": half * width, "ymag": half * height, "znear": max(0.0, data.clip_start), "zfar": far}
        return {"name": data.name, "type": "orthographic", "orthographic": said}
    return None


def field_of_view(data: bpy.types.Camera, scene: bpy.types.Scene) -> float:
    """Vertical field of view, radians; tangents of half angles are proportional to the sides."""
    _, height = extras.picture_sides(scene)
    sensor = data.sensor_height if data.sensor_fit == "VERTICAL" else data.sensor_width
    return 2.0 * math.atan(0.5 * sensor / data.lens * height / extras.fitted_side(data, scene))
