r"""Light of all orders in scenes where it is hard to find, beside random walks, and beside Cycles.

    cd tools && SUNFLECK=../target/release/sunfleck python peers/light_everywhere.py "room" "mist 0.5" --tolerance 0.02

A line a scene of `light_scenes.py` has

- ratios of means, by channel;
- by what blocks of 10x10 pixels differ, root mean square by the picture's mean, without the noise of walks;
- the worst block, by its own light;
- the error that the frame tells;
- CPU seconds of the whole process.

`--changes` renders what must not change a scene, beside that scene itself. With `--cycles`, by a Python with bpy,
Cycles renders too until its blocks are as good, and its CPU seconds follow.
"""

import tempfile
from pathlib import Path

import numpy as np
from common import blocks, error, parser, picture, program, truth_of
from light_scenes import CHANGES, SCENES, write

# Of a picture's mean: darker blocks have no error of their own.
LEAST_LIGHT = 0.05
MOST_CYCLES_SAMPLES = 16384


def truth(scene: Path, size: str, samples: int) -> tuple[np.ndarray, float]:
    """Blocks by random walks, and the mean variance of their noise; cached beside the scene."""
    kept = scene.with_name(f"{scene.stem}.{size}.{samples}.npy")
    if not kept.exists():
        walks = ["--volume", "paths", "--samples", str(samples), "--seed"]
        np.save(kept, np.stack([blocks(picture(scene, size, [*walks, str(seed)])[0]) for seed in range(4)]))
    return truth_of(np.load(kept))


def beside(ours: np.ndarray, theirs: np.ndarray, noise: float) -> tuple[str, float]:
    """Differences of blocks as text; and their root mean square relative to the mean."""
    difference, own = ours - theirs, theirs.mean(-1)
    found = error(ours, theirs, noise)
    worst = np.where(own > LEAST_LIGHT * own.mean(), difference.mean(-1) / np.maximum(own, 1e-30), 0.0)
    means = ours.mean((0, 1)) / theirs.mean((0, 1))
    worst = worst.flat[np.abs(worst).argmax()]
    return f"{' '.join(f'{mean:.3f}' for mean in means)}, blocks {100 * found:.2f} %, worst {100 * worst:+.1f} %", found


def cycles_seconds(scene: Path, size: str, theirs: np.ndarray, noise: float, aim: float) -> str:
    """CPU seconds of Cycles for blocks with an equal error."""
    from sunfleck_tools.commands.peers import bounces
    from sunfleck_tools.peers import cycles
    from sunfleck_tools.peers.scene import read_scene

    read = read_scene(scene, 1, program())
    read.size, read.bounces = tuple(map(int, size.split("x"))), bounces("all")
    render, samples = cycles.prepare(read), 16
    while samples <= MOST_CYCLES_SAMPLES:
        found, seconds = render(samples, 1)
        words, reached = beside(blocks(found), theirs, noise)
        if reached <= aim:
            return f"Cycles {seconds:.1f} CPU s ({samples} samples)"
        samples *= 4
    return f"Cycles never ({words} in {seconds:.0f} CPU s)"


def main() -> None:
    """Prints a line for each scene."""
    command = parser(__doc__)
    names = "of scenes, or of changes (all of them): " + ", ".join([*SCENES, *CHANGES])
    command.add_argument("names", nargs="*", help=names)
    command.add_argument("--changes", action="store_true", help="what must not matter, instead of scenes")
    command.add_argument("--tolerance", default="0.02")
    command.add_argument("--size", default="160x90")
    command.add_argument("--walks", type=int, default=64, help="samples a pixel of walks, four times")
    command.add_argument("--cycles", action="store_true", help="the same by Cycles, to as little an error")
    command.add_argument("--kept", type=Path, help="a folder that keeps scenes, and what walks found")
    arguments = command.parse_args()
    if unknown := [name for name in arguments.names if name not in {*SCENES, *CHANGES}]:
        command.error(f"there is no scene {', '.join(unknown)}: see --help for their names")
    how = ["--tolerance", arguments.tolerance, "--samples", "1024"]
    with tempfile.TemporaryDirectory() as folder:
        kept = arguments.kept or Path(folder)
        kept.mkdir(parents=True, exist_ok=True)
        for name in arguments.names or (CHANGES if arguments.changes else SCENES):
            scene = write(name, kept)
            ours, seconds, stats = picture(scene, arguments.size, how)
            if name in CHANGES:
                theirs, noise = blocks(picture(write(CHANGES[name][0], kept), arguments.size, how)[0]), 0.0
            else:
                theirs, noise = truth(scene, arguments.size, arguments.walks)
            words, reached = beside(blocks(ours), theirs, noise)
            told = f", told {100 * stats['grid_error']:.1f} %" if stats["grid_error"] is not None else ""
            peer = ""
            if arguments.cycles and name not in CHANGES:
                peer = ", " + cycles_seconds(scene, arguments.size, theirs, noise, reached)
            print(f"{name:16} {words}{told}, {seconds:.1f} CPU s{peer}", flush=True)


if __name__ == "__main__":
    main()
