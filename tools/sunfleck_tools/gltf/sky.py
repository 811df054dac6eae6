"""Sky of a scene: `sunfleck_env` of a glTF file. Invariant: it has a colour, a gradient or an image, and
only one of them."""

from dataclasses import dataclass

import numpy as np

from .scene import Gltf
from .values import Value

ROWS, COLUMNS = 1024, 4
"""Size of a gradient's picture: a row for every sixth of a degree, and equal columns."""


@dataclass(frozen=True)
class Sky:
    """`radiance` in W/(m2 sr) where the image or the gradient (rows from zenith to nadir) is 1, if there is
    one.

    An image has -z in its centre, and is rotated about +y by `rotation_rad`. `lights` is `nothing`,
    `surfaces` or `surfaces_and_fog`.
    """

    lights: str
    radiance: np.ndarray
    image: Value | None
    gradient: np.ndarray | None
    rotation_rad: float


def read_sky(gltf: Gltf) -> Sky | None:
    """The sky, if there is one."""
    source = gltf.extras.group("sunfleck_env")
    if not source.raw:
        return None
    strength, color, image = (source.member(name) for name in ("strength", "color", "image"))
    radiance = np.ones(3) if strength is None else np.array(strength.channels())
    gradient = None
    if color is not None:
        radiance = radiance * color.channels()
    elif image is None:
        ground = source.member("ground")
        below = [0.0] * 3 if ground is None else ground.channels()
        colors = [source.need("zenith").channels(), source.need("horizon").channels(), below]
        gradient = _gradient(*map(np.array, colors))
    return Sky(
        source.text_at("lights", "nothing"), radiance, image, gradient, source.number_at("rotation", 0.0)
    )


def _gradient(zenith: np.ndarray, horizon: np.ndarray, ground: np.ndarray) -> np.ndarray:
    """Radiance of each row at its centre: linear in the sine of the elevation."""
    height = np.cos(np.pi * (np.arange(ROWS) + 0.5) / ROWS)[:, None]
    rows = np.where(height > 0, horizon + (zenith - horizon) * height, ground)
    return np.repeat(rows[:, None], COLUMNS, axis=1).astype(np.float32)
