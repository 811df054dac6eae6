#!/usr/bin/env bash
# With Mitsuba's `path` a leaf that a mask cuts out of a card throws the shadow of the whole card in the sun.
#
# Expected: `mask` lets light through where it is open: what lies behind has the light of a sun as if nothing were
# there. What happens: Mitsuba 3.9.1 takes any surface between a point and an emitter for opaque, whatever its mask
# says. Light of a sky is found as well where a ray meets it by chance; of `directional`, `point` and `spot`, which no
# ray can meet, all is lost, and `direct` loses the same. `max_depth` counts the mask as a bounce: by 2 a sky has 0.45
# of its light. `volpath` is right in all these cases, in scenes without any medium too.
# Remedy: `volpath` wherever there is a mask, or a sun with a width.
# Versions: Mitsuba 3.9.1 with numpy 2.5.5 (PyPI). Source: measured here; https://github.com/mitsuba-renderer/mitsuba3
# (src/integrators/path.cpp; pull request 1961 is about such surfaces)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet mitsuba==3.9.1 numpy==2.5.5
cat >mask.py <<'END'
import math

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
TO = mi.ScalarTransform4f
SUN = {"type": "directional", "direction": [0, 0, -1], "irradiance": math.pi}
SKY = {"type": "constant", "radiance": 1.0}


def floor(integrator, depth, emitter):
    """Radiance of a white floor beneath a card whose mask is open all over."""
    camera = TO().look_at([0, 0, 0.5], [0, 0, 0], [0, 1, 0]) @ TO().scale([0.05, 0.05, 1])
    return np.array(mi.render(mi.load_dict({
        "type": "scene", "integrator": {"type": integrator, "max_depth": depth}, "emitter": emitter,
        "floor": {"type": "rectangle", "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 1.0}}},
        "card": {"type": "rectangle", "to_world": TO().translate([0, 0, 1]),
                 "bsdf": {"type": "mask", "opacity": 0.0, "nested": {"type": "diffuse"}}},
        "sensor": {"type": "orthographic", "to_world": camera, "film": {
            "type": "hdrfilm", "width": 16, "height": 16, "rfilter": {"type": "box"}}},
    }), spp=256)).mean()


for integrator, depth, name, emitter, wanted in [
    ("volpath", 2, "sun", SUN, 1.0), ("volpath", 2, "sky", SKY, 1.0), ("path", -1, "sun", SUN, 0.0),
    ("path", -1, "sky", SKY, 1.0), ("path", 2, "sky", SKY, 0.44),
]:
    found = floor(integrator, depth, emitter)
    print("Mitsuba", mi.__version__, integrator, "max_depth", depth, name, "%.2f" % found, flush=True)
    if abs(found - wanted) > 0.02:
        raise SystemExit("this has changed")
END
venv/bin/python mask.py 2>&1 | grep "^Mitsuba\|changed"
