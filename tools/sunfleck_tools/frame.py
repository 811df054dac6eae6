"""One file on its way through the checks: bytes, then pixels."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np

from . import layers
from .exr import half
from .exr.colors import ColorSpace, color_space, luminances
from .exr.header import Header, window_size
from .exr.lossy import rounding

LUMINANCE = np.array([0.2126, 0.7152, 0.0722], np.float32)
"""Weights of Rec. 709, the frames' primaries."""
OWN = "sunfleck:"
"""Prefix of the renderer's own attributes."""

MOST_EMPTY, LARGEST_EMPTY = 64, 1 << 25
"""Maximum size of a display window to show: this many times the data window's pixels, or the pixels of an
8K picture."""
Range = tuple[float, float]
BLOCK_PIXELS = 1 << 15
"""Values a temporary, which then stays in the cache and on the heap: new memory is slower than arithmetic."""


def row_blocks(shape: tuple[int, int], multiple: int = 1) -> Iterator[slice]:
    """Blocks of rows: as many rows as fit, in multiples of `multiple`."""
    rows = max(1, BLOCK_PIXELS // (multiple * max(1, shape[1]))) * multiple
    return (slice(first, min(first + rows, shape[0])) for first in range(0, shape[0], rows))


def wide(stored: np.ndarray) -> np.ndarray:
    """Copy of values as float32."""
    # numpy would warn of signalling NaN.
    with np.errstate(all="ignore"):
        return half.widened(stored) if stored.dtype == np.float16 else stored.astype(np.float32)


@dataclass
class FileBytes:
    """Result of reading and decoding a file; the first fault ends both."""

    number: int
    path: Path
    bytes: int = 0
    headers: tuple[Header, ...] = ()
    read_error: str | None = None
    header_error: str | None = None
    claim: str | None = None
    unsupported: str | None = None
    chunk_faults: list[str] = field(default_factory=list)
    decode_error: str | None = None

    @property
    def fault(self) -> str | None:
        """Fault that prevents decoding, as a sentence."""
        if self.read_error is None and self.bytes == 0:
            return "the file is empty"
        found = (self.read_error, self.header_error, self.claim, self.unsupported, *self.chunk_faults, self.decode_error)
        return next((fault for fault in found if fault), None)


@dataclass
class Frame:
    """Decoded file. Channels are as stored: half, float or uint, rows from the top; `names` are the parts'
    own names of channels, with the part's name as a prefix if it is missing."""

    number: int
    path: Path
    headers: tuple[Header, ...]
    channels: dict[str, np.ndarray]
    part_of: dict[str, int]
    hash: str
    wide: dict[str, np.ndarray] = field(default_factory=dict)
    ranges: dict[str, Range] = field(default_factory=dict)

    @cached_property
    def picture(self) -> tuple[str, ...]:
        """Channels of the picture: three, luminance alone, or none."""
        found = layers.picture(self.channels)
        return found if len({self.header_of(name).data_window for name in found}) == 1 else ()

    @property
    def header(self) -> Header:
        """Header of the picture's part, else of the first."""
        return self.header_of(self.picture[0]) if self.picture else self.headers[0]

    @cached_property
    def space(self) -> ColorSpace:
        """Colour space of the picture: its part's, or the first part's if only that has one."""
        says = "colorInteropID" in self.header.values or "chromaticities" in self.header.values
        return color_space(self.header if says else self.headers[0])

    @cached_property
    def shows_display_window(self) -> bool:
        """True for other renderers' frames, which crop the data window to the contents and may extend
        beyond the display window. Frames of this renderer are shown in their data window, as by the
        program; so are oversized display windows."""
        data, display = self.header.size, window_size(self.header.display_window)
        most = max(MOST_EMPTY * data[0] * data[1], LARGEST_EMPTY)
        return not self.is_own and min(display) > 0 and display[0] * display[1] <= most

    @property
    def canvas(self) -> tuple[int, int]:
        """Height and width of the shown window."""
        width, height = (
            window_size(self.header.display_window) if self.shows_display_window else self.header.size
        )
        return height, width

    def on_canvas(self, values: np.ndarray) -> np.ndarray:
        """Rows of the data window, cropped or padded with 0 to the shown window."""
        data, display = self.header.data_window, self.header.display_window
        if data == display or not self.shows_display_window:
            return values
        canvas = np.zeros((*self.canvas, *values.shape[2:]), values.dtype)
        x, y = data[0] - display[0], data[1] - display[1]
        part = values[max(0, -y) : max(0, canvas.shape[0] - y), max(0, -x) : max(0, canvas.shape[1] - x)]
        canvas[max(0, y) : max(0, y) + part.shape[0], max(0, x) : max(0, x) + part.shape[1]] = part
        return canvas

    @property
    def is_own(self) -> bool:
        """True for frames of this renderer, whose passes satisfy its documentation."""
        return any(name.startswith(OWN) for name in self.headers[0].values)

    @property
    def is_exact(self) -> bool:
        """True for such frames with lossless compression, whose sums of passes can be checked."""
        return self.is_own and rounding(self.header) == 0

    def header_of(self, name: str) -> Header:
        """Header of a channel's part."""
        return self.headers[self.part_of[name]]

    def float(self, name: str) -> np.ndarray:
        """Channel as float32, converted once."""
        if name not in self.wide:
            self.wide[name] = wide(self.channels[name])
        return self.wide[name]

    def extremes(self, name: str) -> Range:
        """Smallest and largest value of a channel, NaN twice if any value is NaN. Most checks need no
        more, and search for the place only if these show a fault."""
        if name not in self.ranges:
            stored = self.channels[name]
            if stored.dtype == np.float16:
                self.ranges[name] = half.extremes(stored)
            else:
                with np.errstate(invalid="ignore"):
                    self.ranges[name] = float(stored.min()), float(stored.max())
        return self.ranges[name]

    def group(self) -> list[np.ndarray]:
        """Red, green and blue of the picture, grey for luminance alone; empty without a picture."""
        values = [self.float(name) for name in self.picture]
        if len(values) == 1 and all(name in self.channels for name in layers.CHROMA):
            weights = luminances(self.space).astype(np.float32)
            ry, by = map(self.float, layers.CHROMA)
            return _from_chroma(values[0], ry, by, weights)
        return values * 3 if len(values) == 1 else values

    def shown(self) -> list[np.ndarray]:
        """The same in linear Rec. 709, for viewing."""
        return self.space.to_rec_709(self.group()) if self.picture else []

    def luminance(self) -> np.ndarray | None:
        """Luminance of the picture, as a new array; values that are not finite count as 0."""
        if not self.picture:
            return None
        color = [self.channels[name] for name in self.picture]
        weights = LUMINANCE if len(color) == 3 else np.ones(1, np.float32)
        plain = [
            stored.dtype == np.float16 and half.plain(*self.extremes(name))
            for name, stored in zip(self.picture, color)
        ]
        total = np.empty(color[0].shape, np.float32)
        scratch = np.empty_like(total[next(row_blocks(total.shape))])
        for rows in row_blocks(total.shape):
            block = total[rows]
            for index, (weight, stored, is_plain) in enumerate(zip(weights, color, plain)):
                part = block if index == 0 else scratch[: len(block)]
                # Infinities of both signs, or signalling NaN, give NaN, which becomes 0 below.
                with np.errstate(all="ignore"):
                    if is_plain:
                        half.scaled_into(stored[rows], weight, part)
                    else:
                        np.multiply(wide(stored[rows]), weight, out=part)
                    if index > 0:
                        block += part
        if all(np.isfinite(self.extremes(name)).all() for name in self.picture):
            return total
        return np.nan_to_num(total, copy=False, nan=0.0, posinf=0.0, neginf=0.0)

    def place(self, name: str, at: int) -> tuple[int, int]:
        """x and y in the full picture of a flat index into a channel."""
        header = self.header_of(name)
        y, x = divmod(int(at), header.size[0])
        return x + header.data_window[0], y + header.data_window[1]


def _from_chroma(y: np.ndarray, ry: np.ndarray, by: np.ndarray, weights: np.ndarray) -> list[np.ndarray]:
    """Red, green and blue from luminance and chroma: RY = (R - Y) / Y and BY = (B - Y) / Y (OpenEXR,
    Technical Introduction, Luminance/Chroma Images), with `weights` of luminance."""
    with np.errstate(all="ignore"):
        red, blue = (1 + ry) * y, (1 + by) * y
        return [red, (y - weights[0] * red - weights[2] * blue) / weights[1], blue]
