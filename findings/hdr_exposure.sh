#!/usr/bin/env bash
# Blender, Mitsuba and OpenImageIO read Radiance pictures as if they had no EXPOSURE: skies are too bright or too dark.
#
# Expected: by Radiance's format numbers of a .hdr file were multiplied by each `EXPOSURE=` of its header, and radiance is
# what they are divided by all of these. `pfilt` and other programs of Radiance write such lines. What happens: with lines
# of 2 and 3, so with a radiance of 1/6, Blender 5.3.0, Mitsuba 3.9.1 and OpenImageIO 3.2.2 give 1. OpenImageIO tells one
# of the lines, as `hdr:exposure`: the last, where the product counts. The others say nothing.
# Remedy: divide by the product of the lines, as the strength of the sky for instance (`grep -a ^EXPOSURE= sky.hdr`).
# Versions: bpy 5.3.0, Mitsuba 3.9.1, OpenImageIO 3.2.2.0, numpy 2.5.5 (PyPI). Source: measured here;
# https://radsite.lbl.gov/radiance/refer/Notes/picture_format.html
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 mitsuba==3.9.1 OpenImageIO==3.2.2.0 numpy==2.5.5
cat >read.py <<'END'
import os
import sys

HEAD = "#?RADIANCE\nEXPOSURE=2.0\nEXPOSURE=3.0\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n"
with open("sky.hdr", "wb") as file:
    file.write(HEAD.encode() + bytes((128, 128, 128, 129)) * 32)  # each number 128 / 256 * 2^(129 - 128) = 1
if sys.argv[1] == "Blender":
    import bpy

    found, told = bpy.data.images.load(os.path.abspath("sky.hdr")).pixels[0], None
elif sys.argv[1] == "Mitsuba":
    import mitsuba as mi
    import numpy as np

    mi.set_variant("scalar_rgb")
    found, told = float(np.array(mi.Bitmap("sky.hdr"))[0, 0, 0]), None
else:
    import OpenImageIO as oiio

    sky = oiio.ImageBuf("sky.hdr")
    found, told = sky.getpixel(0, 0)[0], sky.spec().getattribute("hdr:exposure")
print("read by", sys.argv[1], found, "told", told)
raise SystemExit(0 if abs(found - 1) < 1e-6 and told in (None, 3.0) else "this has changed")
END
for reader in Blender Mitsuba OpenImageIO; do
    venv/bin/python read.py $reader 2>&1 | grep "^read by\|changed"
done
