"""Hash of a file's pixels, as the renderer computes it (its module `frame_file` defines the order of bytes).

Invariant: it depends on the channels' names, types and stored bits alone.
"""

import hashlib
from collections.abc import Mapping

import numpy as np

STORED = {"e": (b"half", "<f2"), "f": (b"float", "<f4"), "I": (b"uint", "<u4"), "L": (b"uint", "<u4")}


def pixel_hash(channels: Mapping[str, np.ndarray]) -> str:
    """SHA-256 over all channels, as hexadecimal digits."""
    digest = hashlib.sha256()
    for name, pixels in sorted(channels.items(), key=lambda item: item[0].encode()):
        kind, stored = STORED[pixels.dtype.char]
        digest.update(name.encode() + b"\0" + kind + b"\0")
        digest.update(np.ascontiguousarray(pixels, dtype=stored).data)
    return digest.hexdigest()
