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
    """A command line that its script's own text describes."""
    return argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)


def program() -> str:
    """The renderer."""
    return os.environ.get("SUNFLECK", "sunfleck")


def cpu_seconds(command: list) -> float:
    """Of a process from its start to its end; one that fails ends this one."""
    with subprocess.Popen([str(part) for part in command], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) as process:
        said = process.stderr.read()
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        sys.exit(f"{command[0]} failed:\n{said.decode(errors='replace')}")
    return used.ru_utime + used.ru_stime


def rendered(scene: Path, size: str, flags: list[str], frame: int = 1) -> tuple[dict[str, np.ndarray], float, dict]:
    """The channels of a frame; CPU seconds of the process; what `--stats` says."""
    from sunfleck_tools.exr.decode import decode

    with tempfile.TemporaryDirectory() as folder:
        out, stats = Path(folder, "picture.exr"), Path(folder, "stats")
        command = [program(), "render", scene, "--frames", frame, "--size", size, "--progress", "none"]
        seconds = cpu_seconds([*command, "--stats", stats, "--out", out, *flags])
        return decode(out), seconds, told_of(stats)


def told_of(stats: Path) -> dict:
    """What `--stats` says of the first frame, behind the line of the input's losses."""
    return next(line for line in map(json.loads, stats.read_text().splitlines()) if "frame" in line)


def colors(channels: dict[str, np.ndarray], prefix: str = "") -> np.ndarray:
    """The beauty or a pass, height x width x 3, W m^-2 sr^-1."""
    return np.stack([channels[prefix + color] for color in "RGB"], -1).astype(float)


def picture(scene: Path, size: str, flags: list[str]) -> tuple[np.ndarray, float, dict]:
    """As `rendered`, of the beauty alone."""
    channels, seconds, told = rendered(scene, size, flags)
    return colors(channels), seconds, told


def blocks(picture: np.ndarray) -> np.ndarray:
    """Means of blocks of a picture; rows and columns that fill none are left out."""
    rows, columns = picture.shape[0] // BLOCK, picture.shape[1] // BLOCK
    inside = picture[: rows * BLOCK, : columns * BLOCK]
    return inside.reshape(rows, BLOCK, columns, BLOCK, 3).mean(axis=(1, 3))


def truth_of(pictures: np.ndarray) -> tuple[np.ndarray, float]:
    """The mean of independent pictures, and the mean variance that their noise leaves in it."""
    return pictures.mean(axis=0), float(pictures.var(axis=0, ddof=1).mean() / len(pictures))


def error(ours: np.ndarray, theirs: np.ndarray, noise: float) -> float:
    """The root mean square of what two differ by, as a share of the mean; the truth's own noise is taken out."""
    return float(np.sqrt(max(((ours - theirs) ** 2).mean() - noise, 0.0)) / theirs.mean())
