"""Pixels of an EXR file by OpenEXR, and why there are none.

Invariant: whatever the file holds, the outcome is channels or a `DecodeError`, with nothing on the terminal. A decoder
that crashes takes the process along: that is the caller's to survive.
"""

from __future__ import annotations

import os
import re
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import OpenEXR

from .header import Header

LARGEST_COMPRESSION = 4096
"""Pixels' bytes per byte of file, as the renderer has it: deflate reaches 1032."""
LARGEST_PICTURE = 4 << 30
"""Bytes of pixels that are decoded at all."""


class DecodeError(Exception):
    """OpenEXR refused the file."""


def claims_too_much(header: Header, file_bytes: int) -> str | None:
    """A sentence if the header asks for more memory than the file can account for."""
    limit = min(file_bytes * LARGEST_COMPRESSION, LARGEST_PICTURE)
    if header.pixel_bytes <= limit:
        return None
    width, height = header.size
    return (
        f"the header claims {width} x {height} pixels, {header.pixel_bytes} bytes, "
        f"of which a file of {file_bytes} bytes can hold {limit} at most"
    )


def decode(path: Path) -> dict[str, np.ndarray]:
    """All channels of a flat, single-part file, by name, as stored."""
    with _captured() as said:
        try:
            part = OpenEXR.File(str(path), separate_channels=True)
            return {name: channel.pixels for name, channel in part.channels().items()}
        except (RuntimeError, ValueError, TypeError, MemoryError, OSError) as error:
            reason = _reason(said(), str(path)) or str(error)
    raise DecodeError(reason)


@contextmanager
def _captured() -> Iterator:
    """Keeps what the library prints, in C and in Python, and hands it to whoever asks."""
    sys.stdout.flush()
    sys.stderr.flush()
    with tempfile.TemporaryFile() as file:
        saved = os.dup(1), os.dup(2)

        def said() -> str:
            sys.stdout.flush()
            sys.stderr.flush()
            file.seek(0)
            return file.read().decode("utf-8", "replace")

        try:
            os.dup2(file.fileno(), 1)
            os.dup2(file.fileno(), 2)
            yield said
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            for descriptor, copy in zip((1, 2), saved):
                os.dup2(copy, descriptor)
                os.close(copy)


def _reason(said: str, path: str) -> str | None:
    """The library's first reason: the last ones are consequences."""
    for line in said.splitlines():
        match = re.match(re.escape(path) + r": \((\w+)\) (.*)", line)
        if match:
            return f"{match[2]} ({match[1]})"
    return None
