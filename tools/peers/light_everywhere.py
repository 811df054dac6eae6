r"""Light of all orders beside random walks or Mitsuba, and beside Cycles: of scenes where it is hard to find, or of files.

    cd tools && SUNFLECK=../target/release/sunfleck python peers/light_everywhere.py "room" "mist 0.5" --tolerance 0.02
    cd tools && SUNFLECK=../target/release/sunfleck python peers/light_everywhere.py ../sequences/title.ron --frame 24 --passes

A line a scene, of `light_scenes.py` where it has that name, has

- ratios of means, by channel; with `--passes` also of indirect light alone: what surfaces show, and what fog scatters;
- by what blocks of 10x10 pixels differ, root mean square by the picture's mean, without the truth's own noise;
- the worst block, by its own light;
- the error that the frame tells;
- CPU seconds of the whole process.

`--changes` renders what must not change a scene, beside that scene itself. With `--cycles`, by a Python with bpy,
Cycles renders too until its blocks are as good, and its CPU seconds follow. `--truth mitsuba` takes that for walks.
"""

import argparse
import tempfile
from pathlib import Path

import numpy as np
from common import blocks, colors, error, pair, parser, program, rendered, truth_of
from light_scenes import CHANGES, SCENES, write

from sunfleck_tools.commands.peers import bounces
from sunfleck_tools.peers.scene import PeerScene, read_scene

# Of a picture's mean: darker blocks have no error of their own.
LEAST_LIGHT = 0.05
MOST_CYCLES_SAMPLES = 16384
PASSES = {"beauty": "", "surfaces": "indirect.", "fog": "indirect_shafts."}


class Look:
    """How scenes are rendered."""

    def __init__(self, given: argparse.Namespace):
        self.given = given
        self.passes = PASSES if given.passes else {"beauty": ""}
        self.how = ["--samples", str(given.samples)] if given.samples else ["--tolerance", given.tolerance, "--samples", "1024"]

    def ours(self, scene: Path, flags: list[str]) -> tuple[dict[str, np.ndarray], float, dict]:
        """Passes, height x width x 3, CPU seconds, and the frame's `--stats`."""
        extra = ["--passes", "indirect,indirect-shafts"] if self.given.passes else []
        channels, seconds, told = rendered(scene, self.given.size, ["--bounces", self.given.bounces, *extra, *flags], self.given.frame)
        return {name: colors(channels, prefix) for name, prefix in self.passes.items()}, seconds, told

    def truths(self, scene: Path, kept: Path) -> dict[str, np.ndarray]:
        """Independent pictures of each pass; those by walks are kept."""
        given = self.given
        if given.truth == "mitsuba":
            from sunfleck_tools.peers import mitsuba

            render = mitsuba.prepare(self.read(scene), given.variant)
            return {"beauty": np.stack([render(given.walks, seed)[0] for seed in range(given.pictures)])}
        told = (given.frame, given.size, given.bounces, given.walks, given.pictures, *self.passes)
        file = kept / f"{scene.stem}.{'.'.join(map(str, told))}.npz"
        if not file.exists():
            walks = ["--volume", "paths", "--samples", str(given.walks), "--seed"]
            found = [self.ours(scene, [*walks, str(seed)])[0] for seed in range(given.pictures)]
            np.savez(file, **{name: np.stack([one[name] for one in found]) for name in self.passes})
        return dict(np.load(file))

    def read(self, scene: Path) -> PeerScene:
        """For other renderers."""
        read = read_scene(scene, self.given.frame, program())
        read.size, read.bounces = pair(self.given.size), bounces(self.given.bounces)
        return read


def ratios(ours: np.ndarray, theirs: np.ndarray) -> str:
    """Of means of blocks, by channel."""
    return " ".join(f"{ratio:.4f}" for ratio in blocks(ours).mean((0, 1)) / blocks(theirs).mean((0, 1)))


