"""Pictures as Mitsuba decodes them: linear light in single precision."""

import tempfile
from pathlib import Path

import mitsuba as mi
import numpy

from ..errors import SceneError
from .pictures import Picture


def colors(picture: Picture) -> numpy.ndarray:
    """Rows of red, green and blue; 8-bit values are sRGB."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            decoded = mi.Bitmap(str(picture.file(Path(folder), "picture")))
        except RuntimeError as error:
            raise SceneError(
                f"Mitsuba cannot read a picture of the scene: {str(error).splitlines()[0]}"
            ) from None
    linear = decoded.convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, srgb_gamma=False)
    return numpy.array(linear)
