"""The fingerprint of a whole file, which stands in the file itself, as the renderer computes it (its
module `frame_file`).

Invariant: any byte changed, added or taken away changes it, in the header as in the pixels.
"""

import hashlib
from mmap import mmap

NAME = "sunfleck:fileHash"
DIGITS = 64
HEAD = NAME.encode() + b"\0string\0" + DIGITS.to_bytes(4, "little")
"""Name, type and size: what stands before an attribute's value."""


def file_hash(data: mmap | bytes) -> tuple[str, str] | None:
    """The hash that a file carries and the one that it has, as hexadecimal digits; None if it carries
    none that is whole."""
    head = data.find(HEAD)
    start, end = head + len(HEAD), head + len(HEAD) + DIGITS
    if head < 0 or end > len(data):
        return None
    digest = hashlib.sha256()
    with memoryview(data) as whole:
        # Its own digits count as zeros.
        for part in (whole[:start], b"0" * DIGITS, whole[end:]):
            digest.update(part)
    return data[start:end].decode("ascii", "replace"), digest.hexdigest()
