#!/usr/bin/env bash
# Clouds of leaves that are turned in Mitsuba are turned without their leaves: `sggx` keeps its directions in the world.
#
# Expected: `to_world` of a shape, of a grid and of an `instance` turns what is there. The phase function `sggx` has
# flakes, leaves or needles for instance, with directions by a matrix S for each place of a grid. A cube of 2 m of flat
# leaves with all normals along z is dense along z, where exp(-1) = 0.368 of the light comes through, and clear along x,
# 0.99. Turned by 90 degrees about y, with its grids, it is dense along x and clear along z. What happens: Mitsuba 3.9.1
# moves the places of S, and not the directions in it: the turned cube is dense along z still. By an `instance` of a
# `shapegroup` it is the same, so that turned copies of a twig or of a cloth have leaves and fibres of one direction.
# Both integrators agree, with even and uneven density. The documentation does not say in which frame S is.
# Remedy: for a turn R write R S R^T to the grid, so a medium for each turn.
# Versions: Mitsuba 3.9.1, numpy 2.5.5 (PyPI). Source: measured here;
# https://mitsuba.readthedocs.io/en/stable/src/generated/plugins_phase.html (sggx);
# Heitz, Dupuy, Crassin, Dachsbacher 2015, The SGGX microflake distribution (the density of flakes is seen by direction)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet mitsuba==3.9.1 numpy==2.5.5
cat >flakes.py <<'END'
import mitsuba
import numpy as np

mitsuba.set_variant("scalar_rgb")
Transform = mitsuba.ScalarTransform4f
TURN = Transform().rotate([0, 1, 0], 90)


def grid(values, turn):
    """Of the cube from -1 to 1."""
    data = np.tile(np.float32(values), (2, 2, 2, 1))
    place = turn @ Transform().translate([-1, -1, -1]).scale(2)
    return {"type": "gridvolume", "grid": mitsuba.VolumeGrid(data), "filter_type": "nearest", "to_world": place}


def flakes(normal, turn, is_even):
    """Flat flakes with normals along the axis of this number; optical depth 1 across them."""
    matrix = [1e-4, 1e-4, 1e-4, 0, 0, 0]
    matrix[normal] = 1
    return {"type": "homogeneous" if is_even else "heterogeneous", "sigma_t": 0.5 if is_even else grid([0.5], turn),
            "albedo": 0.0, "phase": {"type": "sggx", "S": grid(matrix, turn)}}


def light_through(axis, cloud, integrator):
    """Of a white wall behind the cloud."""
    towards = [0, 0, 0]
    towards[axis] = 1
    up = [0, 1, 0]
    eye, wall = [-6 * part for part in towards], [5 * part for part in towards]
    scene = mitsuba.load_dict({
        "type": "scene", **cloud, "integrator": {"type": integrator, "max_depth": 2},
        "sensor": {"type": "orthographic", "near_clip": 1e-3,
                   "to_world": Transform().look_at(eye, [0, 0, 0], up).scale(0.2),
                   "film": {"type": "hdrfilm", "width": 4, "height": 4, "rfilter": {"type": "box"}},
                   "sampler": {"type": "independent", "sample_count": 2000}},
        "wall": {"type": "rectangle", "to_world": Transform().look_at(wall, [0, 0, 0], up).scale(20),
                 "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 1}}},
    })
    return float(np.array(mitsuba.render(scene))[:, :, 0].mean())


def cube(turn, medium):
    return {"type": "cube", "to_world": turn, "bsdf": {"type": "null"}, "interior": medium}


STILL = Transform()
for is_even in True, False:
    group = {"type": "shapegroup", "cube": cube(STILL, flakes(2, STILL, is_even))}
    clouds = {
        "not turned": {"cube": cube(STILL, flakes(2, STILL, is_even))},
        "turned": {"cube": cube(TURN, flakes(2, TURN, is_even))},
        "turned, with R S R^T": {"cube": cube(TURN, flakes(0, TURN, is_even))},
    }
    if is_even:
        clouds["instance, turned"] = {"group": group, "copy": {"type": "instance", "to_world": TURN,
                                                               "shapegroup": {"type": "ref", "id": "group"}}}
    for name, cloud in clouds.items():
        wanted = (0.368, 0.99) if "R S R^T" in name else (0.99, 0.368)
        for integrator in "volpath", "volpathmis":
            found = [light_through(axis, cloud, integrator) for axis in (0, 2)]
            print("Mitsuba", mitsuba.__version__, integrator, "even" if is_even else "uneven", name + ": light along x",
                  "and z: %.3f %.3f" % tuple(found), flush=True)
            if any(abs(one - other) > 0.015 for one, other in zip(found, wanted)):
                raise SystemExit("this has changed")
END
venv/bin/python flakes.py
