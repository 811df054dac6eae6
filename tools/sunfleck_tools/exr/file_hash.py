"""Hash of a whole file, stored in the file, as the renderer computes it (its module `frame_file`).

Invariant: any byte that is changed, added or removed changes it, in the header and the pixels.
"""

import hashlib
from mmap import mmap

NAME = "sunfleck:fileHash"
DIGITS = 64
HEAD = NAME.encode() + b"\0string\0" + DIGITS.to_bytes(4, "little")
"""Bytes before the attribute's value: name, type and size."""


def file_hash(data: mmap | bytes) -> tuple[str, str] | None:
    """Stored and computed hash, as hexadecimal digits; None without a complete stored one."""
    head = data.find(HEAD)
    start, end = head + len(HEAD), head + len(HEAD) + DIGITS
    if head < 0 or end > len(data):
        return None
    digest = hashlib.sha256()
    with memoryview(data) as whole:
        # The digits of the hash itself count as zeros.
        for part in (whole[:start], b"0" * DIGITS, whole[end:]):
            digest.update(part)
    return data[start:end].decode("ascii", "replace"), digest.hexdigest()
