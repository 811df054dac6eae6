"""What indirect light takes: processor time and memory of one process with it, and without.

    SUNFLECK=../target/release/sunfleck python -m tests.indirect_cost          (in tools/)

Of `title`, of a million leaves, and of a scene of 100 km. Pictures are small and have one sample a pixel, so
that what is left is the field.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from .command import NO_PROGRAM, PROGRAM, SEQUENCES

SCENE = """Scene(
    version: 1,
    meshes: {{ "leaf": Leaf(length_m: 0.1, width_m: 0.06), "ground": Quad(size_m: {ground_m}) }},
    materials: {{ "leaf": (base_color: (0.42, 0.26, 0.06), transmission: (0.38, 0.24, 0.04)) }},
    objects: {{ "ground": (mesh: "ground") }},
    leaves: {{ "crown": (
        count: {count}, seed: 1, meshes: ["leaf"], materials: ["leaf"], min_m: (-{half_m}, 0.5, -{half_m}), max_m: ({half_m}, 8.0, {half_m}),
    ) }},
    cameras: {{ "main": (position_m: (0.0, 2.0, 30.0), look_at_m: (0.0, 3.0, 0.0)) }},
    lights: {{ "sun": Sun(to_sun: (0.4, 1.0, -0.6), irradiance_w_per_m2: 8.0) }},
    fog: {{ "haze": (scale_height_m: 20.0, density_per_m: {density_per_m}) }},
)
"""
SCENES = {
    "a million leaves": {"count": 1_000_000, "half_m": 20.0, "ground_m": 60.0, "density_per_m": 0.02},
    "100 km": {"count": 10_000, "half_m": 50_000.0, "ground_m": 100_000.0, "density_per_m": 0.0002},
}


def used(file: Path, bounces: str, folder: Path, *, frames: str = "24", samples: int = 1) -> tuple[float, float]:
    """Processor seconds and most megabytes."""
    command = [
        os.path.abspath(str(PROGRAM)), "render", str(file), "--frames", frames, "--size", "240x135",
        "--samples", str(samples), "--bounces", bounces, "--progress", "none", "--out", str(folder / "f.####.exr"),
    ]  # fmt: skip
    process = subprocess.Popen(command)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise SystemExit(f"{' '.join(command)} ended with {process.returncode}")
    # Kilobytes, as Linux counts them.
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1000


def main() -> int:
    """Prints it scene by scene."""
    plain = argparse.RawDescriptionHelpFormatter
    argparse.ArgumentParser(description=__doc__, formatter_class=plain).parse_args()
    if PROGRAM is None:
        print(f"error: {NO_PROGRAM}", file=sys.stderr)
        return 2
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        files = {"title": SEQUENCES / "title.ron"}
        for what, numbers in SCENES.items():
            files[what] = folder / f"{what}.ron"
            files[what].write_text(SCENE.format(**numbers), encoding="utf-8")
        for what, file in files.items():
            (seconds, megabytes), (all_seconds, all_megabytes) = (used(file, bounces, folder) for bounces in ("0", "all"))
            print(
                f"{what}: without {seconds:.1f} CPU s and {megabytes:.0f} MB, with {all_seconds:.1f} CPU s and "
                f"{all_megabytes:.0f} MB, {all_megabytes - megabytes:.0f} MB more",
                flush=True,
            )
    return 0


if __name__ == "__main__":
    sys.exit(main())
