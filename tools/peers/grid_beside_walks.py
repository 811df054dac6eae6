r"""Light of all orders on the grid beside that of random walks, of scenes that no other renderer reads.

    cd tools && SUNFLECK=../target/release/sunfleck python peers/grid_beside_walks.py ../sequences/title.ron --frame 24

prints the ratio of means, by channel, of the picture and of the two passes that are indirect light: what
surfaces show, and what fog scatters. Walks are noisy, and right.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from sunfleck_tools.exr.decode import decode

PASSES = {"beauty": "", "surfaces": "indirect.", "fog": "indirect_shafts."}


def means(arguments: argparse.Namespace, scene: Path, out: Path, flags: list[str]) -> dict[str, np.ndarray]:
    """Of each pass, by channel."""
    command = [os.environ.get("SUNFLECK", "sunfleck"), "render", str(scene), "--frames", str(arguments.frame)]
    command += ["--size", arguments.size, "--passes", "indirect,indirect-shafts", "--progress", "none", "--out", str(out)]
    subprocess.run([*command, *flags], check=True)
    channels = decode(out)
    return {
        name: np.array([np.asarray(channels[prefix + color], float).mean() for color in "RGB"])
        for name, prefix in PASSES.items()
    }


def main() -> None:
    """Prints a line for each scene."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("scenes", type=Path, nargs="+")
    parser.add_argument("--frame", type=int, default=24)
    parser.add_argument("--size", default="160x90")
    parser.add_argument("--walks", type=int, default=16, help="samples a pixel of walks")
    arguments = parser.parse_args()
    for scene in arguments.scenes:
        with tempfile.TemporaryDirectory() as folder:
            grid = means(arguments, scene, Path(folder, "grid.exr"), ["--samples", "16"])
            flags = ["--samples", str(arguments.walks), "--volume", "paths"]
            walks = means(arguments, scene, Path(folder, "walks.exr"), flags)
        told = [f"{name} {' '.join(f'{ratio:.3f}' for ratio in grid[name] / walks[name])}" for name in PASSES]
        print(f"{scene.stem:16} {', '.join(told)}", flush=True)


if __name__ == "__main__":
    main()
