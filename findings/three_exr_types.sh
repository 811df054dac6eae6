#!/usr/bin/env bash
# With one channel of whole numbers three.js mixes up the rows of an OpenEXR file; alpha of its own type is rubbish.
#
# Expected: in OpenEXR each channel has its type, half, float or uint; ids beside colours of half floats are uint, and
# an alpha may be float. Red, green, blue and alpha are what OpenEXR's own reader has. What happens: `EXRLoader` of
# three.js 0.187 gives a uint no bytes at all as it counts those of a row. So with one channel of ids the rows of each
# block of ZIP but the first, sixteen at a time, are read from too early: red of row 10 is blue, and green is alpha. Of
# red, green, blue and alpha all are decoded as one type: alpha of 1 in float beside colours in half is 0, 1.88 and
# more, and 0.01 the other way round, so that skies and cards are clear or glow. Depth in float beside colours and alpha
# in half is right. Nothing is said.
# Remedy: all of red, green, blue and alpha as one type, and ids in a file of their own.
# Versions: three 0.187.0 (npm), OpenEXR 3.5.3, numpy 2.5.5 (PyPI). Source: measured here;
# https://openexr.com/en/latest/OpenEXRFileLayout.html (pixel types by channel);
# https://github.com/mrdoob/three.js (examples/jsm/loaders/EXRLoader.js)
# Needs node, npm, python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet OpenEXR==3.5.3 numpy==2.5.5
npm init -y >/dev/null
npm install --silent three@0.187.0
cat >write.py <<'END'
import numpy as np
import OpenEXR

HALF, FLOAT, UINT = np.float16, np.float32, np.uint32
ROW, COLUMN = np.mgrid[0:40, 0:48].astype(FLOAT)
ONE = np.ones_like(ROW)
for name, colour, others in [
    ("plain", HALF, {"A": (ONE, HALF)}),
    ("depth", HALF, {"A": (ONE, HALF), "Z": (ROW, FLOAT)}),
    ("ids", HALF, {"A": (ONE, HALF), "id": (COLUMN, UINT)}),
    ("alpha_float", HALF, {"A": (ONE, FLOAT)}),
    ("alpha_half", FLOAT, {"A": (ONE, HALF)}),
]:
    channels = {"R": (COLUMN + 1, colour), "G": (ROW + 1, colour), "B": (ONE / 4, colour), **others}
    for compression in (OpenEXR.NO_COMPRESSION, OpenEXR.ZIP_COMPRESSION):
        path = f"{name}.{str(compression).split('.')[-1].split('_')[0]}.exr"
        OpenEXR.File({"compression": compression, "type": OpenEXR.scanlineimage}, {
            channel: np.ascontiguousarray(values.astype(kind)) for channel, (values, kind) in channels.items()}).write(path)
        read = OpenEXR.File(path, separate_channels=True).channels()
        found = [float(read[channel].pixels[10, 3]) for channel in "RGBA"]
        print("OpenEXR", OpenEXR.__version__, path, "column 3, row 10:", *found)
        if found != [4, 11, 0.25, 1]:
            raise SystemExit("this has changed")
END
venv/bin/python write.py
cat >read.mjs <<'END'
import { readFileSync } from "node:fs";
import { FloatType } from "three";
import { EXRLoader } from "three/addons/loaders/EXRLoader.js";

for (const [name, zipped, plain] of [
  ["plain", [4, 11, 0.25, 1]], ["depth", [4, 11, 0.25, 1]], ["ids", [0.25, 1, 0, 0], [4, 11, 0.25, 1]],
  ["alpha_float", [4, 11, 0.25, 1.88]], ["alpha_half", [4, 11, 0.25, 0.01]],
]) {
  for (const compression of ["NO", "ZIP"]) {
    const { buffer, byteOffset, length } = readFileSync(`${name}.${compression}.exr`);
    const picture = new EXRLoader().setDataType(FloatType).parse(buffer.slice(byteOffset, byteOffset + length));
    const wanted = compression === "NO" ? plain ?? zipped : zipped;
    const at = 4 * ((picture.height - 1 - 10) * picture.width + 3);
    const found = [...picture.data.slice(at, at + 4)].map((value) => Number(value.toFixed(2)));
    console.log("three.js 0.187.0", `${name}.${compression}.exr`, "column 3, row 10:", ...found);
    if (found.some((value, channel) => Math.abs(value - wanted[channel]) > 0.01)) { console.log("this has changed"); process.exit(1); }
  }
}
END
timeout 30 node read.mjs
