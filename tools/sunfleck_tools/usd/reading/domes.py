"""Skies: DomeLights, and pictures of these or of `sunfleck_env`, for the renderer.

Invariant: a returned picture is an upright data URI; a dome may only be rotated about the vertical.
"""

import base64
import math
import tempfile
from pathlib import Path

import numpy as np
from pxr import Ar, Sdf, Usd, UsdGeom, UsdLux

from ...errors import SceneError
from ...exr.codecs import why_unread
from ...exr.write import write_colors
from ...gltf.container import LINEAR_PICTURES
from .lamp_inputs import MEAN_SIZE, LampInputs
from .losses import Losses
from .source import Source
from .texels import PictureError, open_picture

MOST_BYTES = 2**28
"""Maximum bytes of a picture's file."""
UPRIGHT = 1e-4
"""Tolerance of an upright axis, radians."""
DOMES = (UsdLux.DomeLight, UsdLux.DomeLight_1)
Y_FROM_Z = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
"""Transform from a dome with pole z to one with pole y: longitude 0 is +z of the former, and -y of the
latter."""


def is_dome(prim: Usd.Prim) -> bool:
    """True for a DomeLight of any version of the schema."""
    return any(prim.IsA(kind) for kind in DOMES)


def picture_uri(asset: Sdf.AssetPath, place: str) -> str:
    """Data URI of a picture: linear pictures as they are, display pictures converted to linear light.
    Raises `SceneError`."""
    opened = Ar.GetResolver().OpenAsset(Ar.ResolvedPath(asset.resolvedPath)) if asset.resolvedPath else None
    if not opened or opened.GetSize() > MOST_BYTES:
        raise SceneError(f"{place}: the picture `{asset.path}` cannot be read")
    data = bytes(opened.GetBuffer() or b"")
    if not data.startswith(tuple(LINEAR_PICTURES)):
        try:
            data = _exr_of(asset.resolvedPath)
        except PictureError as error:
            raise SceneError(
                f"{place}: the picture `{asset.path}` is neither OpenEXR nor Radiance HDR, and {error}"
            ) from None
    elif (why := why_unread(data)) is not None:
        raise SceneError(f"{place}: the picture `{asset.path}` is not taken: {why}")
    return "data:application/octet-stream;base64," + base64.b64encode(data).decode()


def _exr_of(resolved: str) -> bytes:
    """Display picture as OpenEXR. Raises `PictureError`."""
    picture = open_picture(resolved)
    texels = picture.texels(picture.size, picture.bits == 8 and picture.channels >= 3)[..., :3]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "sky.exr"
        write_colors(path, texels)
        return path.read_bytes()


def read_dome(prim: Usd.Prim, source: Source, ours_from_stage: np.ndarray, lost: Losses) -> dict:
    """`sunfleck_env` of a dome; if its picture cannot be used, that is reported, and the colour remains."""
    inputs = LampInputs(prim, lost)
    radiance = inputs.radiance(source.codes[:1])[0]
    if any(attribute.ValueMightBeTimeVarying() for attribute in inputs.attributes()):
        lost.add("usd-dome-animated", prim, "a sky that changes over time is as it is at first")
    inputs.say_the_rest("DomeLight")
    even = {"color": radiance.tolist(), "strength": 1.0, "lights": "surfaces_and_fog"}
    asset = prim.GetAttribute("inputs:texture:file").Get(source.first)
    if not isinstance(asset, Sdf.AssetPath) or not asset.path:
        return even
    axes = _axes(prim, source, ours_from_stage)
    form = prim.GetAttribute("inputs:texture:format").Get(source.first)
    if form not in (UsdLux.Tokens.automatic, UsdLux.Tokens.latlong) or not axes[1, 1] > math.cos(UPRIGHT):
        mean, is_even = _mean(asset)
        if not is_even:
            said = "the picture of a DomeLight that is not upright, or not by longitude and latitude, is not carried: its mean is"
            lost.add("usd-dome-picture", prim, said)
        return {**even, "color": (radiance * mean).tolist()}
    try:
        image = picture_uri(asset, str(prim.GetPath()))
    except SceneError as error:
        said = str(error).removeprefix(f"{prim.GetPath()}: ")
        lost.add("usd-texture", prim, f"{said}: the sky has its colour alone")
        return even
    # The picture's centre is +z of the dome, and -z of the sky.
    rotation = math.atan2(-axes[0, 2], -axes[2, 2])
    return {"image": image, "strength": radiance.tolist(), "rotation": rotation, "lights": "surfaces_and_fog"}


def _mean(asset: Sdf.AssetPath) -> tuple[np.ndarray, bool]:
    """Mean colour over the sphere, and whether the picture has no other, as Blender writes plain skies; white if it
    cannot be read."""
    try:
        picture = open_picture(asset.resolvedPath)
        size = (min(picture.size[0], MEAN_SIZE), min(picture.size[1], MEAN_SIZE))
        texels = picture.texels(size, picture.bits == 8 and picture.channels >= 3)[..., :3]
    except PictureError:
        return np.ones(3), False
    rows = np.sin(math.pi * (np.arange(size[1]) + 0.5) / size[1])
    return np.average(texels.mean(axis=1), axis=0, weights=rows), bool(np.ptp(texels, axis=(0, 1)).max() == 0.0)


def _axes(prim: Usd.Prim, source: Source, ours_from_stage: np.ndarray) -> np.ndarray:
    """Unit axes of the dome, with y as its pole, in glTF's space."""
    stage_from_dome = np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(source.first), float).T[
        :3, :3
    ]
    if prim.IsA(UsdLux.DomeLight_1):
        pole = UsdLux.DomeLight_1(prim).GetPoleAxisAttr().Get()
        is_z = pole == UsdLux.Tokens.Z or (
            pole == UsdLux.Tokens.scene and UsdGeom.GetStageUpAxis(source.stage) == UsdGeom.Tokens.z
        )
        stage_from_dome = stage_from_dome @ Y_FROM_Z if is_z else stage_from_dome
    axes = ours_from_stage[:3, :3] @ stage_from_dome
    return axes / np.maximum(np.linalg.norm(axes, axis=0), 1e-300)
