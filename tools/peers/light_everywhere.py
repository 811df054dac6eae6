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

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from all_orders import blocks
from light_scenes import CHANGES, SCENES, write

from sunfleck_tools.exr.decode import decode

# Of a picture's mean: darker blocks have no error of their own.
LEAST_LIGHT = 0.05
MOST_CYCLES_SAMPLES = 16384


def picture(scene: Path, size: str, flags: list[str]) -> tuple[np.ndarray, float, dict]:
    """The beauty, height x width x 3, W m^-2 sr^-1; CPU seconds of the process; what `--stats` says."""
    with tempfile.TemporaryDirectory() as folder:
        out, stats = Path(folder, "picture.exr"), Path(folder, "stats")
        command = [os.environ.get("SUNFLECK", "sunfleck"), "render", str(scene), "--frames", "1", "--size", size]
        command += ["--progress", "none", "--stats", str(stats), "--out", str(out), *flags]
        with subprocess.Popen(command) as process:
            _, status, used = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode:
            sys.exit(f"{scene.stem}: exit code {process.returncode}")
        channels = decode(out)
        told = next(line for line in map(json.loads, stats.read_text().splitlines()) if "frame" in line)
    return np.stack([channels[color] for color in "RGB"], -1).astype(float), used.ru_utime + used.ru_stime, told


def truth(scene: Path, size: str, samples: int) -> tuple[np.ndarray, float]:
    """Blocks by random walks, and the mean variance that noise gives them; kept beside the scene."""
    kept = scene.with_name(f"{scene.stem}.{size}.{samples}.npy")
    if not kept.exists():
        walks = ["--volume", "paths", "--samples", str(samples), "--seed"]
        np.save(kept, np.stack([blocks(picture(scene, size, [*walks, str(seed)])[0]) for seed in range(4)]))
    theirs = np.load(kept)
    return theirs.mean(axis=0), float(theirs.var(axis=0, ddof=1).mean() / len(theirs))


def beside(ours: np.ndarray, theirs: np.ndarray, noise: float) -> tuple[str, float]:
    """How blocks differ, in words; and the root mean square as a share of the mean."""
    difference, own = ours - theirs, theirs.mean(-1)
    error = np.sqrt(max((difference**2).mean() - noise, 0.0)) / theirs.mean()
    worst = np.where(own > LEAST_LIGHT * own.mean(), difference.mean(-1) / np.maximum(own, 1e-30), 0.0)
    means = ours.mean((0, 1)) / theirs.mean((0, 1))
    worst = worst.flat[np.abs(worst).argmax()]
    return f"{' '.join(f'{mean:.3f}' for mean in means)}, blocks {100 * error:.2f} %, worst {100 * worst:+.1f} %", error


def cycles_seconds(scene: Path, size: str, theirs: np.ndarray, noise: float, error: float) -> str:
    """CPU seconds of Cycles to blocks that are as good."""
    from sunfleck_tools.commands.peers import bounces
    from sunfleck_tools.peers import cycles
    from sunfleck_tools.peers.scene import read_scene

    read = read_scene(scene, 1, os.environ.get("SUNFLECK", "sunfleck"))
    read.size, read.bounces = tuple(map(int, size.split("x"))), bounces("all")
    render, samples = cycles.prepare(read), 16
    while samples <= MOST_CYCLES_SAMPLES:
        found, seconds = render(samples, 1)
        words, reached = beside(blocks(found), theirs, noise)
        if reached <= error:
            return f"Cycles {seconds:.1f} CPU s ({samples} samples)"
        samples *= 4
    return f"Cycles never ({words} in {seconds:.0f} CPU s)"


def main() -> None:
    """Prints a line for each scene."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("names", nargs="*", help="of scenes, or of changes (all of them)")
    parser.add_argument("--changes", action="store_true", help="what must not matter, instead of scenes")
    parser.add_argument("--tolerance", default="0.02")
    parser.add_argument("--size", default="160x90")
    parser.add_argument("--walks", type=int, default=64, help="samples a pixel of walks, four times")
    parser.add_argument("--cycles", action="store_true", help="the same by Cycles, to as little an error")
    parser.add_argument("--kept", type=Path, help="a folder that keeps scenes, and what walks found")
    arguments = parser.parse_args()
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
            words, error = beside(blocks(ours), theirs, noise)
            told = f", told {100 * stats['grid_error']:.1f} %" if stats["grid_error"] is not None else ""
            peer = ""
            if arguments.cycles and name not in CHANGES:
                peer = ", " + cycles_seconds(scene, arguments.size, theirs, noise, error)
            print(f"{name:16} {words}{told}, {seconds:.1f} CPU s{peer}", flush=True)


if __name__ == "__main__":
    main()
