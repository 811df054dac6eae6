"""Sky as a DomeLight: of one colour, or with a picture, its own or one of its gradient.

USD has OpenEXR's orientation of pictures, with +z in the centre and -x to its right. The renderer has -z
in the centre, so a dome is rotated by half a turn. Invariant: a sky that lights nothing in the renderer is
no light here.
"""

import math

from pxr import Gf, Sdf, Vt

from ..gltf.sky import Sky
from .prims import Names, Prim, Types
from .textures import Textures


def sky_picture(sky: Sky | None, textures: Textures) -> Sdf.AssetPath | None:
    """Image of the sky as a file beside the stage, if it has one."""
    return None if sky is None or sky.image is None else Sdf.AssetPath(textures.sky_file(sky.image))


def write_sky(
    world: Prim, sky: Sky | None, picture: Sdf.AssetPath | None, textures: Textures, names: Names
) -> bool:
    """Writes the sky; returns True if it lights the scene."""
    if sky is None or sky.lights == "nothing":
        return False
    prim = world.child(names.new("sky"), "DomeLight")
    if picture is not None:
        prim.set("xformOp:rotateY", Types.Double, 180.0 + math.degrees(sky.rotation_rad))
        prim.set("xformOpOrder", Types.TokenArray, Vt.TokenArray(["xformOp:rotateY"]), uniform=True)
    elif sky.gradient is not None:
        picture = Sdf.AssetPath(textures.picture_file("sky", sky.gradient))
    brightest = float(sky.radiance.max())
    prim.set("inputs:intensity", Types.Float, brightest)
    color = sky.radiance / brightest if brightest > 0 else sky.radiance
    prim.set("inputs:color", Types.Color3f, Gf.Vec3f(*color.tolist()))
    if picture is not None:
        prim.set("inputs:texture:file", Types.Asset, picture)
        prim.set("inputs:texture:format", Types.Token, "latlong")
    return True
