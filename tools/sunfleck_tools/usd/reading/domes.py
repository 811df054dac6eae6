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
from .lamp_inputs import BRIGHTEST, LampInputs, light_texels
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
        try:
            texels = light_texels(asset)
        except PictureError as error:
            said = f"the picture `{asset.path}` is left out: {error}: the sky has its colour alone"
            lost.add("usd-texture", prim, said)
            return even
        # Of one colour alone, as Blender writes plain skies, nothing is lost.
        if np.ptp(texels, axis=(0, 1)).max() > 0.0:
            said = "the picture of a DomeLight that is not upright, or not by longitude and latitude, is not carried: its mean is"
            lost.add("usd-dome-picture", prim, said)
        mean = np.average(texels, axis=(0, 1), weights=_solid_angles(texels.shape, form))
        return {**even, "color": np.minimum(radiance * mean, BRIGHTEST).tolist()}
    try:
        image = picture_uri(asset, str(prim.GetPath()))
    except SceneError as error:
        said = str(error).removeprefix(f"{prim.GetPath()}: ")
        lost.add("usd-texture", prim, f"{said}: the sky has its colour alone")
        return even
    # The picture's centre is +z of the dome, and -z of the sky.
    rotation = math.atan2(-axes[0, 2], -axes[2, 2])
    return {"image": image, "strength": radiance.tolist(), "rotation": rotation, "lights": "surfaces_and_fog"}


def _solid_angles(shape: tuple[int, ...], form: str) -> np.ndarray:
    """Relative solid angles of a sky's texels, in the shape of its texels."""
    y, x = ((2 * np.arange(count) + 1) / count - 1 for count in shape[:2])
    radius = np.hypot(y[:, None], x)
    if form == UsdLux.Tokens.angular:
        # The angle from the centre is pi times the radius.
        weights = np.sinc(radius) * (radius < 1)
    elif form == UsdLux.Tokens.mirroredBall:
        # A ball's reflection in parallel rays keeps areas: the radius is the sine of half the angle.
        weights = (radius < 1) * 1.0
    elif form in (UsdLux.Tokens.automatic, UsdLux.Tokens.latlong):
        weights = np.broadcast_to(np.cos(math.pi / 2 * y)[:, None], shape[:2])
    else:
        # Of a cross of three by four faces six are none.
        is_face = (np.abs(x) < 1 / 3) | (np.abs(y[:, None] + 0.25) < 0.25)
        weights = np.where(is_face, 1.0, 1e-9)
    return np.broadcast_to(weights[..., None], shape)


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
