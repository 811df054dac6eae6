"""Linear light as an OpenEXR file of three floats a pixel."""

import os
from pathlib import Path

import numpy as np
import OpenEXR


def write_colors(path: Path, pixels: np.ndarray, comments: str = "") -> None:
    """Writes rows of red, green and blue as a file that appears whole. Raises `RuntimeError`, or
    `OSError`."""
    header = {"type": OpenEXR.scanlineimage, "compression": OpenEXR.ZIP_COMPRESSION}
    if comments:
        header["comments"] = comments
    channels = {
        letter: np.ascontiguousarray(pixels[..., index], np.float32) for index, letter in enumerate("RGB")
    }
    part = path.with_name(f".{path.name}.{os.getpid()}.sunfleck-part")
    try:
        with OpenEXR.File(header, channels) as file:
            file.write(os.fsencode(part))
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)
