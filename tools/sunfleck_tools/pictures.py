"""Frames to pictures for eyes.

Invariant: whatever a file holds, there is a picture: one that cannot be shown is a hatched field, and
its fault a sentence.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from .analysis import read_frame
from .display import Display
from .exr.header import Header
from .frame import Frame
from .parallel import in_processes
from .sequence import Listing
from .summary import thumbnail

MOST_NAMES = 12
"""Of channels, in a sentence."""
HATCHED = (np.array([90, 90, 90], np.uint8), np.array([50, 50, 50], np.uint8))


@dataclass
class Shown:
    """A frame as bytes of RGB; without pixels, why there are none."""

    number: int
    pixels: np.ndarray | None = None
    fault: str | None = None
    header: Header | None = None


def load(number: int, path: str) -> tuple[Frame | None, str | None]:
    """A frame with colour, or the sentence that says why there is none."""
    file, frame = read_frame(number, path)
    if frame is None:
        return None, file.fault
    if not frame.picture:
        named = ", ".join(list(frame.channels)[:MOST_NAMES])
        return None, f"it has no picture (R, G and B of a layer, or Y), only {named}"
    return frame, None


def show(display: Display, width: int | None, argument: tuple[int, str | None]) -> Shown:
    """Number and file to a picture; with a width, one of about that width, by averages of whole pixels."""
    number, path = argument
    if path is None:
        return Shown(number, fault="there is no such file")
    frame, fault = load(number, path)
    if frame is None:
        return Shown(number, fault=f"{fault} ({Path(path).name})")
    if width is None or width >= frame.canvas[1]:
        pixels = frame.on_canvas(
            display.bytes(np.stack(frame.shown(), axis=-1), frame.header.data_window[:2])
        )
    else:
        small = thumbnail(frame, width)
        assert small is not None, "a frame that was loaded has a picture"
        pixels = display.bytes(small.astype(np.float32))
    return Shown(number, pixels, header=frame.header)


def files_of(listing: Listing) -> list[tuple[int, str | None]]:
    """Number and file of each frame that is expected; without a file it is missing."""
    paths = {file.number: str(file.path) for file in listing.frames}
    return [(number, paths.get(number)) for number in listing.expected]


def shown(
    frames: Sequence[tuple[int, str | None]], display: Display, width: int | None, processes: int
) -> Iterator[Shown]:
    """Pictures of frames, in their order."""
    yield from in_processes(partial(show, display, width), frames, min(processes, len(frames)), _died)


def _died(argument: tuple[int, str | None]) -> Shown:
    return Shown(argument[0], fault="the decoder crashed")


def hatched(height: int, width: int) -> np.ndarray:
    """What stands for a frame that cannot be shown."""
    y, x = np.mgrid[:height, :width]
    return np.where((((x + y) // 8) % 2 == 0)[..., None], *HATCHED)


def fitted(pixels: np.ndarray | None, height: int, width: int) -> np.ndarray:
    """A picture cut or filled up with black to a size; without one, a hatched field."""
    if pixels is None:
        return hatched(height, width)
    result = np.zeros((height, width, 3), np.uint8)
    part = pixels[:height, :width]
    result[: part.shape[0], : part.shape[1]] = part
    return result
