r"""Figures of fog by grids of 64^3 and 256^3 voxels, which Blender's own `openvdb` writes.

    SUNFLECK=target/release/sunfleck .venv/bin/python tools/peers/mist_figures.py [64] [256]

needs a Python with Mitsuba and bpy (docs/tools.md). Leaves and ground in mist have a line for each figure:

- bytes of the grid as rays walk through it, by those of the file's active voxels, four each;
- CPU seconds of a frame to a tolerance, by those with even fog of the same mean in the same box, and bytes of
  peak memory beyond that fog's, by those of the active voxels;
- our picture beside Mitsuba's `volpath`, of single scattering and of all orders: how means differ, and what
  blocks of 10x10 pixels differ by, root mean square by the picture's mean, without Mitsuba's own noise;
- CPU seconds of Cycles, raw and with its denoiser, by ours, to the same error by pixels.

Invariant: all of a line is of one run, in turns.
"""

import re
import subprocess
import tempfile
from pathlib import Path

import bpy
import numpy as np
from common import blocks, error, parser, picture, program, truth_of
from light_scenes import more, scene

from sunfleck_tools.peers import cycles, mitsuba
from sunfleck_tools.peers.scene import read_scene

bpy.utils.expose_bundled_modules()
import openvdb  # noqa: E402  # There once Blender is.

BOX_M = np.array([6.0, 3.0, 6.0])
PIXELS = 120, 70
SIZE = f"{PIXELS[0]}x{PIXELS[1]}"
FRAME = "960x540"
DENSITY_PER_M = 0.6
FOG = "density_per_m: {}, albedo: 0.95, anisotropy: 0.5"
CYCLES_SIZE = 240, 135


def mist(voxels: int) -> np.ndarray:
    """Octaves of noise above a threshold, in [x, y, z], that end inside the box."""
    rng, noise = np.random.default_rng(5), np.zeros((voxels,) * 3, np.float32)
    at = (np.arange(voxels, dtype=np.float32) + 0.5) / voxels
    for octave in range(5):
        cells = 3 * 2**octave
        hats = np.maximum(0, 1 - np.abs(at[:, None] * cells - np.arange(cells + 1, dtype=np.float32)))
        values = rng.standard_normal((cells + 1,) * 3).astype(np.float32)
        for _ in range(3):
            # One axis after the other comes to the end.
            values = np.tensordot(values, hats, (0, 1))
        noise += values / 2**octave
    rim = np.minimum(1, 8 * np.minimum(at, 1 - at))
    return np.clip(noise, 0, None) * rim[:, None, None] * rim[:, None] * rim


def write_grid(path: Path, density: np.ndarray) -> int:
    """Writes a file; returns its number of active voxels."""
    size = BOX_M / density.shape
    rows = np.diag([*size, 1.0])
    rows[3, :3] = size / 2 - BOX_M * [0.5, 0, 0.5]
    grid = openvdb.FloatGrid()
    grid.name, grid.gridClass = "density", openvdb.GridClass.FOG_VOLUME
    grid.copyFromArray(np.ascontiguousarray(density))
    grid.transform = openvdb.createLinearTransform(rows.tolist())
    openvdb.write(str(path), [grid])
    return grid.activeVoxelCount()


def write_scenes(folder: Path, voxels: int) -> tuple[Path, Path, int]:
    """Scene with mist, scene with uniform fog, and the number of active voxels."""
    density = mist(voxels)
    active = write_grid(folder / "mist.vdb", density)
    box = "min_m: (-3.0, 0.0, -3.0), max_m: (3.0, 3.0, 3.0)"
    fogs = {
        "mist": f'(vdb: "mist.vdb", {FOG.format(DENSITY_PER_M)})',
        "even": f"({box}, {FOG.format(DENSITY_PER_M * density.mean())})",
    }
    for name, fog in fogs.items():
        # Leaves are opaque in the other renderers.
        opaque = more("materials", gold="(base_color: (0.5, 0.25, 0.02))")
        (folder / f"{name}.ron").write_text(scene("", **opaque, fog={"fog": fog}))
    return folder / "mist.ron", folder / "even.ron", active


