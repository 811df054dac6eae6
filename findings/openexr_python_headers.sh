#!/usr/bin/env bash
# OpenEXR's own Python writes numbers of headers in single precision.
#
# Expected: a Python float in a header comes back as it was, as OpenEXR has an attribute `double`. What
# happens: OpenEXR 3.5.3 writes the attribute `float`: 123456789.123 comes back as 123456792.0, 0.1 as
# 0.10000000149011612.
# Remedy: keep long numbers of headers as text.
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

header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage, "long": 123456789.123}
OpenEXR.File(header, {"Y": np.zeros((2, 2), np.float32)}).write("number.exr")
found = OpenEXR.File("number.exr").header()["long"]
print("OpenEXR", OpenEXR.__version__, "wrote 123456789.123, read", found)
raise SystemExit(0 if found == 123456792.0 else 1)
END
