#!/usr/bin/env bash
# oiiotool and maketx make soft edges of leaves darker on the way from PNG to EXR; from Python the same step is right.
#
# Expected: a PNG keeps colours apart from alpha. A pixel of 188, which is 0.5 in linear light, with an alpha of a half is
# 0.25 with an alpha of 0.5 in OpenEXR. What happens: OpenImageIO 3.2.2 multiplies the encoded colour by alpha as it reads
# a PNG. `oiiotool --colorconvert` and `--autocc`, and `maketx --colorconvert`, decode what comes of that: 0.112. Leaves
# have dark rims over anything that is laid below, and soft masks are too dark all over. `ImageBufAlgo.colorconvert` in
# Python undoes alpha by default, oiiotool and maketx do not. Where alpha is 0 or 1 all is right, and on the way back the
# error undoes itself, so that a round trip shows nothing. Nothing is said.
# Remedy: `--colorconvert:unpremult=1 srgb_tx lin_rec709`, and no `--autocc`; `maketx --unpremult`.
# Versions: OpenImageIO 3.2.2.0 with numpy 2.5.5, Pillow 12.3.0 (PyPI). Source: measured here;
# https://openimageio.readthedocs.io/en/stable/oiiotool.html (unpremult=); discussion 4054 of OpenImageIO, of 2023
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet openimageio==3.2.2.0 numpy==2.5.5 pillow==12.3.0
cat >edges.py <<'END'
import subprocess
import sys

import numpy as np
import OpenImageIO as oiio
from PIL import Image

TOOLS = sys.argv[1]
TO_LIGHT = ("srgb_tx", "lin_rec709")

Image.fromarray(np.full((64, 64, 4), [188, 188, 188, 128], np.uint8), "RGBA").save("leaf.png")
runs = {
    "oiiotool --colorconvert": ["oiiotool", "leaf.png", "--colorconvert", *TO_LIGHT, "-d", "float", "-o", "leaf.exr"],
    "oiiotool --autocc": ["oiiotool", "--autocc", "leaf.png", "-d", "float", "-o", "leaf.exr"],
    "maketx": ["maketx", "leaf.png", "--colorconvert", *TO_LIGHT, "-d", "float", "-o", "leaf.exr"],
    "oiiotool --colorconvert:unpremult=1": [
        "oiiotool", "leaf.png", "--colorconvert:unpremult=1", *TO_LIGHT, "-d", "float", "-o", "leaf.exr"],
    "maketx --unpremult": ["maketx", "leaf.png", "--unpremult", "--colorconvert", *TO_LIGHT, "-d", "float", "-o", "leaf.exr"],
    "Python": None,
}
for name, command in runs.items():
    if command:
        subprocess.run([f"{TOOLS}/{command[0]}", *command[1:]], check=True, capture_output=True)
    else:
        oiio.ImageBufAlgo.colorconvert(oiio.ImageBuf("leaf.png"), *TO_LIGHT).write("leaf.exr", "float")
    wanted = 0.25 if "unpremult" in name or name == "Python" else 0.112
    light = oiio.ImageBuf("leaf.exr").getpixel(0, 0)[0]
    subprocess.run([f"{TOOLS}/oiiotool", "leaf.exr", "--selectmip", "0", f"--colorconvert:unpremult={int(wanted > 0.2)}",
                    *reversed(TO_LIGHT), "-o", "again.png"], check=True)
    again = int(np.array(Image.open("again.png"))[0, 0, 0])
    print("OpenImageIO", oiio.VERSION_STRING, name + ":", round(light, 3), "in EXR for 0.25,", again, "in PNG for 188", flush=True)
    if abs(light - wanted) > 0.003 or abs(again - 188) > 2:
        raise SystemExit("this has changed")
END
venv/bin/python edges.py venv/bin
