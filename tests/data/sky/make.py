#!/usr/bin/env python3
"""Reference values for tests/library/sky.rs: skies in Mitsuba's volpath with two segments.

Run as `python tests/data/sky/make.py tests/data/sky/mitsuba.json`, with `pip install '.[mitsuba]'`.
Each scene is a ground and a square above it, with a box of fog or without; each pixel is the mean over its
area, with the standard error of that mean. The test has the same scenes.
"""

import json
import sys

import mitsuba as mi
import numpy

from sunfleck_tools.peers.mitsuba import pinhole

PASSES, SAMPLES = 16, 4096
"""A picture a seed; their spread is the standard error."""
SIZE = (6, 4)


def image(rows, columns):
    """Radiance of the sky of `image`: a slope, and a soft sun. Mitsuba's rows lie at the poles
    and evenly between."""
    down = numpy.pi * numpy.arange(rows)[:, None] / (rows - 1)
    across = 2 * numpy.pi * ((numpy.arange(columns)[None, :] + 0.5) / columns - 0.5)
    x, y, z = (
        numpy.sin(down) * numpy.sin(across),
        numpy.cos(down) + 0 * across,
        -numpy.sin(down) * numpy.cos(across),
    )
    sun = numpy.exp(80.0 * (0.48 * x + 0.6 * y - 0.64 * z - 1.0))
    sky = [0.5 + 0.2 * x + 20.0 * sun, 0.6 + 0.2 * y + 16.0 * sun, 0.9 + 0.3 * z + 12.0 * sun]
    return numpy.stack(sky, -1).astype(numpy.float32)


def emitter(kind):
    if kind == "constant":
        return {"type": "constant", "radiance": {"type": "rgb", "value": [0.8, 1.0, 1.4]}}
    # Mitsuba's images have +Z in their middle, ours -Z.
    turn = mi.ScalarTransform4f().rotate([0, 1, 0], 180)
    return {"type": "envmap", "bitmap": mi.Bitmap(image(256, 512)), "to_world": turn}


def square(middle, turn_x_deg, half, material):
    to_world = mi.ScalarTransform4f().translate(middle).rotate([1, 0, 0], turn_x_deg).scale([half, half, 1])
    return {"type": "rectangle", "to_world": to_world, "bsdf": material}


def matte(reflectance):
    return {
        "type": "twosided",
        "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": reflectance}},
    }


def scene(kind, with_fog):
    fog = {
        "type": "homogeneous",
        "sigma_t": {"type": "rgb", "value": [0.1, 0.12, 0.15]},
        "albedo": {"type": "rgb", "value": [0.9, 0.8, 0.7]},
        "phase": {"type": "hg", "g": 0.5},
    }
    to_world = mi.ScalarTransform4f().look_at(origin=[0, 1.2, 4], target=[0, 1.2, 0], up=[0, 1, 0])
    sensor = pinhole(to_world, 60.0, SIZE)
    described = {
        "type": "scene",
        "integrator": {"type": "volpath", "max_depth": 2, "rr_depth": 100},
        "sky": emitter(kind),
        "ground": square([0, 0, 0], -90, 20, matte([0.5, 0.4, 0.3])),
        "roof": square([0.7, 2.0, 0.0], -60, 1.0, matte([0.2, 0.6, 0.3])),
        "sensor": sensor,
    }
    if with_fog:
        sensor["medium"] = fog
        box = mi.ScalarTransform4f().translate([0, 2, 0]).scale([6, 2.5, 6])
        described["fog"] = {"type": "cube", "to_world": box, "bsdf": {"type": "null"}, "interior": fog}
    return mi.load_dict(described)


def main(path):
    mi.set_variant("scalar_rgb")
    found = {"mitsuba": mi.__version__, "size": SIZE, "samples": PASSES * SAMPLES, "scenes": {}}
    for kind in ("constant", "image"):
        for with_fog in (False, True):
            built = scene(kind, with_fog)
            passes = [numpy.array(mi.render(built, spp=SAMPLES, seed=seed)) for seed in range(PASSES)]
            mean, error = numpy.mean(passes, 0), numpy.std(passes, 0, ddof=1) / PASSES**0.5
            name = kind + ("_fog" if with_fog else "")
            found["scenes"][name] = {
                "mean": [[float(f"{v:.6g}") for v in pixel] for pixel in mean.reshape(-1, 3)],
                "standard_error": [[float(f"{v:.2g}") for v in pixel] for pixel in error.reshape(-1, 3)],
            }
            print(name, mean.mean((0, 1)), error.max(), flush=True)
    with open(path, "w", encoding="utf-8") as file:
        json.dump(found, file, indent=None, separators=(",", ":"))
        file.write("\n")


if __name__ == "__main__":
    main(sys.argv[1])
