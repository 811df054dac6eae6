#!/usr/bin/env bash
# OpenImageIO's colorconvert spoils all channels but the first four, and keeps the old name of the colour space.
#
# Expected: other channels stay as they are, and a written file names the new space. What happens: in OpenImageIO
# 3.2.2 a fifth channel of 0.25 is 3.0 afterwards (ten times and a half), and `colorInteropID` is the old space's,
# so whoever reads the file takes the numbers for those of the old space.
# Remedy: convert `R,G,B,A` alone, and set `colorInteropID` before writing.
# Source: https://github.com/AcademySoftwareFoundation/OpenImageIO (src/libOpenImageIO/color_ocio.cpp)
# Needs python3 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet OpenImageIO==3.2.2.0
venv/bin/python - <<'END'
import OpenImageIO as oiio

spec = oiio.ImageSpec(4, 4, 5, "float")
spec.channelnames = ("R", "G", "B", "A", "depth.Z")
spec.attribute("colorInteropID", "lin_rec709_scene")
picture = oiio.ImageBuf(spec)
oiio.ImageBufAlgo.fill(picture, (0.5, 0.4, 0.3, 1.0, 0.25))
picture.write("rec709.exr")
made = oiio.ImageBufAlgo.colorconvert(oiio.ImageBuf("rec709.exr"), "lin_rec709_scene", "lin_ap1_scene")
made.write("ap1.exr")
read = oiio.ImageBuf("ap1.exr")
pixel, named = read.getpixel(1, 1), read.spec().get_string_attribute("colorInteropID")
print("OpenImageIO", oiio.VERSION_STRING, "pixel", pixel, "named", named)
raise SystemExit(0 if abs(pixel[4] - 0.25) > 1e-3 and named == "lin_rec709_scene" else 1)
END
