r"""Light of all orders beside Mitsuba's. Out come the mean ratio, and the root mean square of what blocks of
10x10 pixels of 240x135 differ by.

    cd tools && SUNFLECK=sunfleck python peers/all_orders.py ../tests/data/canopy20k/scene.ron \
        --bounces all --samples 8 --pictures 12

The reference is the mean of independent pictures, whose spread tells its own noise. That is
taken out in quadrature.
"""

from pathlib import Path

import numpy as np

from common import blocks, colors, error, parser, program, rendered, truth_of

from sunfleck_tools.commands.peers import bounces
from sunfleck_tools.peers import mitsuba
from sunfleck_tools.peers.scene import read_scene


def main() -> None:
    """Prints both figures."""
    command = parser(__doc__)
    command.add_argument("scene", type=Path)
    command.add_argument("--frame", type=int, default=1)
    command.add_argument("--bounces", type=bounces, default=bounces("all"))
    command.add_argument("--samples", type=int, default=8, help="a pixel and picture")
    command.add_argument("--pictures", type=int, default=12)
    command.add_argument(
        "--variant", default="scalar_rgb", help="llvm_ad_rgb where Mitsuba finds an LLVM that it likes"
    )
    arguments = command.parse_args()
    scene = read_scene(arguments.scene, arguments.frame, program())
    scene.size, scene.bounces = (240, 135), arguments.bounces
    render = mitsuba.prepare(scene, arguments.variant)
    theirs = np.stack([blocks(render(arguments.samples, seed)[0]) for seed in range(arguments.pictures)])
    orders = "all" if arguments.bounces == bounces("all") else str(arguments.bounces)
    flags = ["--samples", "4", "--bounces", orders]
    ours = blocks(colors(rendered(arguments.scene, "240x135", flags, arguments.frame)[0]))
    mean, noise = truth_of(theirs)
    ratios = ours.mean(axis=(0, 1)) / mean.mean(axis=(0, 1))
    print(f"mean ratio {' '.join(f'{ratio:.4f}' for ratio in ratios)}, blocks {100 * error(ours, mean, noise):.2f} %")


if __name__ == "__main__":
    main()
