"""Pixels of an EXR file, by OpenEXR. In goes a path, out come channels or an error.

Invariant: every file gives channels or a `DecodeError`, and nothing on the terminal. A crash of the
decoder ends the process, which callers have to handle.
"""

import os
import re
import sys
import tempfile
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import OpenEXR

from .header import Channel, Header

LARGEST_COMPRESSION = 4096
"""Maximum bytes of pixels per byte of file, as in the renderer: deflate reaches 1032."""
LARGEST_PICTURE = 4 << 30
"""Maximum bytes of decoded pixels."""


OUT_OF_MEMORY = ("bad_alloc", "EXR_ERR_OUT_OF_MEMORY", "MemoryError", "Unable to allocate")
"""Texts in the library's messages."""
COPIES, SPARE_BYTES = 2, 64 << 20
"""Memory for decoding: copies of the pixels in the library and in numpy, and buffers."""
NOT_READ = "Exception raised reading pixel data"
ONE_AT_A_TIME = threading.Lock()
"""Captures standard output of the process, which only one thread may do at a time."""


class DecodeError(Exception):
    """OpenEXR refused the file."""


def claims_too_much(headers: Sequence[Header], file_bytes: int) -> str | None:
    """Sentence if the headers together require more memory than the file's size allows."""
    limit = min(file_bytes * LARGEST_COMPRESSION, LARGEST_PICTURE)
    claimed = sum(header.pixel_bytes for header in headers)
    if claimed <= limit:
        return None
    width, height = max((header.size for header in headers), key=lambda size: size[0] * size[1])
    return (
        f"the header claims {width} x {height} pixels, {claimed} bytes, "
        f"of which a file of {file_bytes} bytes can hold {limit} at most"
    )


def decode(path: Path) -> dict[str, np.ndarray]:
    """Channels of a file's first part by name, as stored."""
    return decode_parts(path)[0]


def decode_parts(path: Path, pixel_bytes: int = 0) -> list[dict[str, np.ndarray]]:
    """Channels of each part, `pixel_bytes` in all. Raises `DecodeError`, or `MemoryError` if memory does
    not suffice."""
    with _captured() as said:
        parts, failure = [], ""
        try:
            file = OpenEXR.File(os.fsencode(path), separate_channels=True)
            parts = [{name: channel.pixels for name, channel in part.channels.items()} for part in file.parts]
        except MemoryError:
            failure = OUT_OF_MEMORY[0]
        except (RuntimeError, ValueError, TypeError, OSError) as error:
            failure = str(error)
        # For an unreadable part the library prints the reason, and skips it.
        words = said()
        if NOT_READ in words:
            failure = failure or words[words.index(NOT_READ) :].splitlines()[0]
    # A damaged file may request any amount; memory is really short only if the pixels do not fit.
    if any(sign in words + failure for sign in OUT_OF_MEMORY) and not _could_hold(
        COPIES * pixel_bytes + SPARE_BYTES
    ):
        raise MemoryError(f"memory is not enough to decode {path}")
    if failure:
        raise DecodeError(_reason(words, str(path)) or failure)
    return parts


def _could_hold(size: int) -> bool:
    """True if the system grants this many bytes."""
    try:
        np.empty(size, np.uint8)
    except MemoryError:
        return False
    return True


def full_size(header: Header, channel: Channel, stored: np.ndarray) -> np.ndarray:
    """Channel at full resolution: subsampled values are repeated. Raises `DecodeError`."""
    across, down = channel.sampling
    width, height = header.size
    if channel.sampling != (1, 1):
        stored = np.repeat(np.repeat(stored, down, axis=0), across, axis=1)[:height, :width]
    if stored.shape != (height, width):
        raise DecodeError(
            f"{channel.name} has {stored.shape[1]} x {stored.shape[0]} values, not {width} x {height}"
        )
    return stored


@contextmanager
def _captured() -> Iterator:
    """Captures the library's output, in C and in Python; the value returns it."""
    with ONE_AT_A_TIME:
        yield from _captured_alone()


def _captured_alone() -> Iterator:
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
    """First error of the library; later ones are consequences."""
    for line in said.splitlines():
        match = re.match(re.escape(path) + r": \((\w+)\) (.*)", line)
        if match:
            return f"{match[2]} ({match[1]})"
    return None
