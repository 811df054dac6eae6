#!/usr/bin/env python3
r"""Light of all orders: error against processor time, beside Cycles without and with its denoiser.

    cd tools && SUNFLECK=../target/release/sunfleck ../.venv/bin/python peers/all_light.py \
        ../tests/data/leaves500/leaves500.glb

Errors are root mean squares over the pixels of a window, as shares of its mean, from random walks of many samples
by sunfleck, whose light is unbiased. The walks come in two halves, whose difference tells their noise; it is taken
out. Pictures are whole. Of sunfleck whole processes count, from start to written file, to several tolerances; of Cycles rendering alone. Both
come in turns. The time to an error is read off straight lines between logarithms; nothing is extrapolated.
"""

import tempfile
from pathlib import Path

import numpy as np

from common import colors, cpu_seconds, parser, program
from equal_error import pair, seconds_to

from sunfleck_tools.commands.peers import bounces
from sunfleck_tools.exr.decode import decode
from sunfleck_tools.peers import cycles
from sunfleck_tools.peers.scene import read_scene

HALVES = (1001, 1002)
TOLERANCES = (0.2, 0.1, 0.05, 0.02, 0.01)
DENOISERS = {"Cycles": None, "Cycles, denoised": "OPENIMAGEDENOISE"}


def floats(text: str) -> list[float]:
    """Numbers of a list."""
    return [float(part) for part in text.split(",")]


class Scene:
    """Scene with its reference."""

    def __init__(self, source: Path, size: str, window: str, samples: int):
        self.source, self.size = source, size
        x0, y0, x1, y1 = map(int, window.split(","))
        self.window = np.s_[y0:y1, x0:x1]
        walks = ["--volume", "paths", "--crop", window, "--samples", samples]
        one, other = (self.by_sunfleck([*walks, "--seed", seed])[0] for seed in HALVES)
        self.truth = 0.5 * (one + other)
        # The variance of the mean of two is a quarter of that of their difference.
        self.noise = float(((0.5 * (one - other)) ** 2).mean())

    def by_sunfleck(self, flags: list) -> tuple[np.ndarray, float]:
        """Picture, and CPU seconds of its process."""
        with tempfile.TemporaryDirectory() as folder:
            out = Path(folder, "picture.exr")
            given = ["--frames", 1, "--size", self.size, "--filter", "box", "--passes", "none", "--out", out]
            seconds = cpu_seconds([program(), "render", self.source, "--bounces", "all", *given, *flags])
            return colors(decode(out)), seconds

    def error(self, picture: np.ndarray) -> float:
        """Error of a picture within the window, without the reference's own noise."""
        return float(max(((picture[self.window] - self.truth) ** 2).mean() - self.noise, 0.0) ** 0.5 / self.truth.mean())


def main() -> None:
    """Prints all points, and the time for each error."""
    command = parser(__doc__)
    command.add_argument("source", type=Path)
    command.add_argument("--size", default="480x270")
    command.add_argument("--window", default="180,100,300,170", help="x0,y0,x1,y1, where errors are measured")
    command.add_argument("--reference-samples", type=int, default=2048, help="of each half")
    command.add_argument("--cycles-samples", type=lambda text: [int(part) for part in text.split(",")], default=[4, 16, 64, 400])
    command.add_argument("--targets", type=floats, default=[0.025, 0.015])
    arguments = command.parse_args()
    scene = Scene(arguments.source, arguments.size, arguments.window, arguments.reference_samples)
    print(f"reference: its noise {100 * scene.noise**0.5 / scene.truth.mean():.2f} %")
    theirs = read_scene(arguments.source, None, program())
    theirs.size, theirs.bounces = pair(arguments.size), bounces("all")
    points: dict[str, list[tuple[float, float]]] = {"sunfleck": []}

    def add(name: str, effort: object, picture: np.ndarray, seconds: float) -> None:
        points.setdefault(name, []).append((scene.error(picture), seconds))
        print(f"{name:17} {effort!s:>6} {100 * scene.error(picture):8.2f} % {seconds:9.3f} CPU s", flush=True)

    for tolerance in TOLERANCES:
        add("sunfleck", tolerance, *scene.by_sunfleck(["--tolerance", tolerance]))
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
