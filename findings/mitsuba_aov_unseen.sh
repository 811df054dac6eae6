#!/usr/bin/env bash
# Mitsuba's passes show what cannot be seen: the box about fog, and the whole card from which a leaf is cut.
#
# Expected: depth, normal, position and albedo of the `aov` integrator are those of what one sees: through a box of thin
# fog with a `null` surface, and where a `mask` is open, the wall behind, 7 m away. What happens: Mitsuba 3.9.1 takes the
# first surface on the ray, whatever its BSDF lets through: the front of the box, with an albedo of 0, at 3.5 m, and the
# card, with the leaf's albedo, at 4 m. The picture beside is right. So depth of field and fog added later are wrong; a
# denoiser is told that there is a black wall in front of all fog, and has no edges of leaves to go by. Nothing is said.
# Remedy: passes from a second scene without the box of fog, in which leaves are meshes instead of masks.
# Versions: Mitsuba 3.9.1 with numpy 2.5.5 (PyPI). Source: measured here;
# https://github.com/mitsuba-renderer/mitsuba3 (src/integrators/aov.cpp, src/bsdfs/null.cpp, src/bsdfs/mask.cpp)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet mitsuba==3.9.1 numpy==2.5.5
cat >passes.py <<'END'
import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
TO = mi.ScalarTransform4f
BOX = {"type": "cube", "to_world": TO().scale([5, 5, 0.5]), "bsdf": {"type": "null"},
       "interior": {"type": "homogeneous", "sigma_t": 0.01, "albedo": 0.0}}
CARD = {"type": "rectangle", "to_world": TO().scale(5), "bsdf": {"type": "mask", "opacity": 0.0, "nested": {
    "type": "diffuse", "reflectance": {"type": "rgb", "value": 0.9}}}}


def passes(shape):
    """Radiance, depth and albedo of a wall at z = -3 under a white sky, seen from z = 4 past a shape about z = 0."""
    scene = {
        "type": "scene", "sky": {"type": "constant"},
        "integrator": {"type": "aov", "aovs": "depth:depth,albedo:albedo", "image": {"type": "volpath", "max_depth": 8}},
        "wall": {"type": "rectangle", "to_world": TO().translate([0, 0, -3]).scale(1000), "bsdf": {
            "type": "diffuse", "reflectance": {"type": "rgb", "value": 0.5}}},
        "sensor": {"type": "perspective", "fov": 1, "to_world": TO().look_at([0, 0, 4], [0, 0, 0], [0, 1, 0]), "film": {
            "type": "hdrfilm", "width": 8, "height": 8, "pixel_format": "rgb", "rfilter": {"type": "box"}}},
    }
    if shape:
        scene["shape"] = shape
    red, _, _, depth, albedo, _, _ = np.array(mi.render(mi.load_dict(scene), spp=256)).mean(axis=(0, 1))
    return red, depth, albedo


for name, shape, wanted in [("the wall alone", None, (0.5, 7, 0.5)), ("with clear fog before it", BOX, (0.49, 3.5, 0)),
                            ("with an open mask before it", CARD, (0.5, 4, 0.9))]:
    found = passes(shape)
    print("Mitsuba", mi.__version__, name, "radiance %.2f depth %.2f m albedo %.2f" % found, flush=True)
    if max(abs(a - b) for a, b in zip(found, wanted)) > 0.02:
        raise SystemExit("this has changed")
END
venv/bin/python passes.py 2>&1 | grep "^Mitsuba\|changed"
