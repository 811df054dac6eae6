#!/usr/bin/env python3
"""How much longer Cycles takes than sunfleck to the same error: ratios of processor seconds, in one run.

    python3.11 -m venv .venv && .venv/bin/pip install '.[cycles]'
    .venv/bin/python tools/peers/equal_error.py --sunfleck target/release/sunfleck

Every picture is a process of its own. `whole` is all that it takes: start, reading, building, rendering,
writing an EXR. With Blender, the start is that of Python and its module. `render` leaves out what the
same process takes for one sample a pixel of 16 x 9 pixels, which is start, reading and building. It
leaves out what `--stats` says that sunfleck's writing took, too. Cycles' writing stays in: some
hundredths of a second of a minute.

Errors are root mean square differences from a reference, whose own noise is taken out. The time to an
error is read off a straight line between two numbers of samples, both axes logarithmic. Nothing is
extrapolated: where the fewest samples err by less, what they take is taken, which is too much. After each
picture by Cycles sunfleck makes all of its own, of another seed. So both have a round's load alike, and
what is told of sunfleck is a mean.

`--suns own,0.53,ahead` does all of it three times: for the scene's own sun, for one with a disc of so many
degrees, and for one in the middle of the picture. For suns that are not the scene's own the reference is the
mean of two pictures of 512 samples by sunfleck. Its noise is half their difference. That such pictures are
true, and those of Cycles the same, is shown elsewhere: `cargo bench --bench figures -- bias` and
`tools/peers/compare_cycles.py`. What Cycles takes for the scene's own sun is set against all. So seconds
under another sun can be told in those of another machine on which Cycles was timed.

Cycles' settings are those of `sunfleck_tools/peers/cycles.py`: no bounces, which is direct light and single
scattering, and a box filter one pixel wide. There is no denoiser, no adaptive sampling and no clamping;
beyond that it has its defaults. Blue noise, distance and equiangular sampling of volumes, its biased volumes,
no light tree and spatial splits were tried too. None did better by more than 10 %. Both have as many threads
as there are processors. With fewer, a thread of Cycles that waits spins, and its seconds count.
"""

import argparse
import math
import os
import statistics
import sys
import tempfile
from pathlib import Path

import numpy

from common import colors, cpu_seconds, floats, ints, pair, parser, told_of, truth_of

from sunfleck_tools.exr.decode import decode
from sunfleck_tools.peers.scene import read_scene
from sunfleck_tools.peers.suns import with_sun

LEAVES500 = Path(__file__).resolve().parents[2] / "tests/data/leaves500"
EMPTY_SIZE = "16x9"
OWN_SUN = "own"
REFERENCE_SAMPLES, REFERENCE_SEEDS = 512, (1001, 1002)


def picture_by_cycles(arguments):
    """Renders one picture by Cycles, in a process of its own."""
    from sunfleck_tools.peers import cycles

    scene = read_scene(arguments.input)
    scene.size = pair(arguments.size)
    made = cycles.build(scene)
    made.render.threads_mode, made.render.threads = "FIXED", arguments.threads
    cycles.write(made, arguments.cycles_samples[0], arguments.seed, arguments.picture)


class Renderer:
    """Renders pictures and measures their times."""

    def __init__(self, name, samples, command):
        self.name, self.samples, self.command = name, samples, command

    def cpu_s(self, source, size, samples, seed, target):
        """CPU seconds of a process that renders a picture, and those for writing, if it reports them."""
        stats = target.with_suffix(".json")
        seconds = cpu_seconds(self.command(source, size, samples, seed, target))
        return seconds, told_of(stats)["write_seconds"] if stats.exists() else 0.0


def seconds_to(target, points):
    """Time at which a line through points (error, seconds), both axes logarithmic, has an error. It is the
    first point's if that errs by less, and NaN if all err by more."""
    if points[0][0] <= target:
        return points[0][1]
    for (e0, t0), (e1, t1) in zip(points, points[1:]):
        if e0 >= target > e1:
            return t0 * (t1 / t0) ** (math.log(target / e0) / math.log(e1 / e0))
    return math.nan


def parse():
    command = parser(__doc__)
    command.add_argument("input", nargs="?", type=Path, default=LEAVES500 / "leaves500.glb")
    command.add_argument("--sunfleck", type=Path, default=Path("target/release/sunfleck"))
    command.add_argument("--reference", type=Path, default=LEAVES500 / "box.exr")
    command.add_argument(
        "--reference-noise", type=float, default=0.00143, help="root mean square of its standard error"
    )
    command.add_argument("--targets", type=floats, default=[0.02, 0.01])
    command.add_argument("--samples", type=ints, default=[2, 3, 4, 8], help="of sunfleck")
    command.add_argument("--cycles-samples", type=ints, default=[32, 64, 128, 256])
    command.add_argument("--rounds", type=int, default=3)
    command.add_argument("--threads", type=int, default=os.cpu_count(), help="of both (all processors)")
    command.add_argument("--sunfleck-threads", type=int, help="of sunfleck, if it shall have others")
    command.add_argument(
        "--suns", type=lambda text: text.split(","), default=[OWN_SUN], help="own, degrees of a disc, ahead"
    )
    one = command.add_argument_group("a process for one picture by Cycles, which this program starts itself")
    one.add_argument("--picture", type=Path, help=argparse.SUPPRESS)
    one.add_argument("--size", help=argparse.SUPPRESS)
    one.add_argument("--seed", type=int, help=argparse.SUPPRESS)
    return command.parse_args()


