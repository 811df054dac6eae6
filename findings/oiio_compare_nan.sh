#!/usr/bin/env bash
# OpenImageIO's idiff passes a frame that is all NaN: no threshold finds a difference.
#
# Expected: NaN is as different as can be from any number. That is how `compare` was meant to be since 2015, when a test
# of OpenImageIO itself had passed broken images. What happens: `idiff` of OpenImageIO 3.2.2 says PASS and ends with 0
# for a grey picture beside one whose every pixel is NaN, `oiiotool --diff` says PASS as well, and `compare` of Python
# has no error and no failed pixel. Infinity is found. Beside a NaN other faults are counted, but the greatest error is
# told as 0, at a pixel that is right. So a nightly comparison with good frames is green where a render went bad.
# Remedy: ask first: `oiiotool frame.exr --fixnan error -o copy.exr`, or `nancount` of `computePixelStats` is 0; or
# look whether `meanerror` is a number.
# Versions: OpenImageIO 3.2.2.0 (PyPI). Source: measured here;
# https://github.com/AcademySoftwareFoundation/OpenImageIO (pull requests 1109 and 1110)
# Needs python3 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet OpenImageIO==3.2.2.0
cat >nan.py <<'END'
import subprocess

import OpenImageIO as oiio

NAN = float("nan")
good = oiio.ImageBuf(oiio.ImageSpec(16, 16, 3, "float"))
oiio.ImageBufAlgo.fill(good, (0.5, 0.5, 0.5))
good.write("good.exr")
for name, spots, is_found in [
    ("all NaN", {(x, y): NAN for x in range(16) for y in range(16)}, False),
    ("one NaN", {(3, 3): NAN}, False),
    ("infinite", {(3, 3): float("inf")}, True),
    ("wrong", {(3, 3): 0.9}, True),
]:
    frame = good.copy()
    for at, value in spots.items():
        frame.setpixel(*at, (value, value, value))
    frame.write("frame.exr")
    result = oiio.ImageBufAlgo.compare(good, frame, 1e-3, 1e-3)
    idiff = subprocess.run(["venv/bin/idiff", "good.exr", "frame.exr"], capture_output=True, text=True)
    tool = subprocess.run(["venv/bin/oiiotool", "good.exr", "frame.exr", "--diff"], capture_output=True, text=True)
    fixnan = ["venv/bin/oiiotool", "frame.exr", "--fixnan", "error", "-o", "copy.exr"]
    fixed = subprocess.run(fixnan, capture_output=True)
    verdicts = [idiff.stdout.split()[-1], tool.stdout.split()[-1]]
    print("OpenImageIO", oiio.VERSION_STRING, name, *verdicts, "rc", idiff.returncode, "failed", result.nfail,
          "error", result.error, "mean %.4f" % result.meanerror, "--fixnan rc", fixed.returncode, flush=True)
    if verdicts != [["PASS", "FAILURE"][is_found]] * 2 or result.error != is_found or result.nfail != is_found:
        raise SystemExit("this has changed")
    if (idiff.returncode != 0) != is_found or (fixed.returncode != 0) != (name != "wrong"):
        raise SystemExit("this has changed")
END
venv/bin/python nan.py 2>&1 | grep "^OpenImageIO\|changed"
