"""Cameras of a stage as cameras of glTF with `sunfleck_camera`; `usd/cameras.py` explains the units, and
Blender's."""

import math
from dataclasses import dataclass, field

import numpy as np
from pxr import Usd, UsdGeom

from ...errors import SceneError
from .places import codes_of
from .properties import custom_data
from .source import Source

TENTHS = 0.1
NEAREST, FARTHEST = 1e-4, 1e9
"""Clipping distances in place of none, metres, as glTF needs some."""


@dataclass
class Seen:
    """glTF camera with extras, its animated fields (codes and rows), and the times of its shutter."""

    camera: dict
    shutter: tuple[float, float] | None = None
    carried: dict[str, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)


def read_camera(prim: Usd.Prim, source: Source) -> Seen:
    """Camera of a prim."""
    camera = UsdGeom.Camera(prim)
    attributes = [camera.GetFocalLengthAttr(), camera.GetHorizontalApertureAttr(), camera.GetVerticalApertureAttr(),
                  camera.GetFStopAttr(), camera.GetFocusDistanceAttr()]  # fmt: skip
    codes = codes_of(attributes, source.codes)
    # Metres.
    length, wide, high = (_numbers(prim, each, codes) * TENTHS * source.metres for each in attributes[:3])
    f_stop, focus = _numbers(prim, attributes[3], codes), _numbers(prim, attributes[4], codes) * source.metres
    if min(length.min(), wide.min(), high.min()) <= 0:
        raise SceneError(f"{prim.GetPath()}: a camera needs a focal length and apertures above 0")
    extras: dict = {}
    near, far = _clipping_range(camera, source)
    if camera.GetProjectionAttr().Get(source.first) == UsdGeom.Tokens.orthographic:
        scale = 1 / TENTHS if source.for_blender else 1.0
        heights = high * scale
        size = {"xmag": 0.5 * wide[0] * scale, "ymag": 0.5 * heights[0], "znear": near, "zfar": far}
        seen = Seen({"type": "orthographic", "orthographic": size})
        _carry(seen, "height", codes, heights)
    else:
        angles = 2 * np.arctan(0.5 * high / length)
        lens = {"yfov": angles[0], "aspectRatio": wide[0] / high[0], "znear": max(near, NEAREST), "zfar": far}
        seen = Seen({"type": "perspective", "perspective": lens})
        _carry(seen, "yfov", codes, angles)
        extras["sensor_width_mm"] = 1e3 * wide[0]
        if f_stop[0] > 0 and focus[0] > 0:
            extras.update(fstop=f_stop[0], focus_distance=focus[0])
            _carry(seen, "fstop", codes, f_stop)
            _carry(seen, "focus_distance", codes, focus)
    offsets = [camera.GetHorizontalApertureOffsetAttr(), camera.GetVerticalApertureOffsetAttr()]
    shift = [
        float(each.Get(source.first) or 0.0) * TENTHS * source.metres / max(wide[0], high[0])
        for each in offsets
    ]
    if any(shift):
        extras["shift"] = shift
    kept = custom_data(prim).get("sunfleck_camera")
    if isinstance(kept, dict) and "blades" in kept:
        extras["blades"] = int(kept["blades"])
    # Time codes from the frame.
    frames = float(source.fps / source.codes_per_second)
    shutter = (camera.GetShutterOpenAttr(), camera.GetShutterCloseAttr())
    opening, closing = (float(each.Get(source.first) or 0.0) * frames for each in shutter)
    if 0 < closing - opening <= 1000 and abs(opening) <= 1000:
        seen.shutter = opening, closing
    if extras:
        seen.camera["extras"] = {"sunfleck_camera": extras}
    return seen


def _clipping_range(camera: UsdGeom.Camera, source: Source) -> tuple[float, float]:
    """Clipping distances, metres. USD's fallback of 1 to 1,000,000 units is ignored, as it would hide near
    objects."""
    attribute = camera.GetClippingRangeAttr()
    if not attribute.HasAuthoredValue():
        return 0.0, FARTHEST
    near, far = (float(each) * source.metres for each in attribute.Get(source.first))
    near = max(near, 0.0)
    return near, far if far > near else FARTHEST


def _numbers(prim: Usd.Prim, attribute: Usd.Attribute, codes: np.ndarray) -> np.ndarray:
    found = np.array([float(attribute.Get(code) or 0.0) for code in codes.tolist()])
    if not np.isfinite(found).all() or np.abs(found).max() > 1e15 or math.isnan(found.sum()):
        raise SceneError(f"{attribute.GetPath()}: expected finite numbers")
    return found


def _carry(seen: Seen, name: str, codes: np.ndarray, values: np.ndarray) -> None:
    if len(values) > 1 and np.ptp(values) > 0:
        seen.carried[name] = codes, values[:, None]
