"""One file on its way through the checks: bytes, then pixels."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np

from .exr.header import Header

LUMINANCE = np.array([0.2126, 0.7152, 0.0722], np.float32)
"""Rec. 709, which frames are in."""


@dataclass
class FileBytes:
    """What became of reading and decoding a file; of the faults, the first that there was stops the rest."""

    number: int
    path: Path
    bytes: int = 0
    header: Header | None = None
    read_error: str | None = None
    header_error: str | None = None
    claim: str | None = None
    unsupported: str | None = None
    chunk_faults: list[str] = field(default_factory=list)
    decode_error: str | None = None


@dataclass
class Frame:
    """A decoded file. Channels are as stored: half, float or uint, rows from the top."""

    number: int
    path: Path
    header: Header
    channels: dict[str, np.ndarray]
    hash: str
    wide: dict[str, np.ndarray] = field(default_factory=dict)
    bits: dict[str, tuple[int, int]] = field(default_factory=dict)

    def float(self, name: str) -> np.ndarray:
        """A channel as float32, converted once."""
        if name not in self.wide:
            self.wide[name] = self.channels[name].astype(np.float32)
        return self.wide[name]

    def half_bits(self, name: str) -> tuple[int, int] | None:
        """Of a half channel the largest bits without the sign, and with it; integers compare faster than floats convert.

        Without the sign they grow with the magnitude: 0x7bff is the largest number, 0x7c00 infinity, more is NaN. With the
        sign, more than 0x8000 (minus zero) is a value below zero.
        """
        stored = self.channels[name]
        if stored.dtype != np.float16:
            return None
        if name not in self.bits:
            bits = stored.view(np.uint16)
            self.bits[name] = int((bits & 0x7FFF).max()), int(bits.max())
        return self.bits[name]

    def group(self, prefix: str = "") -> list[np.ndarray] | None:
        """The channels R, G and B of a layer, if it has them all."""
        names = [prefix + letter for letter in "RGB"]
        return [self.float(name) for name in names] if all(name in self.channels for name in names) else None

    @cached_property
    def luminance(self) -> np.ndarray | None:
        """Of the beauty; values that are not finite count as 0."""
        color = self.group()
        if color is None:
            return None
        total = sum(weight * channel for weight, channel in zip(LUMINANCE, color))
        return total if np.isfinite(total.sum()) else np.nan_to_num(total, copy=False, nan=0.0, posinf=0.0, neginf=0.0)

    def place(self, at: int) -> tuple[int, int]:
        """x and y in the full picture of the value with that flat index."""
        left, top = self.header.data_window[:2]
        y, x = divmod(int(at), self.header.size[0])
        return x + left, y + top
