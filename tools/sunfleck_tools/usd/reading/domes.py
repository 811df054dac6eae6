"""Skies: a DomeLight, and the picture of either that or `sunfleck_env`, as the renderer takes it.

Invariant: a picture that comes back is a data URI, and is upright: a dome may turn about the vertical alone.
"""

from __future__ import annotations

import base64
import math

import numpy as np
from pxr import Ar, Sdf, Usd, UsdGeom, UsdLux

from ...errors import SceneError
from ..textures import SKY_KINDS
from .losses import Losses
from .source import Source

MOST_BYTES = 2**28
"""Of a picture's file."""
UPRIGHT = 1e-4
"""Radians, about."""


def picture_uri(asset: Sdf.AssetPath, place: str) -> str:
    """The file of a picture. Raises `SceneError`."""
    opened = Ar.GetResolver().OpenAsset(Ar.ResolvedPath(asset.resolvedPath)) if asset.resolvedPath else None
    if not opened or opened.GetSize() > MOST_BYTES:
        raise SceneError(f"{place}: the picture `{asset.path}` cannot be read")
    data = bytes(opened.GetBuffer())
    if not data.startswith(tuple(SKY_KINDS)):
        raise SceneError(f"{place}: the picture `{asset.path}` is neither OpenEXR nor Radiance HDR: convert it")
    return "data:application/octet-stream;base64," + base64.b64encode(data).decode()


def read_dome(light: UsdLux.DomeLight, source: Source, ours_from_stage: np.ndarray, lost: Losses) -> dict | None:
    """`sunfleck_env` of a dome; None, and said, for what cannot be one."""
    place, code = str(light.GetPath()), Usd.TimeCode(source.first)
    exposure = 2.0 ** float(np.clip(light.GetExposureAttr().Get(code) or 0.0, -60, 60))
    radiance = np.maximum(np.array(light.GetColorAttr().Get(code), float) * float(light.GetIntensityAttr().Get(code) or 0.0) * exposure, 0)
    if light.GetEnableColorTemperatureAttr().Get(code):
        radiance = radiance * np.array(UsdLux.BlackbodyTemperatureAsRgb(light.GetColorTemperatureAttr().Get(code)))
    asset = light.GetTextureFileAttr().Get(code)
    if not asset:
        return {"color": radiance.tolist(), "strength": 1.0, "lights": "surfaces_and_fog"}
    stage_from_dome = np.array(UsdGeom.Xformable(light).ComputeLocalToWorldTransform(code), float).T
    axes = (ours_from_stage @ stage_from_dome)[:3, :3]
    axes = axes / np.linalg.norm(axes, axis=0)
    form = light.GetTextureFormatAttr().Get(code)
    if form not in (UsdLux.Tokens.automatic, UsdLux.Tokens.latlong) or not axes[1, 1] > math.cos(UPRIGHT):
        lost.add("usd-dome-picture", place, "the picture of a DomeLight that is not upright, or not by longitude and latitude, is not carried")
        return None
    # The picture's middle is +z of the dome, and -z of the sky.
    rotation = math.atan2(-axes[0, 2], -axes[2, 2])
    image = picture_uri(asset, place)
    return {"image": image, "strength": radiance.tolist(), "rotation": rotation, "lights": "surfaces_and_fog"}
