r"""Light of all orders beside Mitsuba's. Out come the mean ratio, and the root mean square of what blocks of
10x10 pixels of 240x135 differ by.

    cd tools && SUNFLECK=sunfleck python peers/all_orders.py ../tests/data/canopy20k/scene.ron \
        --bounces all --samples 8 --pictures 12

The reference is the mean of independent pictures, whose spread tells its own noise. That is
taken out in quadrature.
"""

import argparse
import os
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from sunfleck_tools.commands.peers import bounces, colors
from sunfleck_tools.peers import mitsuba
from sunfleck_tools.peers.scene import read_scene

SIZE = 240, 135
BLOCK = 10


def blocks(picture: np.ndarray) -> np.ndarray:
    """Means of blocks of a picture; rows and columns that fill none are left out."""
    rows, columns = picture.shape[0] // BLOCK, picture.shape[1] // BLOCK
    inside = picture[: rows * BLOCK, : columns * BLOCK]
    return inside.reshape(rows, BLOCK, columns, BLOCK, 3).mean(axis=(1, 3))


def main() -> None:
    """Prints both figures."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("scene", type=Path)
    parser.add_argument("--frame", type=int, default=1)
    parser.add_argument("--bounces", type=bounces, default=bounces("all"))
    parser.add_argument("--samples", type=int, default=8, help="a pixel and picture")
    parser.add_argument("--pictures", type=int, default=12)
    parser.add_argument(
        "--variant", default="scalar_rgb", help="llvm_ad_rgb where Mitsuba finds an LLVM that it likes"
    )
    arguments = parser.parse_args()
    program = os.environ.get("SUNFLECK", "sunfleck")
    scene = read_scene(arguments.scene, arguments.frame, program)
    scene.size, scene.bounces = SIZE, arguments.bounces
    render = mitsuba.prepare(scene, arguments.variant)
    theirs = np.stack([blocks(render(arguments.samples, seed)[0]) for seed in range(arguments.pictures)])
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder, "ours.exr")
        orders = "all" if arguments.bounces == bounces("all") else str(arguments.bounces)
        command = [program, "render", str(arguments.scene), "--frames", str(arguments.frame)]
        command += ["--size", "240x135", "--samples", "4", "--bounces", orders]
        command += ["--progress", "none", "--out", str(out)]
        subprocess.run(command, check=True)
        ours = blocks(colors(out))
    mean = theirs.mean(axis=0)
    noise = theirs.var(axis=0, ddof=1).mean() / len(theirs)
    error = np.sqrt(max(0.0, ((ours - mean) ** 2).mean() - noise)) / mean.mean()
    print(
        f"mean ratio {' '.join(f'{ratio:.4f}' for ratio in ours.mean(axis=(0, 1)) / mean.mean(axis=(0, 1)))}, blocks {100 * error:.2f} %"
    )


if __name__ == "__main__":
    main()
