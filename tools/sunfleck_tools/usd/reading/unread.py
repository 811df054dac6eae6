"""Attributes that change a picture and that no other module reads. In goes a prim, out come losses. Invariant: each
such attribute is reported."""

import math
from typing import Any

from pxr import Usd, UsdGeom

from .changes import say_if_it_changes
from .losses import Losses
from .source import Source

BLUR = {"motion:blurScale": 1.0, "motion:velocityScale": 1.0}
"""Attributes of motion blur, and their neutral values."""
DRAWN_AS_IT_IS = (None, "", UsdGeom.Tokens.default_, UsdGeom.Tokens.inherited)
"""Values of `model:drawMode` that draw the model itself; others replace it by cards or boxes."""
OF_CAMERAS = {"focalLength", "horizontalAperture", "verticalAperture", "fStop", "focusDistance", "projection",
              "clippingRange", "horizontalApertureOffset", "verticalApertureOffset", "shutter:open", "shutter:close",
              "purpose", "visibility", "xformOpOrder", "proxyPrim"}  # fmt: skip
"""Attributes of cameras that are read, with those of other prims."""
READ_ONCE = ("projection", "clippingRange", "horizontalApertureOffset", "verticalApertureOffset",
             "shutter:open", "shutter:close")  # fmt: skip
EXPOSURE = ("exposure", "exposure:time", "exposure:iso", "exposure:fStop", "exposure:responsivity")


def say_unread(prim: Usd.Prim, source: Source, lost: Losses) -> None:
    """Reports unread attributes of any prim."""
    authored = source.authored(prim)
    for name, rest in BLUR.items():
        if name in authored:
            attribute = prim.GetAttribute(name)
            value = attribute.Get(source.first)
            if value != rest:
                lost.add("usd-motion", prim, f"its {name} of {value} is not carried: what moves is blurred as it moves")
    if "model:drawMode" in authored:
        mode = prim.GetAttribute("model:drawMode").Get(source.first)
        if mode not in DRAWN_AS_IT_IS:
            lost.add("usd-shape", prim, f"its drawMode `{mode}` is not carried: it is drawn as it is")


def say_unread_of_camera(prim: Usd.Prim, source: Source, lost: Losses) -> float | None:
    """Reports unread attributes of a camera; returns its exposure in stops, if it has one."""
    authored = source.authored(prim)
    for name in READ_ONCE:
        if name in authored:
            say_if_it_changes(prim.GetAttribute(name), source, lost, name, "usd-camera-input")
    usual = prim.GetPrimDefinition().GetPropertyNames()
    for name in sorted(authored & set(usual) - OF_CAMERAS - set(EXPOSURE)):
        attribute = prim.GetAttribute(name)
        fallback = prim.GetPrimDefinition().GetAttributeFallbackValue(name)
        if attribute and attribute.HasAuthoredValue() and _told(attribute.Get(source.first)) != _told(fallback):
            lost.add("usd-camera-input", prim, f"its {name} is not carried")
    if not authored & set(EXPOSURE):
        return None
    scale = UsdGeom.Camera(prim).ComputeLinearExposureScale(source.first)
    for name in EXPOSURE:
        say_if_it_changes(prim.GetAttribute(name), source, lost, name, "usd-camera-input")
    if not (math.isfinite(scale) and scale > 0) or abs(scale - 1) < 1e-6:
        return None
    what = f"its exposure multiplies light by {scale:.6g}: pictures for eyes have it, frames hold the light itself"
    lost.add("usd-camera-input", prim, what)
    return math.log2(scale)


def _told(value: Any) -> object:
    """Comparable value; arrays as lists."""
    return list(value) if hasattr(value, "__len__") and not isinstance(value, str) else value
