"""What these scripts share: a command line, a picture by sunfleck with what it took, and errors of its blocks."""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

BLOCK = 10


def parser(doc: str) -> argparse.ArgumentParser:
    """Parser whose description is the script's docstring."""
    return argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)


def pair(text: str) -> tuple[int, int]:
    """Width and height."""
    width, height = text.split("x")
    return int(width), int(height)


def floats(text: str) -> list[float]:
    """Numbers of a list."""
    return [float(part) for part in text.split(",")]


def ints(text: str) -> list[int]:
    """Whole numbers of a list."""
    return [int(part) for part in text.split(",")]


def program() -> str:
    """Path of the renderer."""
    return os.environ.get("SUNFLECK", "sunfleck")


def cpu_seconds(command: list) -> float:
    """CPU seconds of a process; if it fails, this one exits."""
    with subprocess.Popen([str(part) for part in command], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) as process:
        said = process.stderr.read()
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        sys.exit(f"{command[0]} failed:\n{said.decode(errors='replace')}")
    return used.ru_utime + used.ru_stime


def rendered(scene: Path, size: str, flags: list[str], frame: int = 1) -> tuple[dict[str, np.ndarray], float, dict]:
    """Channels of a frame, CPU seconds of the process, and the frame's `--stats`."""
    from sunfleck_tools.exr.decode import decode

    with tempfile.TemporaryDirectory() as folder:
        out, stats = Path(folder, "picture.exr"), Path(folder, "stats")
        command = [program(), "render", scene, "--frames", frame, "--size", size, "--progress", "none"]
        seconds = cpu_seconds([*command, "--stats", stats, "--out", out, *flags])
        return decode(out), seconds, told_of(stats)


def told_of(stats: Path) -> dict:
    """`--stats` of the first frame, after the line of the input's losses."""
    return next(line for line in map(json.loads, stats.read_text().splitlines()) if "frame" in line)


def colors(channels: dict[str, np.ndarray], prefix: str = "") -> np.ndarray:
    """Beauty or a pass, height x width x 3, W m^-2 sr^-1."""
    return np.stack([channels[prefix + color] for color in "RGB"], -1).astype(float)


def picture(scene: Path, size: str, flags: list[str]) -> tuple[np.ndarray, float, dict]:
    """As `rendered`, for the beauty alone."""
    channels, seconds, told = rendered(scene, size, flags)
    return colors(channels), seconds, told


def blocks(picture: np.ndarray) -> np.ndarray:
    """Means of blocks of a picture, without incomplete blocks."""
    rows, columns = picture.shape[0] // BLOCK, picture.shape[1] // BLOCK
    inside = picture[: rows * BLOCK, : columns * BLOCK]
    return inside.reshape(rows, BLOCK, columns, BLOCK, 3).mean(axis=(1, 3))


def truth_of(pictures: np.ndarray) -> tuple[np.ndarray, float]:
    """Mean of independent pictures, and the mean variance of its noise."""
    return pictures.mean(axis=0), float(pictures.var(axis=0, ddof=1).mean() / len(pictures))


def error(ours: np.ndarray, theirs: np.ndarray, noise: float) -> float:
    """Root mean square difference relative to the mean, without the truth's own noise."""
    return float(np.sqrt(max(((ours - theirs) ** 2).mean() - noise, 0.0)) / theirs.mean())
