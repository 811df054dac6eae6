#!/usr/bin/env python3
r"""Light of all orders: error against processor time, beside Cycles without and with its denoiser.

    cd tools && SUNFLECK=../target/release/sunfleck ../.venv/bin/python peers/all_light.py \
        ../tests/data/leaves500/leaves500.glb

Errors are root mean squares over the pixels of a window, as shares of its mean, from random walks of many samples
by sunfleck, whose light is unbiased. The walks come in two halves, whose difference tells their noise; it is taken
out. Pictures are whole. Of sunfleck whole processes count, from start to written file, to several tolerances; of Cycles rendering alone. Both
come in turns. The time to an error is read off straight lines between logarithms; nothing is extrapolated.
"""

from pathlib import Path

import numpy as np

from common import error, floats, ints, pair, parser, picture, program, truth_of
from equal_error import seconds_to

from sunfleck_tools.commands.peers import bounces
from sunfleck_tools.peers import cycles
from sunfleck_tools.peers.scene import read_scene

HALVES = ("1001", "1002")
TOLERANCES = ("0.2", "0.1", "0.05", "0.02", "0.01")
DENOISERS = {"Cycles": None, "Cycles, denoised": "OPENIMAGEDENOISE"}


def main() -> None:
    """Prints all points, and the time for each error."""
    command = parser(__doc__)
    command.add_argument("source", type=Path)
    command.add_argument("--size", default="480x270")
    command.add_argument("--window", default="180,100,300,170", help="x0,y0,x1,y1, where errors are measured")
    command.add_argument("--reference-samples", default="2048", help="of each half")
    command.add_argument("--cycles-samples", type=ints, default=[4, 16, 64, 400])
    command.add_argument("--targets", type=floats, default=[0.025, 0.015])
    arguments = command.parse_args()
    x0, y0, x1, y1 = ints(arguments.window)

    def ours(*flags: str) -> tuple[np.ndarray, float]:
        always = ["--bounces", "all", "--filter", "box", "--passes", "none"]
        return picture(arguments.source, arguments.size, [*always, *flags])[:2]

    walks = ["--volume", "paths", "--crop", arguments.window, "--samples", arguments.reference_samples, "--seed"]
    truth, noise = truth_of(np.stack([ours(*walks, seed)[0] for seed in HALVES]))
    print(f"reference: its noise {100 * noise**0.5 / truth.mean():.2f} %")
    theirs = read_scene(arguments.source, None, program())
    theirs.size, theirs.bounces = pair(arguments.size), bounces("all")
    points: dict[str, list[tuple[float, float]]] = {"sunfleck": []}

    def add(name: str, effort: object, found: np.ndarray, seconds: float) -> None:
        points.setdefault(name, []).append((error(found[y0:y1, x0:x1], truth, noise), seconds))
        print(f"{name:17} {effort!s:>6} {100 * points[name][-1][0]:8.2f} % {seconds:9.3f} CPU s", flush=True)

    for tolerance in TOLERANCES:
        add("sunfleck", tolerance, *ours("--tolerance", tolerance))
    for name, denoiser in DENOISERS.items():
        render = cycles.prepare(theirs, denoiser)
        for samples in arguments.cycles_samples:
            add(name, samples, *render(samples, 1))
    for target in arguments.targets:
        mine = seconds_to(target, points["sunfleck"])
        others = ((name, seconds_to(target, points[name])) for name in DENOISERS)
        told = ", ".join(f"{name} {seconds:.2f} CPU s, {seconds / mine:.0f} times" for name, seconds in others)
        print(f"to {100 * target:g} %: sunfleck {mine:.3f} CPU s; {told}")


if __name__ == "__main__":
    main()
