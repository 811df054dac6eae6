#!/usr/bin/env bash
# OpenEXR's own Python writes a part of an array as other bytes of that array, and writes into headers it is given.
#
# Expected: `File(header, {"RGB": pixels[8:26, 10:42]})` holds those pixels, or is refused; `header` stays as it
# is. What happens: OpenEXR 3.5.3 reads on from the part's first byte, past the ends of its rows. It puts
# `dataWindow` and more into `header`, so a second file of another size from the same header is refused.
# Remedy: numpy.ascontiguousarray(part), and a new header for each file.
# Source: https://github.com/AcademySoftwareFoundation/openexr (src/wrappers/python/PyOpenEXR.cpp)
# Needs python3 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv venv
venv/bin/pip install --quiet OpenEXR==3.5.3 numpy==2.2.6
venv/bin/python - <<'END'
import numpy as np
import OpenEXR

pixels = np.arange(40 * 60 * 3, dtype=np.float32).reshape(40, 60, 3)
part = pixels[8:26, 10:42]


def is_kept(array):
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {"RGB": array}).write("part.exr")
    found = OpenEXR.File("part.exr").channels()["RGB"].pixels
    return np.array_equal(found, array), "dataWindow" in header


whole, copy, slice_ = is_kept(pixels), is_kept(part.copy()), is_kept(part)
print("OpenEXR", OpenEXR.__version__, "kept, header written to: whole", whole, "copy", copy, "part", slice_)
raise SystemExit(0 if (whole, copy, slice_) == ((True, True), (True, True), (False, True)) else 1)
END
