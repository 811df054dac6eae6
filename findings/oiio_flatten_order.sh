#!/usr/bin/env bash
# OpenImageIO flattens deep pixels in the order of the file: what is far may cover what is near. Depths are mixed.
#
# Expected: OpenEXR lets samples of a deep pixel stand in any order, and overlap; to flatten is to sort, to split what
# overlaps, and then to lay near over far. What happens: `flatten` of OpenImageIO 3.2.2 (`oiiotool --flatten` too) lays
# each sample over the next as they stand. A red veil at 1 m and a green one at 5 m are 0.5 0.25 0 or 0.25 0.5 0 by
# their order in the file; fog from 0 to 2 m and from 1 to 3 m as well, where 0.470 0.280 0 is right. `Z` of the flat
# pixel is 3, where nothing is, and takes in what lies behind: 27.25 with another veil at 100 m. Nothing is said.
# Remedy: `deep_merge` of images that are in order on their own sorts and splits; keep depth from elsewhere.
# Versions: OpenImageIO 3.2.2.0 (PyPI). Source: measured here; https://openexr.com/en/latest/InterpretingDeepPixels.html;
# https://github.com/AcademySoftwareFoundation/OpenImageIO (pull request 727, of 2013, has it as not yet right)
# Needs python3 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet OpenImageIO==3.2.2.0
cat >flatten.py <<'END'
import OpenImageIO as oiio

# R, G, B, A, Z, ZBack
NEAR, FAR, FARTHEST = (0.5, 0, 0, 0.5, 1, 1), (0, 0.5, 0, 0.5, 5, 5), (0, 0, 0.5, 0.5, 100, 100)
FRONT, BACK = (0.5, 0, 0, 0.5, 0, 2), (0, 0.5, 0, 0.5, 1, 3)


def deep(*samples):
    """A file of one deep pixel, read again."""
    spec = oiio.ImageSpec(1, 1, 6, "float")
    spec.channelnames = ("R", "G", "B", "A", "Z", "ZBack")
    spec.deep, spec.alpha_channel, spec.z_channel = True, 3, 4
    picture = oiio.ImageBuf(spec)
    picture.set_deep_samples(0, 0, 0, len(samples))
    for number, sample in enumerate(samples):
        for channel, value in enumerate(sample):
            picture.set_deep_value(0, 0, 0, channel, number, float(value))
    picture.write("deep.exr")
    read = oiio.ImageBuf("deep.exr")
    read.read(force=True)
    return read


for name, picture, wanted in [
    ("near, far", deep(NEAR, FAR), (0.5, 0.25, 0, 0.75, 3)),
    ("far, near", deep(FAR, NEAR), (0.25, 0.5, 0, 0.75, 3)),
    ("near, far, farthest", deep(NEAR, FAR, FARTHEST), (0.5, 0.25, 0.125, 0.875, 27.25)),
    ("fog that overlaps", deep(FRONT, BACK), (0.5, 0.25, 0, 0.75, 0.5)),
    ("the other way round", deep(BACK, FRONT), (0.25, 0.5, 0, 0.75, 0.5)),
    ("merged from two", oiio.ImageBufAlgo.deep_merge(deep(BACK), deep(FRONT)), (0.4697, 0.2803, 0, 0.75, 1.1642)),
]:
    found = oiio.ImageBufAlgo.flatten(picture).getpixel(0, 0)
    print("OpenImageIO", oiio.VERSION_STRING, name + ":", *(round(value, 4) for value in found[:5]), flush=True)
    if any(abs(one - other) > 1e-3 for one, other in zip(found, wanted)):
        raise SystemExit("this has changed")
END
venv/bin/python flatten.py
