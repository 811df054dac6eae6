#!/usr/bin/env bash
# One OpenEXR file in ACEScg has three colours: Blender passes over its chromaticities, Mitsuba over their white.
#
# Expected: RGB of an OpenEXR file is in the primaries and of the white that its attribute `chromaticities` names. A
# grey stays grey: readers adapt the white, as ACES and OpenColorIO do. What happens: Blender 5.3.0 shows the numbers as
# they stand, as linear Rec. 709. Mitsuba 3.9.1 converts the primaries, also where one asks for `raw`, and lets the
# white of D60 be: grey of 0.5 turns to 0.524 0.497 0.458, so that all that a sky lights is yellow. Neither says so.
# Remedy: convert to linear Rec. 709, and leave the attribute out; for Blender `colorInteropID` = `lin_ap1_scene` is
# enough, and is right to the last digit.
# Versions: bpy 5.3.0, Mitsuba 3.9.1, OpenEXR 3.5.3, numpy 2.5.5; bpy 5.0.1 is as 5.3.0 (PyPI). Source: measured here;
# https://openexr.com/en/latest/StandardAttributes.html
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 mitsuba==3.9.1 OpenEXR==3.5.3 numpy==2.5.5
cat >write.py <<'END'
import numpy as np
import OpenEXR

AP1 = {"chromaticities": (0.713, 0.293, 0.165, 0.83, 0.128, 0.044, 0.32168, 0.33767)}
for name, attributes in [("none", {}), ("ap1", AP1), ("ap1_id", AP1 | {"colorInteropID": "lin_ap1_scene"})]:
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage} | attributes
    pixels = np.full((4, 8, 3), (0.4, 0.5, 0.2), np.float32)  # olive, and grey on the right
    pixels[:, 4:] = 0.5
    OpenEXR.File(header, {"RGB": pixels}).write(name + ".exr")
END
cat >in_mitsuba.py <<'END'
import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
AS_IT_STANDS, NOT_ADAPTED = [0.4, 0.5, 0.2, 0.5, 0.5, 0.5], [0.374, 0.513, 0.140, 0.524, 0.497, 0.458]
for name, wanted in (("none", AS_IT_STANDS), ("ap1", NOT_ADAPTED), ("ap1_id", NOT_ADAPTED)):
    for raw in (False, True):
        texture = mi.load_dict({"type": "bitmap", "filename": name + ".exr", "raw": raw})
        at, found = mi.SurfaceInteraction3f(), []
        for u in (0.25, 0.75):
            at.uv = [u, 0.5]
            found += list(texture.eval_3(at) if raw else texture.eval(at))
        print("Mitsuba", mi.__version__, name, "raw" if raw else "   ", np.round(found, 3), flush=True)
        if not np.allclose(found, wanted, atol=0.001):
            raise SystemExit("this has changed")
END
cat >in_blender.py <<'END'
import os

import bpy
import numpy as np

AS_IT_STANDS, ADAPTED = [0.4, 0.5, 0.2, 0.5, 0.5, 0.5], [0.354, 0.516, 0.157, 0.5, 0.5, 0.5]
for name, wanted in (("none", AS_IT_STANDS), ("ap1", AS_IT_STANDS), ("ap1_id", ADAPTED)):
    image = bpy.data.images.load(os.path.abspath(name + ".exr"))
    found = np.array(image.pixels[:]).reshape(4, 8, 4)[0, [0, 7], :3].ravel()
    print("bpy", bpy.app.version_string, name, found.round(3), image.colorspace_settings.name, flush=True)
    if not np.allclose(found, wanted, atol=0.001):
        raise SystemExit("this has changed")
END
venv/bin/python write.py
venv/bin/python in_mitsuba.py 2>&1 | grep "^Mitsuba\|changed"
venv/bin/python in_blender.py 2>&1 | grep "^bpy\|changed"
