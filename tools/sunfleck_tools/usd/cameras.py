"""Cameras. USD measures lenses in tenths of a scene unit, here tenths of a metre."""

import math

import numpy as np
from pxr import Gf

from ..gltf.nodes import Node
from ..gltf.scene import Gltf
from .prims import Prim, Types
from .samples import Sampler

TENTHS_PER_MM = 0.01
DEFAULT_ASPECT = 16 / 9


def write_camera(prim: Prim, node: Node, gltf: Gltf, sampler: Sampler, for_blender: bool) -> None:
    """Writes the camera of a node. For orthographic cameras Blender 5.0 uses whole units where USD has
    tenths."""
    cameras = gltf.document.items("cameras")
    source = node.source.need("camera").item_of(cameras, "camera")
    ours = source.extras.group("sunfleck_camera")
    sensor = ours.number_at("sensor_width_mm", 36.0, 1e-3, 1e6) * TENTHS_PER_MM
    width, height = gltf.settings.size
    if source.text_at("type") == "orthographic":
        lens = source.need("orthographic")
        half = lens.need("ymag").number(1e-9)
        aspect = width / height if height else lens.need("xmag").number(1e-9) / half
        prim.set("projection", Types.Token, "orthographic")
        codes, heights = sampler.numbers(gltf.control(node.name, "sunfleck_camera.height"), 2 * half)
        heights = heights * (1 if for_blender else 10)
        prim.animate("verticalAperture", Types.Float, codes, heights.tolist())
        prim.animate("horizontalAperture", Types.Float, codes, (aspect * heights).tolist())
        frame_width, frame_height = aspect * heights[0], heights[0]
    else:
        lens = source.need("perspective")
        aspect = width / height if height else lens.number_at("aspectRatio", DEFAULT_ASPECT, 1e-6, 1e6)
        frame_width, frame_height = sensor, sensor / aspect
        prim.set("horizontalAperture", Types.Float, frame_width)
        prim.set("verticalAperture", Types.Float, frame_height)
        fov_y = lens.need("yfov").number(1e-9, math.pi)
        codes, angles = sampler.numbers(gltf.control(node.name, "sunfleck_camera.yfov"), fov_y)
        prim.animate("focalLength", Types.Float, codes, (0.5 * frame_height / np.tan(0.5 * angles)).tolist())
    _write_shift(prim, ours, frame_width, frame_height)
    near, far = lens.number_at("znear", 0.1, 0), lens.number_at("zfar", 1e7, 0)
    prim.set("clippingRange", Types.Float2, Gf.Vec2f(near, far))
    if ours.member("fstop") is not None and ours.member("focus_distance") is not None:
        for name, field in (("fStop", "fstop"), ("focusDistance", "focus_distance")):
            control = gltf.control(node.name, f"sunfleck_camera.{field}")
            codes, values = sampler.numbers(control, ours.need(field).number(0))
            prim.animate(name, Types.Float, codes, values.tolist())
    opening, closing = gltf.settings.shutter
    if closing > opening:
        prim.set("shutter:open", Types.Double, opening)
        prim.set("shutter:close", Types.Double, closing)
    if ours.raw:
        prim.remember({"sunfleck_camera": ours.raw})


def _write_shift(prim: Prim, ours, frame_width: float, frame_height: float) -> None:
    """Writes the shift, a fraction of the picture's longer side, to the right and up."""
    shift = ours.member("shift")
    if shift is None:
        return
    longer = max(frame_width, frame_height)
    for name, value in zip(("horizontal", "vertical"), shift.numbers(2)):
        if value:
            prim.set(f"{name}ApertureOffset", Types.Float, value * longer)

