#!/usr/bin/env bash
# Slow motion in USD keeps the old velocities: leaves fall at full speed within a frame, and are elsewhere in the next.
#
# Expected: a layer offset with a scale of 4 plays a reference four times as slowly, all of it. Leaves that fall by 1 m a
# frame fall by 0.25 m; half a frame after frame 4, at -1 m, they are at -1.125 m. What happens: OpenUSD retimes samples,
# and leaves `velocities`, which are in units per second, as they are. Between samples velocities count and nothing else,
# so leaves are at -1.5 m there, and at -1.75 m by frame 4.75; 0.01 frames before frame 8 they are at -4.99 m, and at
# frame 8 at -2 m. Motion blur is four times as long; played twice as fast, it is half as long. `angularVelocities`
# stay as well, points do the same as instances, and `Flatten` writes it so. Nothing is said.
# A layer with another `timeCodesPerSecond` is right: there a second stays a second.
# Remedy: where a clip is retimed, divide both by the scale; or block them, so that USD interpolates.
# Versions: usd-core 26.11 (PyPI). Source: measured here; https://openusd.org/release/api/class_sdf_layer_offset.html;
# https://openusd.org/release/api/usd_geom_page_front.html (velocity interpolation)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet usd-core==26.11
cat >retime.py <<'END'
from pxr import Sdf, Usd, UsdGeom


def leaves(name, rate):
    """24 m down in a second, with a sample for every frame."""
    stage = Usd.Stage.CreateNew(name)
    stage.SetTimeCodesPerSecond(rate)
    stage.SetDefaultPrim(stage.DefinePrim("/Set"))
    scatter = UsdGeom.PointInstancer.Define(stage, "/Set/Leaves")
    UsdGeom.Sphere.Define(stage, "/Set/Leaves/Leaf")
    scatter.CreatePrototypesRel().AddTarget("/Set/Leaves/Leaf")
    scatter.CreateProtoIndicesAttr([0])
    dust = UsdGeom.Points.Define(stage, "/Set/Dust")
    for frame in range(11):
        for positions, velocities in [(scatter.CreatePositionsAttr(), scatter.CreateVelocitiesAttr()),
                                      (dust.CreatePointsAttr(), dust.CreateVelocitiesAttr())]:
            positions.Set([(0, 0, -frame * 24 / rate)], frame)
            velocities.Set([(0, 0, -24)], frame)
        scatter.CreateAngularVelocitiesAttr().Set([(0, 0, 90)], frame)
    stage.Save()


def heights(stage, frames):
    leaf, dust = UsdGeom.PointInstancer.Get(stage, "/Shot/Leaves"), UsdGeom.Points.Get(stage, "/Shot/Dust")
    found = [leaf.ComputeInstanceTransformsAtTime(frame, frame)[0].ExtractTranslation()[2] for frame in frames]
    points = [dust.ComputePointsAtTime(frame, frame)[0][2] for frame in frames]
    if max(abs(one - other) for one, other in zip(found, points)) > 1e-4:
        raise SystemExit("this has changed: points and instances differ")
    if leaf.GetAngularVelocitiesAttr().Get(4)[0][2] != 90:
        raise SystemExit("this has changed: turns are retimed")
    return [round(value, 2) for value in found]


leaves("film.usda", 24)
leaves("video.usda", 48)
for name, scale, frames, wanted in [
    ("film.usda", 1, (4, 4.5, 4.75, 7.99, 8), (-4, -4.5, -4.75, -7.99, -8)),
    ("film.usda", 4, (4, 4.5, 4.75, 7.99, 8), (-1, -1.5, -1.75, -4.99, -2)),
    ("film.usda", 0.5, (4, 4.25, 4.49, 4.5, 5), (-8, -8.25, -8.49, -9, -10)),
    ("video.usda", 1, (4, 4.25, 4.49, 4.5, 5), (-4, -4.25, -4.49, -4.5, -5)),
]:
    stage = Usd.Stage.CreateInMemory()
    stage.SetTimeCodesPerSecond(24)
    shot = stage.DefinePrim("/Shot")
    shot.GetReferences().AddReference(name, layerOffset=Sdf.LayerOffset(0, scale))
    flat = Usd.Stage.Open(stage.Flatten())
    print("OpenUSD", ".".join(map(str, Usd.GetVersion())), name, "scale", scale, "frames", frames, "z", heights(stage, frames))
    if any(abs(one - other) > 0.02 for one, other in zip(heights(stage, frames), wanted)):
        raise SystemExit("this has changed")
    if heights(flat, frames) != heights(stage, frames):
        raise SystemExit("this has changed: flattened it differs")
END
venv/bin/python retime.py
