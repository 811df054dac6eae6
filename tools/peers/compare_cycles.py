#!/usr/bin/env python3
"""The same frames in Cycles and by sunfleck from the exported file: a table of mean ratios.

    python3.11 -m venv .venv && .venv/bin/pip install '.[cycles]'
    .venv/bin/python tools/peers/compare_cycles.py --sunfleck target/release/sunfleck
    .venv/bin/python tools/peers/compare_cycles.py scene.blend --frame 12 --bounces 4 --walks 256 --pictures FOLDER

Frames are of kinds of lights, or of what is named: small scenes of tools/blender/tests, by parts of their names
('' is part of all), or .blend files, whose simulations are run from the first frame. Cycles with no bounces is
direct light and single scattering. With `--walks`, where only the first ratio is far from 1 the grid errs; where
both are, materials, lights or fog differ. Exits with 1 if a mean differs by more than the bar.
"""

import os
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "blender" / "tests"), str(HERE.parent / "blender"), str(HERE.parent)]

import bpy
import numpy

import beside_scenes
import scenes
from beside_stage import lamp
import sunfleck
from sunfleck_tools.peers import beside
from common import parser

SIZE = (160, 90)
LIGHTS = {
    "sun": scenes.sun,
    "sun, a disc of 10 deg": beside_scenes.sun_disc,
    "sun, shifted lens": beside_scenes.shifted_lens,
    "point": beside_scenes.point,
    # With soft falloff Cycles uses a disc that faces each lit point.
    "sphere": beside_scenes.sphere,
    "spot": beside_scenes.spot,
    "area, rectangle": beside_scenes.area,
    "area, disk": lambda scene: lamp(scene, "AREA", energy=60.0, shape="DISK", size=0.6),
}
IN_FOG = {"sun in fog": scenes.sun, "point in fog": beside_scenes.point, "spot in fog": beside_scenes.spot,
          "area in fog": beside_scenes.area}


def lights():
    """Builders of scenes of the docs' size, by name."""
    in_fog = {name: lambda scene, build=build: (build(scene), beside_scenes.fog(scene)) for name, build in IN_FOG.items()}
    return {name: beside_scenes.on_stage(build, SIZE) for name, build in {**LIGHTS, **in_fog}.items()}


def opened(path, frame):
    """Builder of the scene of a .blend file, and of the frame, else the saved one."""

    def build():
        bpy.ops.wm.open_mainfile(filepath=str(Path(path).resolve()))
        scene = bpy.context.scene
        return scene, scene.frame_current if frame is None else frame

    return build


def wanted(arguments):
    """Names and builders."""
    found = {} if arguments.scenes else lights()
    for part in arguments.scenes:
        if part.endswith(".blend"):
            found[Path(part).stem] = opened(part, arguments.frame)
        else:
            found |= {name: build for name, (build, _) in beside_scenes.SCENES.items() if part in name}
    return found


def compare(name, build, arguments, folder):
    """Mean ratios, one for each number of bounces."""
    os.environ["SUNFLECK_BAKES"] = str(folder)
    scene, frame = build()
    render = scene.render
    size = [max(1, round(side * arguments.scale)) for side in (render.resolution_x, render.resolution_y)]
    first = beside.Wish(arguments.sunfleck, frame, size, arguments.samples, arguments.cycles_samples)
    for finding in beside.exported(scene, first, folder):
        print(f"{finding.severity.lower()}{finding}")
    for bounces in arguments.bounces:
        wish = replace(first, bounces=bounces)
        ours = [beside.ours(scene, wish, folder)]
        if arguments.walks:
            ours.append(beside.ours(scene, replace(wish, samples=arguments.walks), folder, "paths"))
        theirs = beside.theirs(scene, wish, folder)
        yield tell(name, bounces, ours, theirs, arguments.pictures)


def tell(name, bounces, ours, theirs, folder):
    """Prints a row, with the root mean square difference relative to the mean; returns the mean ratio."""
    mean = theirs.mean()
    ratio, *walks = (picture.mean() / mean for picture in ours)
    difference = float(numpy.sqrt(numpy.mean((ours[0] - theirs) ** 2)) / mean)
    # Of blocks beside the last one, as random walks know them to about a hundredth.
    blocks = beside.ratios_of_blocks(ours[0], [theirs, *ours[1:]][-1], 6, 4, 0.05)
    print(
        f"{name:24} {mean:10.5f} {ratio:9.5f} {100.0 * difference:9.2f} %  {bounces} bounces, "
        f"blocks {blocks[0]:.4f} to {blocks[-1]:.4f}",
        *(f"of walks, whose mean has {one:.5f}" for one in walks),
        flush=True,
    )
    if folder:
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / f"{name.replace(', ', '_').replace(' ', '_')}_{bounces}.png"
        row = (*ours, theirs, 10.0 * numpy.abs(ours[0] - theirs))
        path.write_bytes(beside.side_by_side(row, numpy.quantile(theirs, 0.98)))
    return ratio


def main():
    command = parser(__doc__)
    command.add_argument("scenes", nargs="*", help="parts of names, or .blend files; else lights")
    command.add_argument("--frame", type=int, help="of .blend files; else the saved one")
    command.add_argument("--scale", type=float, default=1.0, help="of the picture's sides")
    command.add_argument("--bounces", type=int, nargs="+", default=[0])
    command.add_argument("--sunfleck", type=Path, default=Path("target/release/sunfleck"))
    command.add_argument("--samples", type=int, default=64, help="of sunfleck")
    command.add_argument("--walks", type=int, help="samples of sunfleck by random walks, too")
    command.add_argument("--cycles-samples", type=int, default=256)
    command.add_argument("--bar", type=float, default=0.005, help="largest difference of a mean ratio from 1")
    command.add_argument("--pictures", type=Path, help="folder for PNGs: ours, by walks, Cycles', 10 x difference")
    arguments = command.parse_args()
    sunfleck.register()
    print(f"{'scene':24} {'mean':>10} {'ratio':>9} {'difference':>11}")
    ratios = []
    for name, build in wanted(arguments).items():
        with tempfile.TemporaryDirectory() as folder:
            ratios.extend(compare(name, build, arguments, Path(folder)))
    return int(any(abs(ratio - 1.0) > arguments.bar for ratio in ratios))


if __name__ == "__main__":
    sys.exit(main())
