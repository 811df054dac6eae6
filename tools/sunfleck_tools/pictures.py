"""Frames to pictures for eyes.

Invariant: whatever a file holds, there is a picture: one that cannot be shown is a hatched field, and its fault a sentence.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from .analysis import read_frame
from .display import Display
from .exr.header import Header, window_size
from .frame import Frame
from .parallel import in_processes
from .sequence import Listing
from .summary import thumbnail, thumbnail_step

MOST_NAMES = 12
"""Of channels, in a sentence."""
MOST_EMPTY = 64
"""Times the data's pixels that a picture has; what is larger is shown without the empty space."""
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
    colors = np.stack(frame.group(), axis=-1) if width is None or width >= _canvas(frame)[1] else None
    if colors is not None:
        pixels, step = display.bytes(colors, frame.header.data_window[:2]), 1
    else:
        pixels, step = display.bytes(thumbnail(frame, width).astype(np.float32)), thumbnail_step(frame, width)
    return Shown(number, _on_canvas(frame, pixels, step), header=frame.header)


def _canvas(frame: Frame) -> tuple[int, int]:
    """Height and width of what is shown: the display window of other renderers' frames, which cut the data down to what is there
    and render beyond it; of own frames the data window, as the program shows a crop."""
    data, display = frame.header.size, window_size(frame.header.display_window)
    is_bearable = 0 < display[0] * display[1] <= MOST_EMPTY * data[0] * data[1] and min(display) > 0
    width, height = data if frame.is_own or not is_bearable else display
    return height, width


def _on_canvas(frame: Frame, pixels: np.ndarray, step: int) -> np.ndarray:
    """The data's pixels, each the average of `step` in a row, where they lie on the canvas; around them it is black."""
    height, width = _canvas(frame)
    if frame.header.size == (width, height):
        return pixels
    (left, top), (x0, y0) = frame.header.data_window[:2], frame.header.display_window[:2]
    canvas = np.zeros((max(1, height // step), max(1, width // step), 3), np.uint8)
    x, y = (left - x0) // step, (top - y0) // step
    part = pixels[max(0, -y) : max(0, canvas.shape[0] - y), max(0, -x) : max(0, canvas.shape[1] - x)]
    canvas[max(0, y) : max(0, y) + part.shape[0], max(0, x) : max(0, x) + part.shape[1]] = part
    return canvas


def files_of(listing: Listing) -> list[tuple[int, str | None]]:
    """Number and file of each frame that is expected; without a file it is missing."""
    paths = {file.number: str(file.path) for file in listing.frames}
    return [(number, paths.get(number)) for number in listing.expected]


def shown(frames: Sequence[tuple[int, str | None]], display: Display, width: int | None, processes: int) -> Iterator[Shown]:
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
