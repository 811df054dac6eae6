"""Memory-mapped files, of which only accessed bytes are read.

Invariant: other bytes take no memory. If another process truncates the file, this process crashes, as a
decoder may; `parallel` handles that.
"""

import mmap
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ..disk import need_regular


@contextmanager
def mapped(path: Path) -> Iterator[mmap.mmap | bytes]:
    """Bytes of a file during the block. Raises `OSError`, also for files that are not regular."""
    need_regular(path)
    with path.open("rb") as file:
        try:
            data = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        except (ValueError, OSError):  # an empty file; a file system that cannot map
            yield file.read()
            return
        with data:
            if hasattr(mmap, "MADV_RANDOM"):
                # Only headers and 8 bytes a chunk are read, so no read-ahead.
                data.madvise(mmap.MADV_RANDOM)
            yield data
