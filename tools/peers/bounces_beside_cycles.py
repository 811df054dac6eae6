#!/usr/bin/env python3
"""The small scenes of tools/blender/tests beside Cycles with bounces, on our grid and by our random walks.

    PYTHONPATH=tools:tools/blender:tools/blender/tests .venv/bin/python tools/peers/bounces_beside_cycles.py --bounces 1 4

prints the ratio of means to Cycles for each scene and number of bounces: of the grid, and of `--volume
paths`. Where only the first is far from 1 the grid errs. Where both are, materials, lights or fog differ.
`--pictures FOLDER` writes three pictures side by side: grid, walks, Cycles.
"""

import contextlib
import os
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "blender" / "tests"), str(HERE.parent / "blender"), str(HERE.parent)]

import beside_scenes
import numpy

import sunfleck
from sunfleck_tools.peers import beside
from common import parser


def main():
    command = parser(__doc__)
    command.add_argument("scenes", nargs="*", help="parts of their names; else all")
    command.add_argument("--bounces", type=int, nargs="+", default=[1, 4])
    command.add_argument("--sunfleck", type=Path, default=Path("target/release/sunfleck"))
    command.add_argument("--samples", type=int, default=32, help="of sunfleck on the grid")
    command.add_argument("--walks", type=int, default=256, help="samples of sunfleck by random walks")
    command.add_argument("--cycles-samples", type=int, default=256)
    command.add_argument("--pictures", type=Path, help="a folder")
    arguments = command.parse_args()
    sunfleck.register()
    for name, (build, _) in beside_scenes.SCENES.items():
        if not arguments.scenes or any(part in name for part in arguments.scenes):
            with tempfile.TemporaryDirectory() as folder:
                os.environ["SUNFLECK_BAKES"] = folder
                with silent():
                    found = list(measured(build, arguments, Path(folder)))
            for bounces, *pictures in found:
                tell(name, bounces, pictures, arguments.pictures)


def measured(build, arguments, folder):
    """For each number of bounces: sunfleck's pictures on the grid and by walks, and Cycles'."""
    scene, frame = build()
    size = (scene.render.resolution_x, scene.render.resolution_y)
    first = beside.Wish(arguments.sunfleck, frame, size, arguments.samples, arguments.cycles_samples)
    beside.exported(scene, first, folder)
    for bounces in arguments.bounces:
        wish = replace(first, bounces=bounces)
        walks = replace(wish, samples=arguments.walks)
        yield (
            bounces, beside.ours(scene, wish, folder), beside.ours(scene, walks, folder, "paths"),
            beside.theirs(scene, wish, folder),
        )


def tell(name, bounces, pictures, folder):
    grid, walks, theirs = pictures
    mean = theirs.mean()
    # Of blocks of the picture, which random walks do not know much better than to a hundredth.
    worst = beside.ratios_of_blocks(grid, walks, 6, 4, 0.05)
    print(
        f"{name:28} {bounces} {mean:9.5f} grid {grid.mean() / mean:8.4f} walks {walks.mean() / mean:8.4f} "
        f"grid to walks by blocks {worst[0]:6.3f} to {worst[-1]:6.3f}",
        flush=True,
    )
    if folder:
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / f"{name.replace(', ', '_').replace(' ', '_')}_{bounces}.png"
        path.write_bytes(beside.side_by_side(pictures, numpy.quantile(theirs, 0.98)))


@contextlib.contextmanager
def silent():
    """Silences Cycles' messages about samples."""
    out = os.dup(1)
    with open(os.devnull, "w") as nothing:
        os.dup2(nothing.fileno(), 1)
    try:
        yield
    finally:
        os.dup2(out, 1)
        os.close(out)


if __name__ == "__main__":
    sys.exit(main())
