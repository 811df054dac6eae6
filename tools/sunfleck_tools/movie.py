"""A sequence as a movie. ffmpeg makes what players and browsers take; without it Pillow makes WebP. Own code
makes an animated PNG.

Invariants: every frame of the sequence has its time in the movie, also one that cannot be shown. A movie that
was begun and not finished is not left behind.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from fractions import Fraction
from itertools import chain
from pathlib import Path
from typing import Protocol

import numpy as np

from .disk import writing
from .errors import ToolError
from .pictures import Shown, fitted
from .png import AnimatedPng
from .webp import Webp

BY_FFMPEG = {
    ".mp4": ["-c:v", "libx264", "-crf", "16", "-preset", "medium", "-pix_fmt", "yuv420p", "-movflags", "+faststart"],
    ".mov": ["-c:v", "prores_ks", "-profile:v", "3", "-pix_fmt", "yuv422p10le"],
    ".webm": ["-c:v", "libvpx-vp9", "-crf", "24", "-b:v", "0", "-pix_fmt", "yuv420p"],
    ".webp": ["-c:v", "libwebp_anim", "-quality", str(Webp.QUALITY), "-loop", "0"],
}
"""By the ending of the name; qualities at which no eye sees the loss."""
COLOUR = [
    "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv",
    "-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "iec61966-2-1",
]  # fmt: skip
"""What the pictures are in, said aloud; codecs that halve colour want even sizes."""
ENDINGS = (".png", *BY_FFMPEG)
DEFAULT_FPS = Fraction(24)


class Writer(Protocol):
    """What pictures go to, all of one size."""

    def add(self, pixels: np.ndarray) -> None:
        """The next picture."""

    def close(self) -> None:
        """No more will come."""


def movie(
    pictures: Iterable[Shown], count: int, out: Path, fps: Fraction | None = None
) -> list[tuple[int, str]]:
    """Writes a movie; the rate is that of the first frame that says one. Returns what could not be
    shown, with reasons."""
    check_ending(out)
    ahead, faults = [], []
    cells = iter(pictures)
    for picture in cells:
        ahead.append(picture)
        if picture.pixels is not None:
            break
    first = next((picture for picture in ahead if picture.pixels is not None), None)
    if first is None:
        raise ToolError(
            f"none of the frames can be shown; frame {ahead[0].number}: {ahead[0].fault}", is_usage=False
        )
    assert first.pixels is not None and first.header is not None
    height, width, _ = first.pixels.shape
    said = first.header.values.get("framesPerSecond")
    fps = fps or (said if isinstance(said, Fraction) and said > 0 else DEFAULT_FPS)
    with _writer(out, count, (width, height), fps) as writer:
        for picture in chain(ahead, cells):
            writer.add(fitted(picture.pixels, height, width))
            if picture.fault is not None:
                faults.append((picture.number, picture.fault))
    return faults


@contextmanager
def _writer(out: Path, count: int, size: tuple[int, int], fps: Fraction) -> Iterator[Writer]:
    """What writes `out`, which appears when the block has ended well."""
    is_png = out.suffix.lower() == ".png"
    if is_png or shutil.which("ffmpeg") is None:
        with writing(out) as file:
            writer: Writer = AnimatedPng(file, count, fps) if is_png else Webp(file, fps)
            yield writer
            writer.close()
        return
    if out.exists() and not out.is_file():
        raise ToolError(f"{out} is no regular file: name another")
    with tempfile.TemporaryDirectory(dir=out.parent, prefix=f".{out.name}.") as folder:
        part = Path(folder) / out.name
        writer = Ffmpeg(part, *size, fps)
        try:
            yield writer
            writer.close()
        except BaseException:
            writer.abort()
            raise
        os.replace(part, os.path.realpath(out))


def check_ending(out: Path) -> None:
    """Refuses names that say no format, and formats whose program is not there, before there is any work."""
    ending = out.suffix.lower()
    if ending not in ENDINGS:
        raise ToolError(f"{out} is no name of a movie: expected one that ends in {', '.join(ENDINGS)}")
    if ending in BY_FFMPEG and ending != ".webp" and shutil.which("ffmpeg") is None:
        raise ToolError(
            f"{ending} is made by ffmpeg, which is not on the PATH: install it, or write an animated PNG, "
            "OUT.png"
        )


class Ffmpeg:
    """A process that is fed raw pictures."""

    def __init__(self, out: Path, width: int, height: int, fps: Fraction):
        ending = out.suffix.lower()
        colour = [] if ending == ".webp" else COLOUR
        command = ["ffmpeg", "-nostdin", "-hide_banner", "-loglevel", "error", "-y"]
        command += [
            "-f",
            "rawvideo",
            "-pix_fmt",
            "rgb24",
            "-video_size",
            f"{width}x{height}",
            "-framerate",
            str(fps),
            "-i",
            "pipe:0",
        ]
        self._errors = tempfile.TemporaryFile()
        self._process = subprocess.Popen(
            [*command, *colour, *BY_FFMPEG[ending], str(out)],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=self._errors,
        )
        assert self._process.stdin is not None
        self._input = self._process.stdin

    def add(self, pixels: np.ndarray) -> None:
        """The next picture."""
        try:
            self._input.write(pixels.tobytes())
        except BrokenPipeError:
            # It gave up; `close` says why.
            self.close()
            raise

    def abort(self) -> None:
        """Ends it at once; what it wrote is of no use."""
        self._process.kill()
        self._process.wait()
        self._errors.close()

    def close(self) -> None:
        """Waits for the end, and for what ffmpeg has to say of it."""
        if self._errors.closed:
            return
        with suppress(BrokenPipeError):
            self._input.close()
        code = self._process.wait()
        with self._errors as said:
            said.seek(0)
            words = said.read().decode("utf-8", "replace").strip()
        if code != 0:
            raise ToolError(f"ffmpeg failed with code {code}: {words}", is_usage=False)
