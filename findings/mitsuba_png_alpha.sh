#!/usr/bin/env bash
# Mitsuba writes PNG with alpha whose colours have already been multiplied by it: edges of leaves are too dark.
#
# Expected: PNG keeps colour apart from alpha. A pixel that a white leaf covers by half is 255 255 255 there, with an
# alpha of 128; films and OpenEXR have it multiplied, 0.5 0.5 0.5 0.5. What happens: `convert` and `write` of Mitsuba
# 3.9.1 encode the multiplied colour as sRGB, so the file has 188 188 188 and 128. Laid over white, the leaf has a dark
# rim, and motion blur, hair and fog are too dark all over. `premultiplied_alpha()` of the bitmap is true, so that it
# knows; nothing is said. `write_bitmap` drops alpha, and so puts the leaf on black.
# Remedy: `bitmap.convert(RGBA, UInt8, True, mi.Bitmap.AlphaTransform.Unpremultiply)`, whose default is `Empty`; or
# `oiiotool frame.exr -o frame.png`, which divides.
# Versions: Mitsuba 3.9.1 with numpy 2.5.5, Pillow 12.3.0, OpenImageIO 3.2.2.0 (PyPI). Source: measured here;
# https://www.w3.org/TR/png-3/ (6.2, Alpha representation);
# https://github.com/mitsuba-renderer/mitsuba3 (issue 787 advises `convert` for PNG with alpha)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet mitsuba==3.9.1 numpy==2.5.5 pillow==12.3.0 openimageio==3.2.2.0
cat >edge.py <<'END'
import subprocess
import sys

import mitsuba as mi
import numpy as np
from PIL import Image

mi.set_variant("scalar_rgb")
TO = mi.ScalarTransform4f
# One pixel; a card that glows with 1 covers its right half.
film = mi.render(mi.load_dict({
    "type": "scene", "integrator": {"type": "path"},
    "leaf": {"type": "rectangle", "to_world": TO().translate([1, 0, 0]), "emitter": {
        "type": "area", "radiance": {"type": "rgb", "value": 1.0}}},
    "sensor": {"type": "orthographic", "to_world": TO().look_at([0, 0, 3], [0, 0, 0], [0, 1, 0]), "film": {
        "type": "hdrfilm", "width": 1, "height": 1, "pixel_format": "rgba", "rfilter": {"type": "box"}}},
}), spp=65536)
bitmap = mi.Bitmap(film)
bitmap.write("edge.exr")
subprocess.run([sys.argv[1], "edge.exr", "-o", "oiiotool.png"], check=True)
to_bytes = (mi.Bitmap.PixelFormat.RGBA, mi.Struct.Type.UInt8, True)
bitmap.convert(*to_bytes).write("convert.png")
bitmap.convert(*to_bytes, mi.Bitmap.AlphaTransform.Unpremultiply).write("Unpremultiply.png")
mi.util.write_bitmap("write_bitmap.png", film, write_async=False)
print("Mitsuba", mi.__version__, "film", np.array(film).round(2).ravel(), "premultiplied:", bitmap.premultiplied_alpha())
for name, wanted in [("convert", [188, 188, 188, 128]), ("write_bitmap", [188, 188, 188]),
                     ("Unpremultiply", [255, 255, 255, 128]), ("oiiotool", [255, 255, 255, 128])]:
    found = np.array(Image.open(f"{name}.png")).ravel().astype(int)
    print("Mitsuba", mi.__version__, "PNG by", name, found)
    if len(found) != len(wanted) or abs(found - wanted).max() > 2:
        raise SystemExit("this has changed")
raise SystemExit(0 if bitmap.premultiplied_alpha() else "this has changed")
END
venv/bin/python edge.py venv/bin/oiiotool 2>&1 | grep "^Mitsuba\|changed"
