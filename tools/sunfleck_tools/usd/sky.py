"""The sky as a DomeLight: of one colour, or with a picture of its gradient.

Invariant: what lights nothing in the renderer is no light here.
"""

from __future__ import annotations

import numpy as np
from pxr import Gf, Sdf

from ..gltf.scene import Gltf
from .prims import Names, Prim, Types
from .textures import Textures

ROWS, COLUMNS = 1024, 4
"""Of the picture: a row for every sixth of a degree, and columns that are all the same."""


def write_sky(world: Prim, gltf: Gltf, textures: Textures, names: Names) -> bool:
    """True if there is a sky that lights the scene."""
    sky = gltf.extras.group("sunfleck_env")
    if sky.text_at("lights", "nothing") == "nothing":
        return False
    prim = world.child(names.new("sky"), "DomeLight")
    strength = sky.number_at("strength", 1.0, 0.0)
    if (color := sky.member("color")) is not None:
        radiance = np.array(color.channels()) * strength
        brightest = float(radiance.max())
        prim.set("inputs:intensity", Types.Float, brightest)
        prim.set("inputs:color", Types.Color3f, Gf.Vec3f(*(radiance / brightest if brightest > 0 else radiance).tolist()))
    else:
        ground = sky.member("ground")
        colors = [sky.need("zenith").channels(), sky.need("horizon").channels(), [0.0] * 3 if ground is None else ground.channels()]
        prim.set("inputs:intensity", Types.Float, strength)
        prim.set("inputs:texture:file", Types.Asset, Sdf.AssetPath(textures.picture_file("sky", gradient(*map(np.array, colors)))))
        prim.set("inputs:texture:format", Types.Token, "latlong")
    prim.remember({"sunfleck_env": sky.raw})
    return True


def gradient(zenith: np.ndarray, horizon: np.ndarray, ground: np.ndarray) -> np.ndarray:
    """Rows from straight up to straight down, each the radiance at its middle: linear in the sine of the elevation."""
    height = np.cos(np.pi * (np.arange(ROWS) + 0.5) / ROWS)[:, None]
    rows = np.where(height > 0, horizon + (zenith - horizon) * height, ground)
    return np.repeat(rows[:, None], COLUMNS, axis=1).astype(np.float32)
