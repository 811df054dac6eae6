#!/usr/bin/env bash
# Mitsuba's principled material gives back more light than it gets: a white leaf in a white world stands out bright.
#
# Expected: white of any roughness, sheen or flatness gives back at most what falls on it, so that before a world of
# radiance 1 it has 1 at most. What happens: `principled` of Mitsuba 3.9.1 with `base_color` 1 and roughness 0.5 has
# 1.04 from above and 1.16 at 80 degrees from its normal. With `sheen` 1 it has 1.21 there; with `flatness` 1 it has
# 1.45 there, and 0.79 from above. `principledthin` with `diff_trans` keeps to 1.01, `diffuse` to 1.00; `roughplastic` loses an eighth.
# The lobes are added without weights that sum up to one; the documentation does not say so, and nothing is said.
# So a render by it is no truth for another renderer's furnace, nor for white leaves that light one another.
# Remedy: `diffuse` or `roughplastic`, or a material of one's own by `blendbsdf`.
# Versions: mitsuba 3.9.1, numpy 2.5.5 (PyPI). Source: measured here;
# https://mitsuba.readthedocs.io/en/stable/src/generated/plugins_bsdfs.html (principled);
# https://media.disneyanimation.com/uploads/production/publication_asset/48/asset/s2012_pbs_disney_brdf_notes_v3.pdf
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet mitsuba==3.9.1 numpy==2.5.5
cat >furnace.py <<'END'
import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
WHITE = {"type": "rgb", "value": 1.0}
PRINCIPLED = {"type": "principled", "base_color": WHITE, "roughness": 0.5}


def seen(bsdf, angle_deg):
    """Radiance of a white sheet in a white world, seen that far from its normal."""
    angle = np.radians(angle_deg)
    return float(np.array(mi.render(mi.load_dict({
        "type": "scene", "integrator": {"type": "path"}, "world": {"type": "constant", "radiance": WHITE},
        "camera": {"type": "perspective", "fov": 1,
                   "to_world": mi.ScalarTransform4f().look_at([5 * np.sin(angle), 0, 5 * np.cos(angle)], [0, 0, 0],
                                                              [0, 1, 0]),
                   "film": {"type": "hdrfilm", "width": 1, "height": 1, "rfilter": {"type": "box"}},
                   "sampler": {"type": "independent", "sample_count": 40000}},
        "sheet": {"type": "rectangle", "to_world": mi.ScalarTransform4f().scale(2), "bsdf": bsdf}}))).mean())


is_same = True
for name, bsdf, wanted in [
    ("diffuse", {"type": "diffuse", "reflectance": WHITE}, (1.0, 1.0)),
    ("roughplastic", {"type": "roughplastic", "diffuse_reflectance": WHITE, "alpha": 0.3}, (0.874, 0.848)),
    ("principled", PRINCIPLED, (1.043, 1.161)),
    ("principled, sheen 1", {**PRINCIPLED, "sheen": 1.0}, (1.043, 1.214)),
    ("principled, flatness 1", {**PRINCIPLED, "flatness": 1.0}, (0.791, 1.447)),
    ("principledthin, diff_trans 1",
     {"type": "principledthin", "base_color": WHITE, "roughness": 0.5, "diff_trans": 1.0}, (1.001, 1.011)),
]:
    found = tuple(seen(bsdf, angle) for angle in (0, 80))
    print("mitsuba", mi.__version__, name + ": %.3f from above, %.3f at 80 degrees" % found, flush=True)
    is_same &= np.allclose(found, wanted, atol=0.02)
if not is_same:
    raise SystemExit("this has changed")
END
venv/bin/python furnace.py
