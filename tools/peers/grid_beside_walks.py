r"""Light of all orders on the grid beside that of random walks, of scenes that no other renderer reads.

    cd tools && SUNFLECK=../target/release/sunfleck python peers/grid_beside_walks.py ../sequences/title.ron --frame 24

prints the ratio of means, by channel, of the picture and of the two passes that are indirect light: what
surfaces show, and what fog scatters. Walks are noisy, and right. With `--pictures N` there are N of them, and
by what blocks of 10x10 pixels of the picture differ is printed too, root mean square, their noise taken out.
"""

import argparse
from pathlib import Path

import numpy as np

from common import blocks, colors, error, parser, rendered, truth_of

PASSES = {"beauty": "", "surfaces": "indirect.", "fog": "indirect_shafts."}


def passes(arguments: argparse.Namespace, scene: Path, flags: list[str]) -> dict[str, np.ndarray]:
    """Each pass, height x width x 3, W m^-2 sr^-1."""
    all_flags = ["--bounces", arguments.bounces, "--passes", "indirect,indirect-shafts", *flags]
    channels, _, _ = rendered(scene, arguments.size, all_flags, arguments.frame)
    return {name: colors(channels, prefix) for name, prefix in PASSES.items()}


def told(grid: dict[str, np.ndarray], walks: list[dict[str, np.ndarray]]) -> str:
    """Ratios of means, and differences of blocks if there are several pictures by walks."""
    means = {name: np.mean([picture[name] for picture in walks], axis=0) for name in PASSES}
    ratios = {name: grid[name].mean(axis=(0, 1)) / means[name].mean(axis=(0, 1)) for name in PASSES}
    text = ", ".join(f"{name} {' '.join(f'{ratio:.3f}' for ratio in ratios[name])}" for name in PASSES)
    if len(walks) == 1:
        return text
    theirs, noise = truth_of(np.stack([blocks(picture["beauty"]) for picture in walks]))
    return f"{text}, blocks {100 * error(blocks(grid['beauty']), theirs, noise):.2f} %"


def main() -> None:
    """Prints a line for each scene."""
    command = parser(__doc__)
    command.add_argument("scenes", type=Path, nargs="+")
    command.add_argument("--frame", type=int, default=24)
    command.add_argument("--size", default="160x90")
    command.add_argument("--bounces", default="all")
    command.add_argument("--walks", type=int, default=16, help="samples a pixel of walks")
    command.add_argument("--pictures", type=int, default=1, help="by walks")
    arguments = command.parse_args()
    for scene in arguments.scenes:
        grid = passes(arguments, scene, ["--samples", "16"])
        by_walks = ["--samples", str(arguments.walks), "--volume", "paths", "--seed"]
        walks = [passes(arguments, scene, [*by_walks, str(seed)]) for seed in range(arguments.pictures)]
        print(f"{scene.stem:16} {told(grid, walks)}", flush=True)


if __name__ == "__main__":
    main()
