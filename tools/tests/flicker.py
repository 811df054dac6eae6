"""What changes from frame to frame where nothing should: noise alone, or more? And do leaves fall as leaves
do, each in its own way?

    SUNFLECK=../target/release/sunfleck python -m tests.flicker [FOLDER] [--bounces 0]       (in tools/)

Renders the ten seconds of `falling_leaves_long` small, by a camera that stands still, with two seeds. It goes
in pieces. What is there and whole is kept, so the same command goes on after an interruption. It prints the
figures that docs/validate.md has. With `--bounces 0` it does so without indirect light, for comparison, and in
a folder of its own. Exits with 1 where a leaf is not where it can be.

Of another sequence, which has a camera `still` as well, `--sequence morning` asks the first question alone.
"""

import argparse
import os
import subprocess
import sys
from pathlib import Path

import numpy as np

from sunfleck_tools.exr.decode import decode
from sunfleck_tools.gltf.load import load
from sunfleck_tools.gltf.meshes import Meshes
from sunfleck_tools.gltf.scene import Gltf

from .command import NO_PROGRAM, PROGRAM, SEQUENCES

SEQUENCE = "falling_leaves_long"
FALLS = ("at hand.", "overhead.", "from ")
GROUND = ("clearing", "ground left", "ground right", "ground beyond")
FRAMES, SEEDS = 240, (1, 2)
ALIKE_FRAMES = 36
"""Leaves that move alike for so long would be seen to move in step."""
FASTEST_M_PER_S, FASTEST_RAD_PER_S = 8.0, 150.0
"""Above what a leaf reaches in this wind, times `speed`; for its turns see docs/decisions/falling.md."""
SUNK_M = 0.01
"""Keys are within 1 % of a leaf's length of where it was found to be, a third of that on the ground."""


def render(folder: Path, seed: int, arguments: argparse.Namespace) -> None:
    """All frames of a seed that are not there yet."""
    command = [
        os.path.abspath(str(PROGRAM)), "render", str(SEQUENCES / f"{arguments.sequence}.ron"), "--camera", "still", "--size", arguments.size,
        "--seed", str(seed), "--frames", f"{arguments.frames[0]}-{arguments.frames[1]}", "--bounces", arguments.bounces,
        "--passes", "depth,motion", "--skip", "valid", "--progress", "none", "--out", str(folder / f"{seed}.####.exr"),
    ]  # fmt: skip
    subprocess.run(command, check=True)


def near(mask: np.ndarray) -> np.ndarray:
    """True where something true is two pixels away at most."""
    rows, columns = mask.shape
    wide = np.pad(mask, 2)
    return np.logical_or.reduce([wide[y : y + rows, x : x + columns] for y in range(5) for x in range(5)])


class Frames:
    """Luminance of both seeds, and where something moves, frame by frame."""

    def __init__(self, folder: Path):
        self.folder = folder

    def __getitem__(self, number: int) -> tuple[list[np.ndarray], np.ndarray]:
        lights, moves = [], None
        for seed in SEEDS:
            channels = {
                name: np.asarray(pixels, np.float64)
                for name, pixels in decode(self.folder / f"{seed}.{number:04d}.exr").items()
            }
            lights.append(0.2126 * channels["R"] + 0.7152 * channels["G"] + 0.0722 * channels["B"])
            moving = sum(abs(channels[f"Vector.{part}"]) for part in "XYZW") > 1e-4
            moves = moving if moves is None else moves | moving
        return lights, near(moves)


