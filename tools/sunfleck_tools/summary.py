"""What is kept of a frame once its pixels are gone.

Invariant: a summary is small (some kB), so that a thousand of them fit into any memory.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .exr.header import COMPRESSIONS, TILED, Header
from .findings import Finding
from .frame import Frame
from .options import Options

PROVENANCE = ("version", "sceneHash", "settingsHash", "seed", "pixelHash")


@dataclass
class FrameSummary:
    """One frame; fields that need pixels are `None` where there are none."""

    number: int
    path: str
    bytes: int = 0
    attributes: dict[str, object] = field(default_factory=dict)
    provenance: dict[str, str] = field(default_factory=dict)
    structure: dict[str, object] = field(default_factory=dict)
    hash: str | None = None
    mean: float | None = None
    p99: float | None = None
    largest: float | None = None
    smallest: float | None = None
    constant: bool = False
    firefly_candidates: list[tuple[int, int, float, float]] = field(default_factory=list)
    fireflies: list[tuple[int, int, float, float]] = field(default_factory=list)
    relmse: float | None = None
    flip: float | None = None
    reference_error: str | None = None
    render_seconds: float | None = None
    thumbnail: np.ndarray | None = None
    findings: list[Finding] = field(default_factory=list)

    @property
    def decoded(self) -> bool:
        """True if there were pixels to look at."""
        return self.hash is not None


@dataclass
class Rendered:
    """All frames of a sequence, ascending, and what was asked of them."""

    frames: list[FrameSummary]
    options: Options

    @property
    def decoded(self) -> list[FrameSummary]:
        """Frames that had pixels."""
        return [frame for frame in self.frames if frame.decoded]


def describe(summary: FrameSummary, header: Header) -> None:
    """Fills in what the header says."""
    for name in ("framesPerSecond", "imageCounter", "timeCode"):
        if name in header.values:
            summary.attributes[name] = header.values[name]
    for name in PROVENANCE:
        if (value := header.text(f"sunfleck:{name}")) is not None:
            summary.provenance[name] = value
    types = ("uint", "half", "float")
    summary.structure = {
        "channels": ", ".join(f"{channel.name} ({types[channel.type]})" for channel in header.channels),
        "display window": header.display_window,
        "data window": header.data_window,
        "compression": COMPRESSIONS[header.compression],
        "layout": "tiles" if header.flags & TILED else "scan lines",
    }


def measure(summary: FrameSummary, frame: Frame) -> None:
    """Fills in what the pixels say."""
    summary.hash = frame.hash
    if (luminance := frame.luminance) is not None:
        flat = luminance.ravel()
        summary.mean = float(flat.mean(dtype=np.float64))
        index = min(flat.size - 1, int(0.99 * flat.size))
        summary.p99 = float(np.partition(flat, index)[index])
        color = frame.group()
        summary.largest = float(max(np.nanmax(channel) for channel in color))
        summary.smallest = float(min(np.nanmin(channel) for channel in color))
        summary.constant = all(channel.min() == channel.max() for channel in color)


def thumbnail(frame: Frame, width: int) -> np.ndarray | None:
    """Linear RGB of the beauty, averaged down to about `width` pixels."""
    color = frame.group()
    if color is None:
        return None
    step = max(1, frame.header.size[0] // width)
    rows, columns = (extent // step * step for extent in color[0].shape)
    if rows == 0 or columns == 0:
        step, (rows, columns) = 1, color[0].shape
    stack = np.stack([np.nan_to_num(channel[:rows, :columns], posinf=0.0) for channel in color], axis=-1)
    return stack.reshape(rows // step, step, columns // step, step, 3).mean(axis=(1, 3)).astype(np.float16)
