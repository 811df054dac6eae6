#!/usr/bin/env bash
# Fog of a grid is not in its instances in Mitsuba: each is an empty box, with what the group has at its own place.
#
# Expected: an `instance` of a `shapegroup` is all of the group at another place, fog within a box too. Four metres away
# from its group, turned or of twice the size, a cube of 2 m with a density of 1 lets exp(-2) = 0.135 of the light of a
# wall through, exp(-4) at twice the size. What happens: Mitsuba 3.9.1 moves the surfaces of the group and leaves
# `gridvolume` where its `to_world` has it in the world. An instance that is elsewhere lets all light through; one that
# overlaps the group's place has the fog of there, 0.37 half a box away, and one of twice the size is no thicker than the
# group. The same cube with `homogeneous` fog is right in all of these, so that a test with even fog shows nothing.
# Nothing is said.
# Remedy: a shape and a medium of its own for each bank, with the same `to_world` in the shape and in its `gridvolume`.
# Versions: Mitsuba 3.9.1 with numpy 2.5.5 (PyPI). Source: measured here;
# https://mitsuba.readthedocs.io/en/stable/src/generated/plugins_shapes.html (instance, shapegroup);
# https://mitsuba.readthedocs.io/en/stable/src/generated/plugins_volumes.html (gridvolume)
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
WALL = {
    "type": "rectangle", "to_world": TO().translate([0, 0, -9]) @ TO().scale(99), "bsdf": {"type": "diffuse"},
    "emitter": {"type": "area", "radiance": 1.0},
}
MEDIA = {
    "even": {"type": "homogeneous", "albedo": 0.0, "sigma_t": 1.0},
    "grid": {"type": "heterogeneous", "albedo": 0.0, "sigma_t": {
        "type": "gridvolume", "grid": mi.VolumeGrid(np.ones((4, 4, 4, 1), np.float32)),
        "to_world": TO().translate(-1) @ TO().scale(2)}},
}


def let_through(x, medium, place):
    """Light of the wall that comes through at x, with the cube itself, or as an instance at a place."""
    cube = {"type": "cube", "bsdf": {"type": "null"}, "interior": medium}
    fog = {"cube": cube} if place is None else {
        "group": {"type": "shapegroup", "cube": cube},
        "fog": {"type": "instance", "to_world": place, "group": {"type": "ref", "id": "group"}},
    }
    sensor = {
        "type": "orthographic", "to_world": TO().look_at([x, 0.1, 5], [x, 0.1, 0], [0, 1, 0]) @ TO().scale([0.01, 0.01, 1]),
        "film": {"type": "hdrfilm", "width": 1, "height": 1, "rfilter": {"type": "box"}},
    }
    scene = {"type": "scene", "integrator": {"type": "volpath"}, "wall": WALL, **fog}
    return float(np.array(mi.render(mi.load_dict({**scene, "sensor": sensor}), spp=20000)).ravel()[0])


for name, x, place, right, wanted in [
    ("the cube itself", 0.1, None, np.exp(-2), np.exp(-2)),
    ("an instance at its place", 0.1, TO(), np.exp(-2), np.exp(-2)),
    ("4 m to the right", 4.1, TO().translate([4, 0, 0]), np.exp(-2), 1.0),
    ("1 m towards the camera", 0.1, TO().translate([0, 0, 1]), np.exp(-2), np.exp(-1)),
    ("of twice the size", 0.1, TO().scale(2), np.exp(-4), np.exp(-2)),
]:
    even, grid = (let_through(x, MEDIA[kind], place) for kind in ("even", "grid"))
    print("Mitsuba", mi.__version__, name + ": even fog lets %.3f through, fog of a grid %.3f" % (even, grid), flush=True)
    if abs(even - right) > 0.02 or abs(grid - wanted) > 0.02:
        raise SystemExit("this has changed")
END
venv/bin/python fog.py
