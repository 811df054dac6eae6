#!/usr/bin/env bash
# Fog of LuxCore loses all scattered light at an asymmetry of 0.95, and half of the light of a sun beside it at 0.8.
#
# Expected: *Asymmetry* of a volume goes from -1 to 1, and is the mean cosine g of the phase function, as it is for
# Henyey and Greenstein's, which Cycles and Mitsuba have by this number. Fog that absorbs nothing, below a white sky, is
# white whatever the asymmetry. What happens: LuxCore 2.11.2 takes Schlick's approximation of that function, by way of
# k = 1.55 g - 0.55 g^3. That k is above 1 for each g from 0.939 to 1, so the function is negative, and all that is
# scattered is dropped: through 1 m of fog of 1 / m the sky has exp(-1) = 0.368, and a sun gives no shafts. -0.95 does
# the same. Below that the approximation is good to g = 0.5. At 0.8 a sun from the side has 0.082 of what isotropic fog
# has, where Henyey and Greenstein have 0.171, and the mean cosine is 0.87; 10 degrees off the sun it has 17 % more. So
# shafts beside a plate from Cycles are at half their light. Nothing is said.
# Remedy: an asymmetry of at most 0.93; to match another renderer's shafts, the g that fits at the angle of the shot.
# Versions: pyluxcore 2.11.2, numpy 2.5.5 (PyPI). Source: measured here;
# https://wiki.luxcorerender.org/LuxCoreRender_Volumes (Asymmetry);
# https://github.com/LuxCoreRender/LuxCore (src/slg/volumes/volume.cpp)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet pyluxcore==2.11.2 numpy==2.5.5
cat >fog.py <<'END'
import math
import os
import time

import numpy as np
import pyluxcore

SIZE = 8
# A camera that looks along +y through 1 m of fog.
SCENE = """
scene.camera.type = orthographic
scene.camera.lookat.orig = 0 -10 0
scene.camera.lookat.target = 0 0 0
scene.camera.up = 0 0 1
scene.camera.screenwindow = -0.1 0.1 -0.1 0.1
scene.volumes.fog.type = homogeneous
scene.volumes.fog.absorption = 0 0 0
scene.volumes.fog.scattering = {sigma} {sigma} {sigma}
scene.volumes.fog.asymmetry = {g} {g} {g}
scene.volumes.fog.multiscattering = 1
scene.materials.air.type = null
scene.materials.air.volume.interior = fog
scene.shapes.box.type = inlinedmesh
scene.shapes.box.vertices = -2 -0.5 -2 2 -0.5 -2 2 0.5 -2 -2 0.5 -2 -2 -0.5 2 2 -0.5 2 2 0.5 2 -2 0.5 2
scene.shapes.box.faces = 0 2 1 0 3 2 4 5 6 4 6 7 0 1 5 0 5 4 1 2 6 1 6 5 2 3 7 2 7 6 3 0 4 3 4 7
scene.objects.box.shape = box
scene.objects.box.material = air
"""
SETTINGS = """
renderengine.type = PATHCPU
sampler.type = SOBOL
path.pathdepth.total = {depth}
path.pathdepth.diffuse = {depth}
path.russianroulette.cap = 1
path.clamping.variance.maxvalue = 0
film.width = 8
film.height = 8
film.filter.type = NONE
film.imagepipelines.0.0.type = NOP
batch.haltspp = {samples}
"""


def mean(g, sigma, light, depth, samples):
    """The mean of the picture."""
    settings, description = pyluxcore.Properties(), pyluxcore.Properties()
    settings.SetFromString(SETTINGS.format(depth=depth, samples=samples))
    description.SetFromString(SCENE.format(g=g, sigma=sigma) + light)
    scene = pyluxcore.Scene()
    scene.Parse(description)
    session = pyluxcore.RenderSession(pyluxcore.RenderConfig(settings, scene))
    session.Start()
    while not session.HasDone():
        time.sleep(0.02)
        session.UpdateStats()
    pixels = np.zeros((SIZE, SIZE, 3), np.float32)
    session.GetFilm().GetOutputFloat(pyluxcore.FilmOutputType.RGB_IMAGEPIPELINE, pixels)
    session.Stop()
    return float(pixels.mean())


def sun(degrees):
    """Light that is turned by so much on its way into the camera."""
    angle = math.radians(degrees)
    direction = f"{math.sin(angle)} {-math.cos(angle)} 0"
    return f"scene.lights.sun.type = sharpdistant\nscene.lights.sun.direction = {direction}\n"


def henyey_greenstein(g, degrees):
    """In units of isotropic scattering."""
    return (1 - g * g) / (1 + g * g - 2 * g * math.cos(math.radians(degrees))) ** 1.5


def check(text, found, wanted, width):
    print("LuxCore", pyluxcore.Version(), text, "%.3f" % found, flush=True)
    if abs(found - wanted) > width:
        print("this has changed", flush=True)
        os._exit(1)  # at once: its threads are still there


pyluxcore.Init(lambda message: None)
for g, wanted in (0.5, 1), (0.8, 1), (0.93, 1), (0.94, 0.368), (0.95, 0.368), (-0.95, 0.368):
    sky = mean(g, 1, "scene.lights.sky.type = constantinfinite\n", 64, 400)
    check(f"asymmetry {g}: fog below a white sky has", sky, wanted, 0.02)
for degrees, g, wanted in (90, 0.3, 0.80), (90, 0.8, 0.082), (10, 0.8, 25.8), (90, 0.95, 0), (5, 0.95, 0):
    isotropic = mean(0, 0.05, sun(degrees), 2, 1500)
    right = henyey_greenstein(g, degrees)
    found = mean(g, 0.05, sun(degrees), 2, 1500) / isotropic
    check(f"asymmetry {g}, {degrees} degrees: {right:.3f} is right, it has", found, wanted, 0.05 * right)
os._exit(0)
END
venv/bin/python fog.py 2>&1 | grep "^LuxCore\|changed\|Error"
