#!/usr/bin/env python3
"""Any .blend beside Cycles: one frame by both, with as many bounces, the ratio of the means, of blocks,
and a picture of three.

    PYTHONPATH=tools .venv/bin/python tools/peers/beside_cycles.py scene.blend --frame 12 --sunfleck target/release/sunfleck --picture three.png

The picture shows sunfleck's, Cycles' and ten times their difference. The world is the sky here, and
lights surfaces and fog, as in Cycles. Simulations are run from the first frame. Exits with 1 if the means
differ by more than the bar.
"""

import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "blender")]

import bpy
import numpy

import sunfleck
from sunfleck_tools.peers import beside
from common import parser

BLOCKS = 8


def main():
    command = parser(__doc__)
    command.add_argument("blend", type=Path)
    command.add_argument("--frame", type=int, help="else the one that was saved")
    command.add_argument("--scale", type=float, default=1.0, help="of the picture's sides")
    command.add_argument("--sunfleck", type=Path, default=Path("target/release/sunfleck"))
    command.add_argument("--samples", type=int, default=64, help="of sunfleck")
    command.add_argument("--cycles-samples", type=int, default=256)
    command.add_argument("--bounces", type=int, default=0)
    command.add_argument(
        "--bar", type=float, default=0.005, help="largest difference of the ratio of means from 1"
    )
    command.add_argument("--picture", type=Path, help="a PNG of three")
    arguments = command.parse_args()
    sunfleck.register()
    bpy.ops.wm.open_mainfile(filepath=str(arguments.blend.resolve()))
    scene = bpy.context.scene
    frame = scene.frame_current if arguments.frame is None else arguments.frame
    size = [
        max(1, round(side * arguments.scale))
        for side in (scene.render.resolution_x, scene.render.resolution_y)
    ]
    wish = beside.Wish(
        arguments.sunfleck, frame, size, arguments.samples, arguments.cycles_samples, arguments.bounces
    )
    with tempfile.TemporaryDirectory() as folder:
        ours, theirs, findings = beside.pictures(scene, wish, Path(folder))
    for finding in findings:
        print(f"{finding.severity.lower()}{finding}")
    ratio = ours.mean() / theirs.mean()
    blocks = beside.ratios_of_blocks(ours, theirs, BLOCKS, BLOCKS, 0.01)
    print(
        f"mean {theirs.mean():.5f}, ratio {ratio:.5f}, {len(blocks)} blocks from {blocks[0]:.4f} to "
        f"{blocks[-1]:.4f}"
    )
    if arguments.picture:
        three = (ours, theirs, 10.0 * numpy.abs(ours - theirs))
        arguments.picture.write_bytes(beside.side_by_side(three, numpy.quantile(theirs, 0.98)))
    return int(abs(ratio - 1.0) > arguments.bar)


if __name__ == "__main__":
    sys.exit(main())
