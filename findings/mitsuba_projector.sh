#!/usr/bin/env bash
# Mitsuba's projector is pi times as bright as its parameter `irradiance` says.
#
# Expected: `irradiance` of `projector` is that on the plane 1 m before it, by the documentation, and even there. A
# white wall in that plane sends back irradiance / pi, as with any other light: 0.318 W/(m2 sr) for 1 W/m2, and a
# quarter of that at 2 m. What happens: with Mitsuba 3.9.1 the wall is at 1, and at 0.25 at 2 m: pi times as bright,
# whatever the field of view, with a picture as with a number. It is even, and `path` and the particle tracer agree, so
# that no test of the renderer against itself shows it. `directional` with an `irradiance` of 1 gives the same wall
# 0.318, `point` with an intensity of 1 at 1 m as well. A slide through leaves that is to be as bright as the sun
# beside it is three times as bright. Nothing is said.
# Remedy: `scale` of the projector at 1 / pi = 0.3183, or pictures divided by pi.
# Versions: Mitsuba 3.9.1 with numpy 2.5.5 (PyPI). Source: measured here;
# https://mitsuba.readthedocs.io/en/stable/src/generated/plugins_emitters.html (projector: irradiance);
# https://github.com/mitsuba-renderer/mitsuba3 (src/emitters/projector.cpp, sample_direction)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet mitsuba==3.9.1 numpy==2.5.5
cat >wall.py <<'END'
import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
TO = mi.ScalarTransform4f


def wall(light, integrator="path", across=0.01, samples=64):
    """Radiance of a white wall at z = 0, about its middle."""
    sensor = {
        "type": "perspective", "to_world": TO().look_at([0, 0, 5], [0, 0, 0], [0, 1, 0]),
        "fov": np.degrees(2 * np.arctan(across / 5)),
        "film": {"type": "hdrfilm", "width": 1, "height": 1, "rfilter": {"type": "box"}},
    }
    return float(np.array(mi.render(mi.load_dict({
        "type": "scene", "integrator": {"type": integrator}, "light": light, "sensor": sensor,
        "wall": {"type": "rectangle", "to_world": TO().scale(9), "bsdf": {"type": "diffuse", "reflectance": {
            "type": "rgb", "value": 1.0}}},
    }), spp=samples)).ravel()[0])


def projector(distance, fov=40.0, picture=False, **more):
    even = {"type": "bitmap", "bitmap": mi.Bitmap(np.ones((4, 4, 3), np.float32)), "raw": True}
    return {
        "type": "projector", "irradiance": even if picture else {"type": "rgb", "value": 1.0}, "fov": fov,
        "to_world": TO().look_at([0, 0, distance], [0, 0, 0], [0, 1, 0]), **more,
    }


ONE = {"type": "rgb", "value": 1.0}
for name, found, wanted in [
    ("directional, irradiance 1", wall({"type": "directional", "direction": [0, 0, -1], "irradiance": ONE}), 1 / np.pi),
    ("point, intensity 1, at 1 m", wall({"type": "point", "position": [0, 0, 1], "intensity": ONE}), 1 / np.pi),
    ("projector, irradiance 1, at 1 m", wall(projector(1)), 1),
    ("with a scale of 1 / pi", wall(projector(1, scale=1 / np.pi)), 1 / np.pi),
    ("at 2 m", wall(projector(2)), 1 / 4),
    ("at 1 m, 10 degrees wide", wall(projector(1, 10.0)), 1),
    ("at 1 m, a picture", wall(projector(1, picture=True)), 1),
    ("at 1 m, over 0.6 m of the wall", wall(projector(1), across=0.3, samples=4096), 1),
    ("the same, by particles", wall(projector(1), "ptracer", 0.3, 100000), 1),
]:
    print("Mitsuba", mi.__version__, name + ": the wall has %.4f W/(m2 sr)" % found, flush=True)
    if abs(found / wanted - 1) > 0.02:
        raise SystemExit("this has changed")
END
venv/bin/python wall.py | grep "^Mitsuba\|changed"