def beside(ours: np.ndarray, theirs: np.ndarray, noise: float) -> tuple[str, float]:
    """Differences of blocks as text; and their root mean square relative to the mean."""
    difference, own = ours - theirs, theirs.mean(-1)
    found = error(ours, theirs, noise)
    worst = np.where(own > LEAST_LIGHT * own.mean(), difference.mean(-1) / np.maximum(own, 1e-30), 0.0)
    worst = worst.flat[np.abs(worst).argmax()]
    return f"blocks {100 * found:.2f} %, worst {100 * worst:+.1f} %", found


def cycles_seconds(read: PeerScene, theirs: np.ndarray, noise: float, aim: float) -> str:
    """CPU seconds of Cycles for blocks with an equal error."""
    from sunfleck_tools.peers import cycles

    render, samples = cycles.prepare(read), 16
    while samples <= MOST_CYCLES_SAMPLES:
        found, seconds = render(samples, 1)
        words, reached = beside(blocks(found), theirs, noise)
        if reached <= aim:
            return f"Cycles {seconds:.1f} CPU s ({samples} samples)"
        samples *= 4
    return f"Cycles never ({words} in {seconds:.0f} CPU s)"


def line(look: Look, name: str, kept: Path) -> str:
    """A scene's figures."""
    scene = write(name, kept) if name in {*SCENES, *CHANGES} else Path(name)
    ours, seconds, stats = look.ours(scene, look.how)
    if name in CHANGES:
        theirs, _, _ = look.ours(write(CHANGES[name][0], kept), look.how)
        mean, noise = blocks(theirs["beauty"]), 0.0
    else:
        truths = look.truths(scene, kept)
        theirs = {each: pictures.mean(0) for each, pictures in truths.items()}
        mean, noise = truth_of(np.stack([blocks(picture) for picture in truths["beauty"]]))
    words, reached = beside(blocks(ours["beauty"]), mean, noise)
    means = ", ".join(f"{'mean ratio' if each == 'beauty' else each} {ratios(ours[each], theirs[each])}" for each in theirs)
    told = f", told {100 * stats['grid_error']:.1f} %" if stats["grid_error"] is not None else ""
    peer = ""
    if look.given.cycles and name not in CHANGES:
        peer = ", " + cycles_seconds(look.read(scene), mean, noise, reached)
    return f"{scene.stem.replace('_', ' '):16} {means}, {words}{told}, {seconds:.1f} CPU s{peer}"


def main() -> None:
    """Prints a line for each scene."""
    command = parser(__doc__)
    names = "files, or names of scenes or of changes (all of them): " + ", ".join([*SCENES, *CHANGES])
    command.add_argument("names", nargs="*", help=names)
    command.add_argument("--changes", action="store_true", help="what must not matter, instead of scenes")
    command.add_argument("--frame", type=int, default=1)
    command.add_argument("--size", default="160x90")
    command.add_argument("--bounces", default="all")
    command.add_argument("--tolerance", default="0.02")
    command.add_argument("--samples", type=int, help="a pixel, instead of a tolerance")
    command.add_argument("--passes", action="store_true", help="indirect light alone, too, by walks")
    command.add_argument("--truth", choices=["walks", "mitsuba"], default="walks")
    command.add_argument("--walks", type=int, default=64, help="samples a pixel of a picture of the truth")
    command.add_argument("--pictures", type=int, default=4, help="of the truth, two at least, whose spread is its noise")
    command.add_argument("--variant", default="scalar_rgb", help="llvm_ad_rgb where Mitsuba finds an LLVM that it likes")
    command.add_argument("--cycles", action="store_true", help="the same by Cycles, to as little an error")
    command.add_argument("--kept", type=Path, help="a folder that keeps scenes, and what walks found")
    arguments = command.parse_args()
    if unknown := [name for name in arguments.names if name not in {*SCENES, *CHANGES} and not Path(name).is_file()]:
        command.error(f"there is no scene {', '.join(unknown)}: see --help for their names")
    with tempfile.TemporaryDirectory() as folder:
        kept = arguments.kept or Path(folder)
        kept.mkdir(parents=True, exist_ok=True)
        for name in arguments.names or (CHANGES if arguments.changes else SCENES):
            print(line(Look(arguments), name, kept), flush=True)


if __name__ == "__main__":
    main()