def report_flicker(folder: Path, first_frame: int, last_frame: int) -> None:
    """Second differences in time where no surface moves, against what two seeds differ by."""
    frames = Frames(folder)
    window = [frames[first_frame], frames[first_frame + 1]]
    ratios, changes, commons, means, shares = [], [], [], [], []
    for number in range(first_frame + 2, last_frame + 1):
        window.append(frames[number])
        still = ~(window[0][1] | window[1][1] | window[2][1])
        light = np.mean([lights for lights, _ in window], axis=(0, 1))
        light = np.maximum(light, 0.1 * light.mean())[still]  # As a tolerance is meant.
        first, second = (
            (window[0][0][s] - 2.0 * window[1][0][s] + window[2][0][s])[still] / light for s in (0, 1)
        )
        # A frame errs by as much as half the squared difference of its seeds says; errors of frames are
        # independent: 1 + 4 + 1.
        error = np.mean([0.5 * np.mean(((a - b)[still] / light) ** 2) for (a, b), _ in window])
        shares.append(still.mean())
        ratios.append(np.sqrt(0.5 * np.mean(first**2 + second**2) / (6.0 * error)))
        # What both seeds have in common is no noise: shadows that pass, or flicker.
        common = np.mean(first * second)
        changes.append(common / np.mean(0.5 * (first**2 + second**2)))
        commons.append(np.sqrt(max(common, 0.0)))
        means.append(0.5 * abs(np.mean(first) + np.mean(second)))
        window.pop(0)
    count = last_frame - first_frame + 1
    print(f"{count} frames; nothing moves in {100 * np.mean(shares):.0f} % of the pixels")
    worst, most = (first_frame + 1 + int(np.argmax(values)) for values in (ratios, changes))
    print(
        f"second difference of still pixels over their sampling error: median {np.median(ratios):.3f}, "
        f"largest {max(ratios):.3f} (frame {worst})"
    )
    print(
        f"of its square common to both seeds: median {100 * np.median(changes):.1f} %, largest "
        f"{100 * max(changes):.1f} % (frame {most})"
    )
    print(
        f"that is, of their light: median {100 * np.median(commons):.2f} %, largest {100 * max(commons):.2f} % "
        f"(frame {first_frame + 1 + int(np.argmax(commons))})"
    )
    print(
        f"second difference of the still pixels' mean light: median {np.median(means):.1e}, largest "
        f"{max(means):.1e} of it"
    )


def ground_heights(scene: Gltf, meshes: Meshes) -> dict[tuple[int, int], list[np.ndarray]]:
    """Triangles of the ground by the square of 3 m that they touch."""
    squares: dict[tuple[int, int], list[np.ndarray]] = {}
    for node in scene.nodes:
        if node.name not in GROUND:
            continue
        world = node.world_from_node(np.zeros(1))[0]
        for primitive in meshes.of(node)[1].primitives:
            corners = primitive.positions @ world[:3, :3].T + world[:3, 3]
            for triangle in corners[primitive.triangles]:
                low, high = (
                    np.floor((triangle.min(axis=0) + 1e-6) / 3.0),
                    np.floor((triangle.max(axis=0) - 1e-6) / 3.0),
                )
                for x in range(int(low[0]), int(high[0]) + 1):
                    for z in range(int(low[2]), int(high[2]) + 1):
                        squares.setdefault((x, z), []).append(triangle)
    return squares


def height(squares: dict[tuple[int, int], list[np.ndarray]], points: np.ndarray) -> np.ndarray:
    """How far points are above the ground; infinite where there is none."""
    found = np.full(len(points), np.inf)
    keys = np.floor(points[:, [0, 2]] / 3.0).astype(int)
    for key in map(tuple, np.unique(keys, axis=0)):
        here = np.flatnonzero((keys == key).all(axis=1))
        for a, b, c in squares.get(key, ()):
            flat = np.array([b - a, c - a])[:, [0, 2]].T
            shares = np.linalg.solve(flat, (points[here] - a)[:, [0, 2]].T)
            inside = (shares >= -1e-9).all(axis=0) & (shares.sum(axis=0) <= 1.0 + 1e-9)
            ground = a[1] + shares[0] * (b - a)[1] + shares[1] * (c - a)[1]
            found[here[inside]] = (points[here, 1] - ground)[inside]
    return found


