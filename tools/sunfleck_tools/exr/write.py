"""Linear light as an OpenEXR file of three floats a pixel."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenEXR


def write_colors(path: Path, pixels: np.ndarray, comments: str = "") -> None:
    """Rows of red, green and blue. Raises `RuntimeError`."""
    header = {"type": OpenEXR.scanlineimage, "compression": OpenEXR.ZIP_COMPRESSION}
    if comments:
        header["comments"] = comments
    channels = {letter: np.ascontiguousarray(pixels[..., index], np.float32) for index, letter in enumerate("RGB")}
    with OpenEXR.File(header, channels) as file:
        file.write(str(path))
