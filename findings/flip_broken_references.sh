#!/usr/bin/env bash
# HDR-FLIP finds no difference at all once its reference has one infinite pixel, and takes dust for errors at night.
#
# Expected: an infinite pixel is one bad pixel of 4096: a black picture beside a grey reference still differs by 0.97,
# the mean that FLIP has without it. A reference that is black by half, as a night or a leaf before black is, finds no
# more in a difference of 1e-7 than one that is black by a little less: next to nothing. What happens: HDR-FLIP 1.7
# chooses its exposures by the greatest and the median luminance of the reference. With infinity the first exposure is
# minus infinity, so that all is black by it: the error is 0 for a black picture, for one of twice the light, for all.
# With a median of 0 the last exposure is 24 stops up: 1e-7 more light on each pixel is an error of 0.52, and of less
# than 0.001 where half of the pixels less one row is black. Nothing is said; the numbers are in range. A NaN in the
# reference does neither.
# Remedy: refuse references that are not finite (`numpy.isfinite`), look at `startExposure` and `stopExposure` of what
# comes back, and give both to `evaluate` for frames that are mostly black.
# Versions: flip-evaluator 1.7 with numpy 2.5.5 (PyPI). Source: measured here; https://github.com/NVlabs/flip
# (src/cpp/FLIP.h, computeExposures); "Visualizing Errors in Rendered High Dynamic Range Images" (Andersson and others,
# 2021), whose section on exposures takes both from the reference
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet flip-evaluator==1.7 numpy==2.5.5
cat >flip.py <<'END'
import importlib.metadata

import flip_evaluator
import numpy as np

GREY = np.random.default_rng(0).uniform(0.1, 1, (64, 64, 3)).astype(np.float32)


def with_pixel(value):
    picture = GREY.copy()
    picture[5, 7] = value
    return picture


def black_rows(rows):
    picture = GREY.copy()
    picture[:rows] = 0
    return picture


HALF, LESS = black_rows(33), black_rows(31)
RANGE = {"startExposure": 1.0, "stopExposure": 4.0, "numExposures": 3}
for name, reference, picture, parameters, wanted in [
    ("a black picture", GREY, 0 * GREY, {}, 0.97),
    ("twice the light", GREY, 2 * GREY, {}, 0.29),
    ("a black picture, one pixel of the reference NaN", with_pixel(np.nan), 0 * GREY, {}, 0.97),
    ("a black picture, one pixel of the reference infinite", with_pixel(np.inf), 0 * GREY, {}, 0),
    ("twice the light, one pixel of the reference infinite", with_pixel(np.inf), 2 * GREY, {}, 0),
    ("1e-7 more light, 31 rows of 64 black", LESS, LESS + np.float32(1e-7), {}, 0),
    ("1e-7 more light, 33 rows of 64 black", HALF, HALF + np.float32(1e-7), {}, 0.52),
    ("the same, with exposures that are given", HALF, HALF + np.float32(1e-7), RANGE, 0),
]:
    _, error, used = flip_evaluator.evaluate(reference, picture, "HDR", parameters=parameters)
    print("flip-evaluator", importlib.metadata.version("flip-evaluator"), name + ": error %.4f," % error,
          "exposures %.1f to %.1f" % (used["startExposure"], used["stopExposure"]), flush=True)
    if not abs(error - wanted) < 0.01:
        raise SystemExit("this has changed")
END
venv/bin/python flip.py
