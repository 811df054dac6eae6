#!/usr/bin/env bash
# Even fog in Mitsuba's medium `heterogeneous` is there only from 0 to 1 m, whatever the shape that holds it.
#
# Expected: `sigma_t` of the medium `heterogeneous` may be a number, by its documentation, and has one where nothing is
# said; it is then the same throughout the shape that has the medium inside. So even mist may have a grid of colours as
# its `albedo`. A box of 4 m with a density of 1 lets exp(-4) = 0.018 of the light through. What happens: Mitsuba 3.9.1
# makes a `constvolume` of the number, and the medium looks for fog within the bounds of that volume alone, which are
# the cube from 0 to 1 on each axis. A ray through the rest of the box meets nothing: all light comes through; one
# through that cube meets 1 m of fog, 0.37. So a box within that cube is right. `volpath` and `volpathmis` agree.
# Nothing is said.
# Remedy: `homogeneous`, which is right everywhere, and whose `albedo` may be a grid too; or `sigma_t` as a
# `constvolume` with a `to_world` that takes the cube from 0 to 1 to the bounds of the shape.
# Versions: Mitsuba 3.9.1 with numpy 2.5.5 (PyPI). Source: measured here;
# https://mitsuba.readthedocs.io/en/stable/src/generated/plugins_media.html (heterogeneous: sigma_t);
# https://github.com/mitsuba-renderer/mitsuba3 (src/media/heterogeneous.cpp, intersect_aabb; src/volumes/const.cpp)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet mitsuba==3.9.1 numpy==2.5.5
cat >fog.py <<'END'
import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
TO = mi.ScalarTransform4f
BOX = TO().translate(-2) @ TO().scale(4)  # from the cube that runs from 0 to 1 to the box of 4 m
COLOURS = {"type": "gridvolume", "grid": mi.VolumeGrid(np.zeros((4, 4, 4, 3), np.float32)), "to_world": BOX}


def let_through(x, medium, integrator):
    """Light of the surroundings that comes through the box of 4 m along z, at x and y = x."""
    sensor = {
        "type": "orthographic", "to_world": TO().look_at([x, x, 9], [x, x, 0], [0, 1, 0]) @ TO().scale([0.01, 0.01, 1]),
        "film": {"type": "hdrfilm", "width": 1, "height": 1, "rfilter": {"type": "box"}},
    }
    return float(np.array(mi.render(mi.load_dict({
        "type": "scene", "integrator": {"type": integrator}, "light": {"type": "constant"}, "sensor": sensor,
        "box": {"type": "cube", "to_world": TO().scale(2), "bsdf": {"type": "null"}, "interior": medium},
    }), spp=20000)).ravel()[0])


for name, medium, wanted in [
    ("homogeneous", {"type": "homogeneous", "sigma_t": 1.0, "albedo": 0.0}, (np.exp(-4), np.exp(-4))),
    ("homogeneous, and a grid of colours", {"type": "homogeneous", "sigma_t": 1.0, "albedo": COLOURS},
     (np.exp(-4), np.exp(-4))),
    ("a number", {"type": "heterogeneous", "sigma_t": 1.0, "albedo": 0.0}, (1, np.exp(-1))),
    ("a number, and a grid of colours", {"type": "heterogeneous", "sigma_t": 1.0, "albedo": COLOURS}, (1, np.exp(-1))),
    ("constvolume with to_world", {"type": "heterogeneous", "albedo": COLOURS, "sigma_t": {
        "type": "constvolume", "value": 1.0, "to_world": BOX}}, (np.exp(-4), np.exp(-4))),
]:
    for integrator in ("volpath", "volpathmis"):
        found = [let_through(x, medium, integrator) for x in (-0.5, 0.5)]
        told = name + ": at -0.5 m %.3f comes through, at 0.5 m %.3f" % tuple(found)
        print("Mitsuba", mi.__version__, integrator, told, flush=True)
        if np.abs(np.subtract(found, wanted)).max() > 0.02:
            raise SystemExit("this has changed")
END
venv/bin/python fog.py