def beside_mitsuba(path: Path, bounces: int, pictures: int, samples: int) -> str:
    """Comparison of sunfleck's picture with Mitsuba's."""
    read = read_scene(path)
    read.size, read.bounces = PIXELS, bounces
    render = mitsuba.prepare(read, "scalar_rgb")
    whole = [render(samples, seed)[0] for seed in range(pictures)]
    flags = ["--samples", "64", "--bounces", "all" if bounces else "0"]
    ours = picture(path, SIZE, flags)[0]
    off_blocks = error(blocks(ours), *truth_of(np.stack([blocks(each) for each in whole])))
    means = [each.mean() for each in whole]
    own = np.std(means, ddof=1) / np.sqrt(pictures) / np.mean(means)
    off = ours.mean() / np.mean(means) - 1
    return f"mean {100 * off:+.3f} % (Mitsuba's own {100 * own:.3f} %), blocks {100 * off_blocks:.2f} %"


def by_even_fog(mist: Path, even: Path, bounces: str, rounds: int) -> tuple[float, int]:
    """CPU seconds of a frame with mist relative to uniform fog, and additional bytes of memory."""
    seconds, memory = {mist: [], even: []}, {}
    for _ in range(rounds):
        for path in seconds:
            _, used, told = picture(path, FRAME, ["--tolerance", "0.05", "--bounces", bounces])
            seconds[path].append(used)
            memory[path] = told["peak_memory_bytes"]
    return min(seconds[mist]) / min(seconds[even]), memory[mist] - memory[even]


def memory(path: Path) -> float:
    """Bytes of a scene's grid in the form for traversal."""
    command = [program(), "inspect", str(path)]
    told = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    found = re.search(r"by voxels, .* ([\d.]+) MB:", told)
    assert found is not None, told
    return 1e6 * float(found[1])


def beside_cycles(path: Path, denoiser: str | None, most: int) -> str:
    """CPU seconds of Cycles relative to sunfleck's, at the error of sunfleck's 16 samples of direct light.
    Without a denoiser Cycles' error falls as the root of samples; with one, samples are increased step by
    step."""
    size = f"{CYCLES_SIZE[0]}x{CYCLES_SIZE[1]}"
    reference = picture(path, size, ["--samples", "512", "--seed", "9", "--bounces", "0"])[0]
    ours, seconds, _ = picture(path, size, ["--samples", "16", "--bounces", "0"])
    aim = error(ours, reference, 0.0)
    read = read_scene(path)
    read.size = CYCLES_SIZE
    render, samples = cycles.prepare(read, denoiser), 16
    theirs, used = render(samples, 1)
    while denoiser and error(theirs, reference, 0.0) > aim and 4 * samples <= most:
        samples *= 4
        theirs, used = render(samples, samples)
    off = error(theirs, reference, 0.0)
    times = used / seconds * (1.0 if denoiser else (off / aim) ** 2)
    more = " or more" if denoiser and off > aim else ""
    said = f"{aim:.4f} by {seconds:.2f} CPU s, {off:.4f} by {samples} samples and {used:.1f} CPU s"
    return f"{times:.0f} times{more} ({said}; mean ratio {theirs.mean() / reference.mean():.4f})"


def main() -> None:
    """Prints each figure on a line."""
    command = parser(__doc__)
    command.add_argument("voxels", type=int, nargs="*", default=[64, 256], help="along a side")
    command.add_argument("--pictures", type=int, default=8, help="by Mitsuba")
    command.add_argument("--samples", type=int, default=32, help="a pixel of these")
    command.add_argument("--rounds", type=int, default=3)
    command.add_argument("--most", type=int, default=1024, help="samples of Cycles with its denoiser")
    command.add_argument("--only", default="mitsuba,even,cycles", help="what is measured")
    arguments = command.parse_args()
    for voxels in arguments.voxels:
        with tempfile.TemporaryDirectory() as folder:
            mist, even, active = write_scenes(Path(folder), voxels)

            def say(what: str, found: str) -> None:
                print(f"{voxels}^3, {what}: {found}", flush=True)

            if "even" in arguments.only:
                say("grid", f"{memory(mist) / (4 * active):.2f} times {active} voxels")
                for what, bounces in (("direct light", "0"), ("all light", "all")):
                    ratio, beyond = by_even_fog(mist, even, bounces, arguments.rounds)
                    memory_beyond = beyond / (4 * active)
                    say(f"{what} by even fog", f"{ratio:.2f} times, memory {memory_beyond:.1f} times")
            if "mitsuba" in arguments.only:
                for what, bounces in (("single", 0), ("all orders", 64)):
                    found = beside_mitsuba(mist, bounces, arguments.pictures, arguments.samples)
                    say(f"beside Mitsuba, {what}", found)
            if "cycles" in arguments.only:
                for what, denoiser in (("Cycles", None), ("Cycles denoised", "OPENIMAGEDENOISE")):
                    say(what, beside_cycles(mist, denoiser, arguments.most))


if __name__ == "__main__":
    main()
