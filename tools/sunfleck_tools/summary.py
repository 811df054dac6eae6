"""Summary of a frame without its pixels.

Invariant: a summary has a few kB, so thousands of them fit into memory.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from .exr.colors import color_space
from .exr.header import COMPRESSIONS, Header
from .findings import Finding, Found
from .frame import Frame, row_blocks, wide
from .options import Options

PROVENANCE = ("version", "sceneHash", "settingsHash", "seed", "pixelHash", "fileHash", "sequenceFrames")


@dataclass
class Suspicion:
    """Suspicions that need neighbouring frames, in pixels of the full picture."""

    fireflies: list[tuple[int, int, float, float]] = field(default_factory=list)
    """As `checks.fireflies.Candidate`."""
    blocks: list[tuple[int, int, int, int]] = field(default_factory=list)
    """As `checks.blocks.Block`."""
    window: tuple[int, int, int, int] = (0, 0, 0, 0)
    """Data window."""

    def __bool__(self) -> bool:
        return bool(self.fireflies or self.blocks)


@dataclass
class FrameSummary:
    """Summary of one frame; fields that need pixels are `None` without them."""

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
    suspicion: Suspicion = field(default_factory=Suspicion)
    fireflies: list[tuple[int, int, float, float]] = field(default_factory=list)
    black_blocks: list[tuple[int, int, int, int]] = field(default_factory=list)
    signature: np.ndarray | None = None
    relmse: float | None = None
    flip: float | None = None
    reference_error: str | None = None
    render_seconds: float | None = None
    thumbnail: np.ndarray | None = None
    findings: list[Finding] = field(default_factory=list)

    @property
    def decoded(self) -> bool:
        """True if pixels were decoded."""
        return self.hash is not None

    def found(self, message: str, pixel: tuple[int, int] | None = None) -> Found:
        """Finding of a sequence's check about this frame."""
        return Found(message, self.number, self.path, pixel=pixel)


@dataclass
class Rendered:
    """All frames of a sequence, ascending, and the options."""

    frames: list[FrameSummary]
    options: Options
    is_still: bool = False
    """True for a single picture without a number in its name."""

    @property
    def decoded(self) -> list[FrameSummary]:
        """Frames with decoded pixels."""
        return [frame for frame in self.frames if frame.decoded]


def describe(summary: FrameSummary, headers: Sequence[Header]) -> None:
    """Sets the fields from the headers."""
    header = headers[0]
    for name in ("framesPerSecond", "imageCounter", "timeCode", "Frame"):
        if name in header.values:
            summary.attributes[name] = header.values[name]
    for name in PROVENANCE:
        if (value := header.text(f"sunfleck:{name}")) is not None:
            summary.provenance[name] = value
    types = ("uint", "half", "float")
    summary.structure = {
        "channels": "; ".join(_channels(part, types) for part in headers),
        "display window": header.display_window,
        "data window": header.data_window,
        "compression": ", ".join(dict.fromkeys(COMPRESSIONS[part.compression] for part in headers)),
        "layout": ", ".join(dict.fromkeys("tiles" if part.is_tiled else "scan lines" for part in headers)),
        "colour space": color_space(header),
        "pixel aspect": header.values.get("pixelAspectRatio"),
    }


def _channels(header: Header, types: tuple[str, ...]) -> str:
    named = ", ".join(f"{channel.name} ({types[channel.type]})" for channel in header.channels)
    return f"{header.name}: {named}" if header.name else named


def measure(summary: FrameSummary, frame: Frame, luminance: np.ndarray | None) -> None:
    """Sets the fields from the pixels; reorders `luminance`, the frame's own."""
    summary.hash = frame.hash
    if luminance is not None:
        flat = luminance.ravel()
        # Single precision with pairwise sums: accurate to about 1e-6.
        summary.mean = float(flat.mean())
        index = min(flat.size - 1, int(0.99 * flat.size))
        ranges = [frame.extremes(name) for name in frame.picture]
        summary.smallest, summary.largest = min(low for low, _ in ranges), max(high for _, high in ranges)
        # In place, as new memory costs as much as the search. Non-negative floats are ordered like their
        # bits, and integers are searched twice as fast.
        (flat.view(np.int32) if all(low >= 0 for low, _ in ranges) else flat).partition(index)
        summary.p99 = float(flat[index])
        summary.constant = all(low == high for low, high in ranges)


def thumbnail(frame: Frame, width: int) -> np.ndarray | None:
    """Linear RGB of the picture, averaged to about `width` pixels; values that are not finite count as 0."""
    if not frame.picture:
        return None
    is_plain = len(frame.picture) == 3 and frame.space.is_ours
    colors = [frame.channels[name] for name in frame.picture] if is_plain else frame.shown()
    colors = [frame.on_canvas(color) for color in colors]
    step = max(1, min(frame.canvas[1] // width, *frame.canvas))
    rows, columns = (extent // step for extent in frame.canvas)
    small = np.empty((rows, columns, 3), np.float32)
    for index, color in enumerate(colors):
        stored = color[: rows * step, : columns * step]
        for block in row_blocks((rows * step, columns * step), step):
            light = wide(stored[block])
            if not np.isfinite([light.min(), light.max()]).all():
                np.nan_to_num(light, copy=False, nan=0.0, posinf=0.0, neginf=0.0)
            lines = light.reshape(-1, step, columns * step).sum(axis=1)
            small[block.start // step : block.stop // step, :, index] = lines.reshape(-1, columns, step).sum(
                axis=2
            )
    return (small / step**2).astype(np.float16)
