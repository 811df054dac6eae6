#!/usr/bin/env python3
"""How much longer Cycles takes than sunfleck to the same error: ratios of processor seconds, in one run.

    python3.11 -m venv .venv && .venv/bin/pip install './tools[cycles]'
    .venv/bin/python tools/peers/equal_error.py --sunfleck target/release/sunfleck

Every picture is a process of its own. `whole` is all that it takes: the program's start (with Blender that of Python and its
module), reading, building, rendering, writing an EXR. `render` is that without what the same process takes for one sample a
pixel of 16 x 9 pixels, so without start, reading and building; what is left of writing stays in, on both sides.

Errors are root mean square differences from a reference, whose own noise is taken out. The time to an error is read off a
straight line between two numbers of samples, both axes logarithmic; nothing is extrapolated. After each picture by Cycles
sunfleck makes all of its own, of another seed: so both have a round's load alike, and what is told of sunfleck is a mean.

Cycles' settings are those of `sunfleck_tools/peers/cycles.py`: no bounces, which is direct light and single scattering, a box
filter one pixel wide, no denoiser, no adaptive sampling, no clamping; beyond that its defaults. Blue noise, distance and
equiangular sampling of volumes, its biased volumes, no light tree and spatial splits were tried too: none did better by more than 10 %.
Both have as many threads as there are processors: with fewer a thread of Cycles that waits spins, and its seconds count.
"""

import argparse
import math
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy

from sunfleck_tools.peers.scene import read_scene
from sunfleck_tools.pictures import load

LEAVES500 = Path(__file__).resolve().parents[2] / "tests/data/leaves500"
EMPTY_SIZE = "16x9"


def colors(path):
    frame, fault = load(0, str(path))
    if frame is None:
        sys.exit(f"{path}: {fault}")
    return numpy.stack(frame.group(), axis=-1).astype(float)


def picture_by_cycles(arguments):
    """What a process for one picture by Cycles does."""
    from sunfleck_tools.peers import cycles

    scene = read_scene(arguments.input)
    scene.size = pair(arguments.size)
    made = cycles.build(scene)
    made.render.threads_mode, made.render.threads = "FIXED", arguments.threads
    cycles.write(made, arguments.cycles_samples[0], arguments.seed, arguments.picture)


class Renderer:
    """Makes pictures, and knows what each took."""

    def __init__(self, name, samples, command):
        self.name, self.samples, self.command = name, samples, command

    def cpu_s(self, size, samples, seed, target):
        """Of a process that makes a picture, from its start to its end."""
        command = self.command(size, samples, seed, target)
        with subprocess.Popen([str(part) for part in command], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) as process:
            said = process.stderr.read()
            _, status, used = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode != 0:
            sys.exit(f"{self.name} failed:\n{said.decode(errors='replace')}")
        return used.ru_utime + used.ru_stime


def seconds_to(target, points):
    """Where a line through points (error, seconds) meets an error, both axes logarithmic."""
    for (e0, t0), (e1, t1) in zip(points, points[1:]):
        if e0 >= target > e1:
            return t0 * (t1 / t0) ** (math.log(target / e0) / math.log(e1 / e0))
    sys.exit(f"no two numbers of samples have an error of {target} between them: {[round(e, 5) for e, _ in points]}")


def pair(text):
    return tuple(map(int, text.split("x")))


def numbers(text):
    return [int(part) for part in text.split(",")]


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("input", nargs="?", type=Path, default=LEAVES500 / "leaves500.glb")
    parser.add_argument("--sunfleck", type=Path, default=Path("target/release/sunfleck"))
    parser.add_argument("--reference", type=Path, default=LEAVES500 / "box.exr")
    parser.add_argument("--reference-noise", type=float, default=0.00143, help="root mean square of its standard error")
    parser.add_argument("--targets", type=lambda text: [float(part) for part in text.split(",")], default=[0.02, 0.01])
    parser.add_argument("--samples", type=numbers, default=[1, 4, 8, 16], help="of sunfleck")
    parser.add_argument("--cycles-samples", type=numbers, default=[32, 64, 128, 256])
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--threads", type=int, default=os.cpu_count(), help="of both (all processors)")
    one = parser.add_argument_group("a process for one picture by Cycles, which this program starts itself")
    one.add_argument("--picture", type=Path, help=argparse.SUPPRESS)
    one.add_argument("--size", help=argparse.SUPPRESS)
    one.add_argument("--seed", type=int, help=argparse.SUPPRESS)
    return parser.parse_args()


