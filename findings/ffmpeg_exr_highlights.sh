#!/usr/bin/env bash
# ffmpeg 9 clips OpenEXR of half floats at 1 before any filter sees it: sun, sky and embers are flat. 7 did not.
#
# Expected: OpenEXR holds light, and `exposure`, `tonemap` or an OpenEXR file that is written again have all of it. A pixel
# of 2.5 two stops down is 0.625. What happens: since ffmpeg decodes half floats as `gbrpf16le`, it puts its own scaler
# before whatever wants single floats, filters and its OpenEXR encoder alike, and that goes by way of whole numbers of 16
# bits: 2.5 is 1, two stops down 0.25, -0.5 is 0, and small values move by steps of 1 / 65535. The same picture in single
# floats is right, so that half a sequence may be. ffmpeg 7.0.2, which decoded both as single floats, is right too.
# Nothing is said.
# Remedy: `-vf zscale=w=iw:h=ih,format=gbrpf32le` first of all, which converts without the clip; or write single floats.
# Versions: ffmpeg 9.0.2 of imageio-ffmpeg 0.8.1, ffmpeg 7.0.2 of imageio-ffmpeg 0.6.0, OpenEXR 3.5.3, numpy 2.5.5 (PyPI).
# Source: measured here; https://ffmpeg.org/ffmpeg-filters.html (exposure, tonemap, zscale)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet imageio-ffmpeg==0.8.1 OpenEXR==3.5.3 numpy==2.5.5
venv/bin/pip install --quiet --target old imageio-ffmpeg==0.6.0
cat >clip.py <<'END'
import subprocess
import sys

import imageio_ffmpeg
import numpy as np
import OpenEXR

VALUES = [2.5, 1.0, 0.18, 0.00002, -0.5]
PATHS = [
    ("written again", []), ("two stops down", ["-vf", "exposure=-2"]),
    ("by zscale, two stops down", ["-vf", "zscale=w=iw:h=ih,format=gbrpf32le,exposure=-2"]),
]


def write(name, kind):
    """A row of grey pixels, as wide as ffmpeg likes it."""
    row = np.repeat(np.array(VALUES, kind), 16)[None].repeat(16, 0)
    OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION}, {name: row.copy() for name in "RGB"}).write(name)


def through_ffmpeg(name, options):
    program = imageio_ffmpeg.get_ffmpeg_exe()
    run = subprocess.run(
        [program, "-v", "warning", "-y", "-i", name, *options, "-update", "1", "out.exr"], capture_output=True, text=True)
    pixels = OpenEXR.File("out.exr", separate_channels=True).channels()["R"].pixels
    return [round(float(value), 5) for value in pixels[8, 8::16]], run.stderr.strip()


version = imageio_ffmpeg.get_ffmpeg_version().split("-")[0].lstrip("n")
write("half.exr", np.float16)
write("float.exr", np.float32)
for name in ("half.exr", "float.exr"):
    for path, options in PATHS:
        found, said = through_ffmpeg(name, options)
        print("ffmpeg", version, name, path + ":", *found, said, flush=True)
        clipped = version.startswith("9") and name == "half.exr" and "zscale" not in path
        wanted = np.array(VALUES) * (1 if path == "written again" else 0.25)
        if clipped:
            wanted = np.clip(VALUES, 0, 1) * (1 if path == "written again" else 0.25)
        if not np.allclose(found, wanted, atol=0.0005) or said:
            sys.exit("this has changed")
END
venv/bin/python clip.py
PYTHONPATH=old venv/bin/python clip.py
