"""Error against time of other renderers, for `sunfleck bench --peers`.

Invariant: time is CPU time over all processors, after scene and kernels are built.
"""

import csv
import datetime
import platform
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TextIO

import numpy as np

from ..errors import ToolError
from ..exr.write import write_colors
from .scene import PeerScene

Render = Callable[[int, int], tuple[np.ndarray, float]]
"""Function of samples a pixel and a seed that returns the picture and its seconds."""
RENDERERS = {
    "mitsuba-llvm": ("Mitsuba llvm", "mitsuba", ("llvm_ad_rgb",)),
    "mitsuba-scalar": ("Mitsuba scalar", "mitsuba", ("scalar_rgb",)),
    "cycles": ("Cycles", "cycles", ()),
    "cycles-denoised": ("Cycles, denoised", "cycles", ("OPENIMAGEDENOISE",)),
}
"""Name, module, and its argument."""
DISTRIBUTIONS = {"mitsuba": "mitsuba", "cycles": "bpy"}
"""Distributions of modules."""
COLUMNS = ("renderer", "version", "spp", "cpu_s", "rmse", "date", "machine")


@dataclass(frozen=True)
class Point:
    """Picture of one renderer; `rmse` and `mean_ratio` are set with a reference."""

    renderer: str
    version: str
    samples: int
    cpu_s: float
    rmse: float | None
    mean_ratio: float | None


def available(name: str) -> str | None:
    """Sentence if a renderer is not installed."""
    label, module, options = RENDERERS[name]
    try:
        import_module(f".{module}", __package__).select(*options)
    except ImportError as error:
        return f"{label} is not here ({error}): pip install {DISTRIBUTIONS[module]} (docs/tools.md says with which Python)"
    return None


def measure(
    scene: PeerScene,
    names: Sequence[str],
    samples: Sequence[int],
    reference: np.ndarray | None = None,
    reference_noise: float = 0.0,
    pictures: Path | None = None,
) -> Iterator[Point]:
    """Renders with each renderer; `pictures` is the folder of their frames."""
    for name in names:
        label, module, options = RENDERERS[name]
        peer = import_module(f".{module}", __package__)
        render: Render = peer.prepare(scene, *options)
        for count in samples:
            picture, seconds = render(count, count)
            if pictures is not None:
                told = f"{label} {peer.version()}, {count} samples a pixel"
                write_frame(pictures / f"{name}.{count:04d}.exr", picture, told)
            rmse = ratio = None
            if reference is not None:
                square = float(np.mean((picture - reference) ** 2))
                rmse = max(square - reference_noise**2, 0.0) ** 0.5
                ratio = float(picture.mean() / reference.mean())
            yield Point(label, peer.version(), count, seconds, rmse, ratio)


def write_frame(path: Path, picture: np.ndarray, said: str) -> None:
    """Writes R, G and B as floats."""
    try:
        write_colors(path, picture, said)
    except RuntimeError as error:
        raise ToolError(f"cannot write {path}: {error}", is_usage=False) from error


def write_table(file: TextIO, points: Sequence[Point], remark: str) -> None:
    """Writes the CSV table that docs/command-line.md describes."""
    file.write(f"# {remark}\n")
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(COLUMNS)
    today = datetime.date.today().isoformat()
    for point in points:
        seconds, rmse = f"{point.cpu_s:.4g}", f"{point.rmse:.4g}"
        writer.writerow([point.renderer, point.version, point.samples, seconds, rmse, today, _machine()])


def _machine() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor()
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return f"{len(names)} x {names[0]}" if names else platform.processor()
