"""Renders good frames of different sequences, and asks `validate` what it finds: nothing, if it is right.

    SUNFLECK=../target/release/sunfleck python -m tests.good_frames [PART OF A NAME ...]        (in tools/)

Prints what was found in each run; exits with 1 if anything is found.
"""

import os
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

from sunfleck_tools import Options, validate

from .command import NO_PROGRAM, PROGRAM

ROOT = Path(__file__).parents[2]
SMALL = ("--size", "10%")
WOOD = ("sequences/falling_leaves.ron", "--size", "15%")
BLENDER = "tests/data/blender"
RENDERS = {
    "falling_leaves": (*WOOD, "--samples", "4"),
    "falling_leaves, motion blur, another seed": (*WOOD, "--samples", "8", "--shutter", "0.5", "--seed", "7"),
    "falling_leaves, a part": (*WOOD, "--samples", "2", "--crop", "10,10,86,50"),
    "first_leaf, motion blur": ("sequences/first_leaf.ron", "--samples", "4", "--shutter", "0.5"),
    "first_leaf, 2 samples, another seed": ("sequences/first_leaf.ron", "--samples", "2", "--seed", "7"),
    "first_leaf, cropped, ray by ray": (
        "sequences/first_leaf.ron", "--samples", "2", "--volume", "segments", "--crop", "4,2,27,16",
    ),
    "i_conventions.glb": (f"{BLENDER}/i_conventions.glb", "--samples", "4"),
    "a_leaves40_scene.glb": (f"{BLENDER}/a_leaves40_scene.glb", "--samples", "8"),
    "a_leaves40_scene.glb, motion "
    "blur": (f"{BLENDER}/a_leaves40_scene.glb", "--samples", "16", "--shutter", "0.5"),
    "e_inst_default.glb": (f"{BLENDER}/e_inst_default.glb", "--samples", "4"),
    "h_lights_pointer_scene.glb, which fades to "
    "black": (f"{BLENDER}/h_lights_pointer_scene.glb", "--samples", "4"),
}  # fmt: skip
"""Small pictures of few samples: the noisier, the harder to tell from damage."""


def main(wanted: list[str]) -> int:
    """Prints the table, of all or of those with one of these words in their name."""
    if PROGRAM is None:
        print(f"error: {NO_PROGRAM}", file=sys.stderr)
        return 2
    program, frames, findings = os.path.abspath(PROGRAM), 0, 0
    print("| sequence | frames | found |\n|---|---|---|")
    for name, (scene, *flags) in RENDERS.items():
        if wanted and not any(part in name for part in wanted):
            continue
        with tempfile.TemporaryDirectory() as folder:
            size = () if "--size" in flags else SMALL
            command = [
                program,
                "render",
                str(ROOT / scene),
                *size,
                *flags,
                "--passes",
                "all",
                "--progress",
                "none",
            ]
            command += ["--out", f"{folder}/x.####.exr"]
            subprocess.run(command, check=True, stderr=subprocess.DEVNULL)
            report = validate(folder, Options(processes=1))
        found = ", ".join(
            f"{count} `{check}`" for check, count in Counter(f.check for f in report.findings).items()
        )
        print(f"| {name} | {len(report.frames)} | {found or 'nothing'} |", flush=True)
        frames, findings = frames + len(report.frames), findings + len(report.findings)
    print(f"| together | {frames} | {findings or 'nothing'} |")
    return int(findings > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