class View:
    """Scene under one sun: compares pictures with its reference, and prints them."""

    def __init__(self, sun, source, reference, reference_noise, folder):
        self.sun, self.source, self.folder = sun, source, folder
        self.reference, self.reference_noise = reference, reference_noise

    @classmethod
    def under(cls, sun, own, ours):
        """View under another sun than that of `own`."""
        target, (height, width) = own.folder / "reference.exr", own.reference.shape[:2]
        source = with_sun(own.source, sun, own.folder / f"{sun}.glb")
        found = []
        for seed in REFERENCE_SEEDS:
            ours.cpu_s(source, f"{width}x{height}", REFERENCE_SAMPLES, seed, target)
            found.append(colors(decode(target)))
        reference, variance = truth_of(numpy.stack(found))
        return cls(sun, source, reference, variance**0.5, own.folder)

    def point(self, renderer, samples, seed):
        """Error, seconds of the whole process, and seconds without writing."""
        target, (height, width) = self.folder / f"{renderer.name}.exr", self.reference.shape[:2]
        seconds, writing_s = renderer.cpu_s(self.source, f"{width}x{height}", samples, seed, target)
        square = numpy.mean((colors(decode(target)) - self.reference) ** 2)
        error = max(square - self.reference_noise**2, 0.0) ** 0.5
        print(f"{self.sun:6} {renderer.name:9} {samples:8} {seed:5} {error:9.5f} {seconds:9.3f}", flush=True)
        return error, seconds, seconds - writing_s

    def empty(self, renderer, seed):
        """Seconds of a process that renders almost nothing."""
        seconds, _ = renderer.cpu_s(self.source, EMPTY_SIZE, 1, seed, self.folder / f"{renderer.name}.exr")
        return seconds

    def round(self, ours, theirs, number):
        """Errors and seconds of both, for whole processes and for rendering."""
        points, mine, empty = [], {samples: [] for samples in ours.samples}, []
        for turn, samples in enumerate(theirs.samples):
            points.append(self.point(theirs, samples, number))
            seed = number * len(theirs.samples) + turn
            empty.append(self.empty(ours, seed))
            for own in ours.samples:
                mine[own].append(self.point(ours, own, seed))
        sides = (
            ([mean(found) for found in mine.values()], statistics.fmean(empty)),
            (points, self.empty(theirs, number)),
        )
        print(
            "start, reading and building: " + ", ".join(f"{empty:.3f} CPU s" for _, empty in sides),
            flush=True,
        )
        return {
            "whole": [[(error, whole) for error, whole, _ in points] for points, _ in sides],
            "render": [[(error, unwritten - empty) for error, _, unwritten in points] for points, empty in sides],
        }


def mean(found):
    """Mean of points with one number of samples; errors are averaged as squares."""
    errors, *seconds = zip(*found)
    return statistics.fmean(error * error for error in errors) ** 0.5, *map(statistics.fmean, seconds)


def renderers(arguments):
    """Both renderers."""
    own_threads = arguments.sunfleck_threads or arguments.threads

    def by_sunfleck(source, size, samples, seed, target):
        given = ["--size", size, "--samples", samples, "--seed", seed, "--threads", own_threads, "--passes", "none", "--bounces", "0"]
        given += ["--stats", target.with_suffix(".json"), "--out", target]
        return [arguments.sunfleck, "render", source, *given]

    def by_cycles(source, size, samples, seed, target):
        given = ["--size", size, "--cycles-samples", samples, "--seed", seed, "--threads", arguments.threads]
        return [sys.executable, __file__, source, *given, "--picture", target]

    return Renderer("sunfleck", arguments.samples, by_sunfleck), Renderer(
        "Cycles", arguments.cycles_samples, by_cycles
    )


def compare(arguments, folder):
    """Prints the results of both, in turns."""
    ours, theirs = renderers(arguments)
    own = View(OWN_SUN, arguments.input, colors(decode(arguments.reference)), arguments.reference_noise, folder)
    views = [own if sun == OWN_SUN else View.under(sun, own, ours) for sun in arguments.suns]
    height, width = own.reference.shape[:2]
    print(
        f"{arguments.input.name}, {width} x {height}, threads: {arguments.threads}, of sunfleck: "
        f"{arguments.sunfleck_threads or arguments.threads}"
    )
    print(f"{'sun':6} {'':9} {'samples':>8} {'seed':>5} {'RMSE':>9} {'CPU s':>9}")
    found = {}
    for number in range(1, arguments.rounds + 1):
        for view in views:
            for kind, sides in view.round(ours, theirs, number).items():
                for target in arguments.targets:
                    found.setdefault((view.sun, target, kind), []).append(
                        [seconds_to(target, points) for points in sides]
                    )
    for (sun, target, kind), pairs in found.items():
        mine_s, other_s = (statistics.median(side) for side in zip(*pairs))
        print(
            f"{sun:6} to RMSE {target}, {kind:6}: sunfleck {mine_s:7.3f} CPU s, Cycles {other_s:7.2f}, "
            f"ratio {told(pairs)}"
        )
        if sun != OWN_SUN and OWN_SUN in arguments.suns:
            own_pairs = [(mine, other) for (mine, _), (_, other) in zip(pairs, found[OWN_SUN, target, kind])]
            print(f"{'':6} by what Cycles takes under the scene's own sun: {told(own_pairs)}")


def told(pairs):
    """Ratios of the second to the first: median, minimum and maximum."""
    ratios = sorted(other / mine for mine, other in pairs)
    return f"{statistics.median(ratios):5.0f} ({ratios[0]:.0f} to {ratios[-1]:.0f})"


def main():
    arguments = parse()
    if arguments.picture is not None:
        return picture_by_cycles(arguments)
    with tempfile.TemporaryDirectory() as folder:
        compare(arguments, Path(folder))
    return 0


if __name__ == "__main__":
    sys.exit(main())
