#!/usr/bin/env bash
# ffmpeg moves OpenEXR pictures whose display window does not begin at 0 0, and cuts off what leaves the frame.
#
# Expected: in OpenEXR the display window is the picture, wherever it begins, and pixels are counted in the same plane. A
# tile of a larger plane, or a format that has its origin in the middle of the picture, has a display window from 100 50
# or from -8 -8 on, and looks the same as one from 0 0 on. What happens: ffmpeg 9.0.2 takes the size of the display window
# and forgets where it begins, and puts the data window at its own numbers. A picture of 32 x 24 from 100 50 on is
# black, one from 4 3 on goes 4 to the right and 3 down, one from -8 -8 on shows its lower right part at the upper left.
# Nothing is said, and the size is right, so that a film of such frames is black or off. OpenImageIO has all of it.
# Remedy: set both windows back to 0 0 before: `oiiotool frame.exr --origin +0+0 --fullpixels -o moved.exr`.
# Versions: ffmpeg 9.0.2 of imageio-ffmpeg 0.8.1, OpenEXR 3.5.3, OpenImageIO 3.2.2.0, numpy 2.5.5 (PyPI); ffmpeg 7.0.2 too.
# Source: measured here; https://openexr.com/en/latest/TechnicalIntroduction.html (display window, data window)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet imageio-ffmpeg==0.8.1 OpenEXR==3.5.3 OpenImageIO==3.2.2.0 numpy==2.5.5
cat >windows.py <<'END'
import subprocess

import imageio_ffmpeg
import numpy as np
import OpenEXR

WIDTH, HEIGHT = 32, 24
PICTURE = np.add.outer(np.arange(HEIGHT), np.arange(WIDTH) / 100).astype(np.float32) + 1  # each pixel a number of its own


def write(name, x, y):
    window = (np.array([x, y], np.int32), np.array([x + WIDTH - 1, y + HEIGHT - 1], np.int32))
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "dataWindow": window, "displayWindow": window}
    OpenEXR.File(header, {channel: PICTURE.copy() for channel in "RGB"}).write(name)


def by_ffmpeg(name):
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-v", "warning", "-i", name, "-f", "rawvideo", "-pix_fmt", "gbrpf32le", "-"]
    run = subprocess.run(command, capture_output=True, check=True)
    return np.frombuffer(run.stdout, np.float32).reshape(3, HEIGHT, WIDTH)[2], run.stderr.decode().strip()


def moved(x, y):
    """The picture, moved within a black frame of its size."""
    frame = np.zeros((HEIGHT * 9, WIDTH * 9), np.float32)
    frame[HEIGHT * 4 + y : HEIGHT * 5 + y, WIDTH * 4 + x : WIDTH * 5 + x] = PICTURE
    return frame[HEIGHT * 4 : HEIGHT * 5, WIDTH * 4 : WIDTH * 5]


version = imageio_ffmpeg.get_ffmpeg_version().split("-")[0].lstrip("n")
for x, y in [(0, 0), (4, 3), (-8, -8), (100, 50)]:
    write("tile.exr", x, y)
    subprocess.run(
        ["venv/bin/oiiotool", "tile.exr", "--origin", "+0+0", "--fullpixels", "-o", "back.exr"], check=True)
    found, said = by_ffmpeg("tile.exr")
    again, _ = by_ffmpeg("back.exr")
    print("ffmpeg", version, "display window from", x, y, "on: %d of %d pixels are right, %d are black; moved back %d are right" % (
        (found == PICTURE).sum(), PICTURE.size, (found == 0).sum(), (again == PICTURE).sum()), said, flush=True)
    if not np.array_equal(found, moved(x, y)[:HEIGHT, :WIDTH] if abs(x) < WIDTH else 0 * PICTURE) or said:
        raise SystemExit("this has changed")
    if not np.array_equal(again, PICTURE):
        raise SystemExit("the remedy has changed")
END
venv/bin/python windows.py
