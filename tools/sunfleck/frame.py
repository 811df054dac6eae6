"""Frames in memory. In goes an EXR file, out come arrays with names, units and metadata.

Invariant: arrays are float32, rows from the top, `(height, width)` where a pass has one channel and
`(height, width, channels)` where it has several; ids keep the file's bits.
"""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from sunfleck_tools import frame as files
from sunfleck_tools.analysis import read_frame
from sunfleck_tools.exr.codecs import FLAT
from sunfleck_tools.exr.header import window_size

from . import passes
from .diagnostic import diagnostics
from .errors import FileError
from .flags import path_text

Pixels = npt.NDArray[np.float32]
MATRICES = ("worldToCamera", "worldToNDC")


@dataclass(frozen=True)
class Pass:
    """Pass of a frame."""

    name: str
    """Name as in `--passes`."""
    channels: tuple[str, ...]
    """Names of the channels in the file, in the order of the array."""
    unit: str
    """Unit: `1` without one, `id` for ids, `px` for pixels."""
    pixels: Pixels


class Passes(dict[str, Pass]):
    """Passes by name; where one is missing, the `KeyError` says which there are."""

    def __init__(self, held: Mapping[str, Pass], channels: tuple[str, ...]):
        super().__init__(held)
        self._channels = channels

    def __missing__(self, name: str) -> Pass:
        wanted = str(name).replace("_", "-")
        if wanted in self:
            return self[wanted]
        if not self:
            raise KeyError(f"the frame holds no pass: take a channel by its name, frame[NAME], of {', '.join(self._channels)}")
        if wanted in passes.PASSES:
            raise KeyError(f"the frame holds {', '.join(self)} and no {wanted}: render it with passes=['{wanted}']")
        raise KeyError(f"a frame has no {name}: its passes are {', '.join(self)}")


class Frame:
    """A rendered frame: `frame.beauty`, `frame.leaf_id`, `frame["Normal.X"]`; `frame.passes` has channels and units."""

    def __init__(self, number: int, file: files.Frame):
        self.number = number
        self._file = file

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the whole picture."""
        return window_size(self._file.header.display_window)

    @property
    def window(self) -> tuple[int, int, int, int]:
        """Window of the rendered pixels, as for `--crop`: x0, y0, x1, y1, the last two excluded. Arrays
        have its size."""
        left, top, right, bottom = self._file.header.data_window
        return left, top, right + 1, bottom + 1

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of all channels, as in the file."""
        return tuple(sorted(self._file.channels))

    @cached_property
    def passes(self) -> Mapping[str, Pass]:
        """Passes by name, the beauty first. Raises `KeyError` with those that there are."""
        held = passes.held(self._file.channels)
        return Passes({name: self._pass(name, *row) for name, row in held.items()}, self.channels)

    @cached_property
    def metadata(self) -> Mapping[str, object]:
        """Attributes of the file by name: hashes of scene, settings and pixels, version, frame rate,
        camera (a 4x4 matrix for column vectors) and so on."""
        values = {name: value for name, value in self._file.header.values.items() if not isinstance(value, (bytes, tuple))}
        for name in MATRICES:
            stored = self._file.header.values.get(name)
            if isinstance(stored, bytes) and len(stored) == 64:
                # EXR's matrices are for row vectors.
                values[name] = np.frombuffer(stored, "<f4").reshape(4, 4).T.copy()
        return values

    def __getitem__(self, channel: str) -> Pixels:
        """Channel by its name in the file. Raises `KeyError`."""
        if channel not in self._file.channels:
            raise KeyError(f"there is no channel {channel}: the frame has {', '.join(self.channels)}")
        return self._file.float(channel)

    def __getattr__(self, name: str) -> Pixels:
        """Array of a pass."""
        if name.startswith("_"):
            raise AttributeError(name)
        try:
            return self.passes[name.replace("_", "-")].pixels
        except KeyError as error:
            raise AttributeError(error.args[0]) from None

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *(name.replace("-", "_") for name in self.passes)]

    def __repr__(self) -> str:
        width, height = self.size
        return f"<sunfleck.Frame {self.number}: {width}x{height}, {', '.join(self.passes) or ', '.join(self.channels)}>"

    def _pass(self, name: str, channels: tuple[str, ...], unit: str) -> Pass:
        arrays = [self._file.float(channel) for channel in channels]
        return Pass(name, channels, unit, arrays[0] if len(arrays) == 1 else np.stack(arrays, axis=-1))


def read(path: str | os.PathLike[str]) -> Frame:
    """Frame from a file of this renderer, or the channels of another's. Raises `FileError` with the fault."""
    name = path_text("path", path)
    file, frame = read_frame(0, name)
    if frame is None:
        remedy = "check the path" if file.read_error else "render the frame again"
        if file.unsupported:
            remedy = f"flatten it: {FLAT}"
        said = f"{name}: error: {file.fault}\n  remedy: {remedy}"
        raise FileError(said, 4, diagnostics(said))
    counter = frame.header.values.get("imageCounter")
    return Frame(counter if isinstance(counter, int) else 0, frame)
