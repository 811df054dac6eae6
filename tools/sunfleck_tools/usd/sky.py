"""The sky as a DomeLight: of one colour, or with a picture, its own or one of its gradient.

USD has the picture of a dome as OpenEXR has it, +z in its middle and -x to the right of that; the renderer has -z in the middle, so a
dome stands half a turn from it. Invariant: what lights nothing in the renderer is no light here.
"""

from __future__ import annotations

import math

import numpy as np
from pxr import Gf, Sdf, Vt

from ..gltf.scene import Gltf
from .prims import Names, Prim, Types
from .textures import Textures

ROWS, COLUMNS = 1024, 4
"""Of a gradient's picture: a row for every sixth of a degree, and columns that are all the same."""


def sky_picture(gltf: Gltf, textures: Textures) -> Sdf.AssetPath | None:
    """The sky's image as a file beside the stage, if it has one."""
    image = gltf.extras.group("sunfleck_env").member("image")
    return None if image is None else Sdf.AssetPath(textures.sky_file(image))


def write_sky(world: Prim, gltf: Gltf, picture: Sdf.AssetPath | None, textures: Textures, names: Names) -> bool:
    """True if there is a sky that lights the scene."""
    sky = gltf.extras.group("sunfleck_env")
    if sky.text_at("lights", "nothing") == "nothing":
        return False
    prim = world.child(names.new("sky"), "DomeLight")
    strength = sky.member("strength")
    radiance = np.ones(3) if strength is None else np.array(strength.channels())
    if (color := sky.member("color")) is not None:
        radiance = radiance * color.channels()
    elif picture is None:
        ground = sky.member("ground")
        colors = [sky.need("zenith").channels(), sky.need("horizon").channels(), [0.0] * 3 if ground is None else ground.channels()]
        picture = Sdf.AssetPath(textures.picture_file("sky", gradient(*map(np.array, colors))))
    else:
        prim.set("xformOp:rotateY", Types.Double, 180.0 + math.degrees(sky.number_at("rotation", 0.0)))
        prim.set("xformOpOrder", Types.TokenArray, Vt.TokenArray(["xformOp:rotateY"]), uniform=True)
    brightest = float(radiance.max())
    prim.set("inputs:intensity", Types.Float, brightest)
    prim.set("inputs:color", Types.Color3f, Gf.Vec3f(*(radiance / brightest if brightest > 0 else radiance).tolist()))
    if picture is not None:
        prim.set("inputs:texture:file", Types.Asset, picture)
        prim.set("inputs:texture:format", Types.Token, "latlong")
    return True


def gradient(zenith: np.ndarray, horizon: np.ndarray, ground: np.ndarray) -> np.ndarray:
    """Rows from straight up to straight down, each the radiance at its middle: linear in the sine of the elevation."""
    height = np.cos(np.pi * (np.arange(ROWS) + 0.5) / ROWS)[:, None]
    rows = np.where(height > 0, horizon + (zenith - horizon) * height, ground)
    return np.repeat(rows[:, None], COLUMNS, axis=1).astype(np.float32)