def report_leaves() -> bool:
    """Where leaves are at every frame; false if one jumps, or is in the ground."""
    scene = load(SEQUENCES / f"{SEQUENCE}.ron", PROGRAM)
    meshes = Meshes(scene, [])
    leaves = [
        node for node in scene.nodes if node.name.startswith(FALLS) and node.source.member("mesh") is not None
    ]
    times = np.arange(FRAMES + 2) / 24.0
    worlds = np.array([leaf.world_from_node(times) for leaf in leaves])
    sizes = np.linalg.norm(worlds[:, :1, :3, 0], axis=-1)[..., None, None]
    places, turns = worlds[..., :3, 3], worlds[..., :3, :3] / sizes
    hidden = sum(
        "visible" in leaf.extras.raw or leaf.source.member("extensions") is not None for leaf in leaves
    )
    steps = np.diff(places, axis=1)
    speeds = np.linalg.norm(steps, axis=-1) * 24.0
    accelerations = np.linalg.norm(np.diff(steps, axis=1), axis=-1) * 24.0**2
    between = np.einsum("ltij,ltik->ltjk", turns[:, :-1], turns[:, 1:])
    angles = np.arccos(np.clip(0.5 * (np.trace(between, axis1=2, axis2=3) - 1.0), -1.0, 1.0)) * 24.0
    flying = speeds > 0.02
    print(
        f"{len(leaves)} leaves that fall, {flying.sum(axis=0).mean():.0f} of them in the air at a time; "
        f"{hidden} can be hidden"
    )
    print(
        f"fastest {speeds.max():.2f} m/s, change of speed at most {accelerations.max():.0f} m/s2, fastest "
        f"turn {angles.max():.0f} rad/s"
    )

    squares, lowest, who = ground_heights(scene, meshes), np.inf, ""
    for number, leaf in enumerate(leaves):
        points = np.concatenate([primitive.positions for primitive in meshes.of(leaf)[1].primitives])
        moved = np.concatenate([[True], flying[number]]) & (places[number, :, 1] < 3.5)
        corners = (
            np.einsum("tij,pj->tpi", worlds[number, moved, :3, :3], points)
            + worlds[number, moved, None, :3, 3]
        )
        above = height(squares, corners.reshape(-1, 3))
        if len(above) and above.min() < lowest:
            lowest, who = above.min(), leaf.name
    print(f"lowest point of a leaf that moves, over the ground: {1e3 * lowest:.1f} mm (`{who}`)")

    together, apart = most_alike(steps, angles, flying, 0), most_alike(steps, angles, flying, ALIKE_FRAMES)
    print(
        f"the two most alike for {ALIKE_FRAMES} frames: {100 * together:.0f} % of their spread apart; at "
        f"different times: {100 * apart:.0f} %"
    )
    return bool(
        hidden == 0
        and speeds.max() < FASTEST_M_PER_S
        and angles.max() < FASTEST_RAD_PER_S
        and lowest > -SUNK_M
    )


def most_alike(steps: np.ndarray, angles: np.ndarray, flying: np.ndarray, later: int) -> float:
    """By how much the descent and the turning of two leaves differ at least, relative to how much both vary,
    whichever way they head; of two leaves at the same time, or of one and another `later` frames later."""
    least = np.inf
    for first in range(0, FRAMES - ALIKE_FRAMES - later, ALIKE_FRAMES // 2):
        windows = slice(first, first + ALIKE_FRAMES), slice(first + later, first + later + ALIKE_FRAMES)
        rows = [np.flatnonzero(flying[:, window].all(axis=1)) for window in windows]
        differences = np.zeros((len(rows[0]), len(rows[1])))
        for values in (24.0 * steps[..., 1], angles):
            ours, theirs = (values[row][:, window] for row, window in zip(rows, windows, strict=True))
            spread = np.sqrt(np.mean((ours - ours.mean(axis=1, keepdims=True)) ** 2))
            squares = (ours**2).sum(axis=1)[:, None] + (theirs**2).sum(axis=1)[None] - 2.0 * ours @ theirs.T
            differences = np.maximum(differences, np.sqrt(np.maximum(squares, 0.0) / ALIKE_FRAMES) / spread)
        differences[rows[0][:, None] == rows[1][None]] = np.inf
        least = min(least, float(differences.min()))
    return least


def main() -> int:
    """Prints all of it."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "folder",
        type=Path,
        nargs="?",
        help="where the frames go (default: ../out/flicker, with --bounces 0 ../out/flicker.0, of another "
        "sequence ../out/flicker.NAME)",
    )
    parser.add_argument("--sequence", default=SEQUENCE, help="whose frames (default: %(default)s)")
    parser.add_argument("--bounces", default="all", help="as render has it (default: %(default)s)")
    parser.add_argument("--size", default="240x135", help="of the picture (default: %(default)s)")
    parser.add_argument(
        "--frames", type=int, nargs=2, default=(1, FRAMES), metavar=("FIRST", "LAST"), help="only these, three at least"
    )
    arguments = parser.parse_args()
    if PROGRAM is None:
        print(f"error: {NO_PROGRAM}", file=sys.stderr)
        return 2
    good = arguments.sequence != SEQUENCE or report_leaves()
    parts = [arguments.sequence] * (arguments.sequence != SEQUENCE) + [arguments.bounces] * (arguments.bounces != "all")
    folder = arguments.folder or Path("../out", ".".join(["flicker", *parts]))
    folder.mkdir(parents=True, exist_ok=True)
    for seed in SEEDS:
        render(folder, seed, arguments)
    report_flicker(folder, *arguments.frames)
    return int(not good)


if __name__ == "__main__":
    sys.exit(main())