class Session:
    """Measures pictures against the reference, and prints them."""

    def __init__(self, arguments, reference, folder):
        self.arguments, self.reference, self.folder = arguments, reference, folder

    def point(self, renderer, samples, seed):
        """Error, and seconds of the whole process."""
        target, size = self.folder / f"{renderer.name}.exr", f"{self.reference.shape[1]}x{self.reference.shape[0]}"
        seconds = renderer.cpu_s(size, samples, seed, target)
        square = numpy.mean((colors(target) - self.reference) ** 2)
        error = max(square - self.arguments.reference_noise**2, 0.0) ** 0.5
        print(f"{renderer.name:9} {samples:8} {seed:5} {error:9.5f} {seconds:9.3f}", flush=True)
        return error, seconds

    def empty(self, renderer, seed):
        """Seconds of a process that renders next to nothing."""
        return renderer.cpu_s(EMPTY_SIZE, 1, seed, self.folder / f"{renderer.name}.exr")

    def round(self, ours, theirs, number):
        """Points of both, and the seconds of their empty processes."""
        points, mine, empty = [], {samples: [] for samples in ours.samples}, []
        for turn, samples in enumerate(theirs.samples):
            points.append(self.point(theirs, samples, number))
            seed = number * len(theirs.samples) + turn
            empty.append(self.empty(ours, seed))
            for own in ours.samples:
                mine[own].append(self.point(ours, own, seed))
        means = [(statistics.fmean(e * e for e, _ in found) ** 0.5, statistics.fmean(s for _, s in found)) for found in mine.values()]
        return (means, statistics.fmean(empty)), (points, self.empty(theirs, number))


def main():
    arguments = parse()
    if arguments.picture is not None:
        return picture_by_cycles(arguments)
    reference, threads = colors(arguments.reference), arguments.threads

    def by_sunfleck(size, samples, seed, target):
        given = ["--size", size, "--samples", samples, "--seed", seed, "--threads", threads, "--passes", "none"]
        return [arguments.sunfleck, "render", arguments.input, *given, "--out", target]

    def by_cycles(size, samples, seed, target):
        given = ["--size", size, "--cycles-samples", samples, "--seed", seed, "--threads", threads]
        return [sys.executable, __file__, arguments.input, *given, "--picture", target]

    ours, theirs = Renderer("sunfleck", arguments.samples, by_sunfleck), Renderer("Cycles", arguments.cycles_samples, by_cycles)
    found = {(target, kind): [] for target in arguments.targets for kind in ("render", "whole")}
    print(f"{arguments.input.name}, {reference.shape[1]} x {reference.shape[0]}, threads: {threads}")
    print(f"{'':9} {'samples':>8} {'seed':>5} {'RMSE':>9} {'CPU s':>9}")
    with tempfile.TemporaryDirectory() as folder:
        session = Session(arguments, reference, Path(folder))
        for number in range(1, arguments.rounds + 1):
            sides = session.round(ours, theirs, number)
            print("start, reading and building: " + ", ".join(f"{empty:.3f} CPU s" for _, empty in sides))
            for target, kind in found:
                less = kind == "render"
                found[target, kind].append(
                    [seconds_to(target, [(error, seconds - less * empty) for error, seconds in points]) for points, empty in sides]
                )
    for (target, kind), pairs in found.items():
        ratios = sorted(other / mine for mine, other in pairs)
        mine_s, other_s = (statistics.median(side) for side in zip(*pairs))
        print(
            f"to RMSE {target}, {kind:6}: sunfleck {mine_s:7.3f} CPU s, Cycles {other_s:7.2f}, "
            f"ratio {statistics.median(ratios):5.0f} ({ratios[0]:.0f} to {ratios[-1]:.0f})"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
