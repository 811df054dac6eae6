"""How steady the indirect light of leaves is while they move.

    SUNFLECK=../target/release/sunfleck python -m tests.leaf_light          (in tools/)

Each of 500 leaves goes straight on, its own way, 4 cm a frame, through a box of fog under a sun. The picture
has no noise. A camera of parallel rays sees each leaf by many rays, and all of a leaf is as bright. Second
differences in time are printed, of the light of each leaf over its own.

    python -m tests.leaf_light --walks 256

prints by how much it truly wavers, by random walks of as many samples in three frames. They are noisy: what two
seeds have in common is no noise. It takes an hour of a processor.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from sunfleck_tools.exr.decode import decode

from .command import NO_PROGRAM, PROGRAM

LEAVES, STEP_M, FRAMES = 500, 0.04, 25
LOW_M, HIGH_M = (-4.0, 0.6, -5.0), (4.0, 5.6, 3.0)
"""Of the box in which leaves are in the middle of their way. As many leaves, as large and as dense, in the same
fog under the same sun as in tests/data/leaves500, but flat: so all of a side of a leaf is as bright."""
SCENE = """Scene(
    version: 1,
    meshes: {{ "leaf": Leaf(length_m: 0.6, width_m: 0.34), "ground": Quad(size_m: 20.0) }},
    materials: {{ "leaf": (base_color: {reflectance}, transmission: {transmittance}), "ground": (base_color: 0.3) }},
    objects: {{ "~ground": (mesh: "ground", material: "ground"), {leaves} }},
    cameras: {{ "main": (position_m: (0.0, 3.0, 9.0), orthographic_height_m: 7.0) }},
    lights: {{ "sun": Sun(to_sun: (0.35, 0.75, -0.56), irradiance_w_per_m2: (20.0, 18.0, 14.0)) }},
    fog: {{ "fog": (min_m: (-10.0, -0.5, -10.0), max_m: (10.0, 8.0, 10.0), density_per_m: 0.066, albedo: 0.90909, anisotropy: 0.5) }},
)
"""
OPAQUE, SEEN_THROUGH = ((0.6, 0.3, 0.1), 0.0), ((0.42, 0.26, 0.06), (0.38, 0.24, 0.04))
LEAF = '"{number:03}": (mesh: "leaf", material: "leaf", rotation_deg: {turn}, translation_m: Keyed(keys: [(at_s: 0.0, value: {start}), (at_s: {seconds}, value: {end})])),'
TRUE_FRAMES = (11, 12, 13)
FEWEST_PIXELS = 12
"""Of a leaf in each of three frames: colours are stored in half precision, so one pixel does not tell."""
EDGE_ON = 0.1
"""Leaves turned farther away are left out."""


def scene(reflectance: object, transmittance: object) -> str:
    """The leaves on their ways."""
    random = np.random.default_rng(35)
    frames_m = STEP_M * (FRAMES + 1)
    ways = random.normal(size=(LEAVES, 3))
    ways *= frames_m / np.linalg.norm(ways, axis=1, keepdims=True)
    middles = random.uniform(LOW_M, HIGH_M, (LEAVES, 3))
    turns = random.uniform(-180.0, 180.0, (LEAVES, 3))
    told = [
        LEAF.format(number=number, turn=tuple(turn.tolist()), start=tuple(start.tolist()), end=tuple(end.tolist()),
                    seconds=(FRAMES + 1) / 24.0)
        for number, (turn, start, end) in enumerate(zip(turns, middles - ways / 2, middles + ways / 2, strict=True))
    ]  # fmt: skip
    return SCENE.format(reflectance=reflectance, transmittance=transmittance, leaves="\n".join(told))


def light(folder: Path, frame: int) -> np.ndarray:
    """Luminance of the indirect light of each leaf, before fog; NaN where too little of it is seen."""
    channels = {
        name: np.asarray(pixels, np.float64)
        for name, pixels in decode(folder / f"light.{frame:04d}.exr").items()
    }
    total = sum(
        weight * channels[f"indirect.{channel}"] / np.maximum(channels[f"transmittance.{channel}"], 1e-3)
        for weight, channel in ((0.2126, "R"), (0.7152, "G"), (0.0722, "B"))
    )
    faces = abs(channels["Normal.Z"]) > EDGE_ON
    ids = np.where(faces, channels["leaf_id.X"], 0).astype(int).ravel()
    count = np.bincount(ids, minlength=LEAVES + 2)
    sums = np.bincount(ids, weights=total.ravel(), minlength=LEAVES + 2)
    return np.where(count >= FEWEST_PIXELS, sums / np.maximum(count, 1), np.nan)[1:]


def render(folder: Path, frames: str, flags: list[str]) -> None:
    """Frames of the scene that lies there."""
    command = [
        os.path.abspath(str(PROGRAM)), "render", str(folder / "scene.ron"), "--frames", frames, "--size", "640x360",
        "--passes", "indirect,transmittance,normal,leaf-id", "--progress", "none",
        "--out", str(folder / "light.####.exr"), *flags,
    ]  # fmt: skip
    subprocess.run(command, check=True)


def wavers(lights: np.ndarray) -> np.ndarray:
    """Second differences in time over the light itself; NaN where a leaf is not seen."""
    second = lights[:-2] - 2.0 * lights[1:-1] + lights[2:]
    return 3.0 * second / (lights[:-2] + lights[1:-1] + lights[2:])


def measure(folder: Path, what: str, reflectance: object, transmittance: object) -> None:
    """Renders the frames and prints by how much the light of leaves wavers."""
    (folder / "scene.ron").write_text(scene(reflectance, transmittance), encoding="utf-8")
    render(folder, f"1-{FRAMES}", ["--samples", "1", "--volume", "segments"])
    found = wavers(np.array([light(folder, frame) for frame in range(1, FRAMES + 1)]))
    seen = abs(found[np.isfinite(found)])
    frame, leaf = np.unravel_index(np.nanargmax(abs(found)), found.shape)
    print(
        f"leaves {what}: of {seen.size:,} second differences RMS {100 * np.sqrt(np.mean(seen**2)):.2f} %, "
        f"99 % within {100 * np.quantile(seen, 0.99):.2f} %, worst {100 * seen.max():.2f} % (leaf {leaf}, frame {frame + 2})",
        flush=True,
    )


def measure_truth(folder: Path, samples: int) -> None:
    """Renders three frames by walks with two seeds and prints by how much leaves waver in both."""
    (folder / "scene.ron").write_text(scene(*OPAQUE), encoding="utf-8")
    of_seeds = []
    for seed in (0, 1):
        by_walks = ["--samples", str(samples), "--volume", "paths", "--seed", str(seed)]
        render(folder, f"{TRUE_FRAMES[0]}-{TRUE_FRAMES[-1]}", by_walks)
        of_seeds.append(wavers(np.array([light(folder, frame) for frame in TRUE_FRAMES]))[0])
    products = np.prod(of_seeds, axis=0)
    products = products[np.isfinite(products)]
    mean, error = products.mean(), products.std() / np.sqrt(products.size)
    low, middle, high = (100 * np.sqrt(max(value, 0.0)) for value in (mean - error, mean, mean + error))
    print(f"opaque leaves by walks: RMS {middle:.2f} %, between {low:.2f} and {high:.2f} % ({products.size} leaves)")


def main() -> int:
    """Prints it for leaves that let no light through, and for leaves that do."""
    plain = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=plain)
    parser.add_argument("--walks", type=int, metavar="SAMPLES", help="the truth, by random walks")
    arguments = parser.parse_args()
    if PROGRAM is None:
        print(f"error: {NO_PROGRAM}", file=sys.stderr)
        return 2
    if arguments.walks:
        with tempfile.TemporaryDirectory() as folder:
            measure_truth(Path(folder), arguments.walks)
        return 0
    for what, colors in {"opaque": OPAQUE, "that transmit": SEEN_THROUGH}.items():
        with tempfile.TemporaryDirectory() as folder:
            measure(Path(folder), what, *colors)
    return 0


if __name__ == "__main__":
    sys.exit(main())
