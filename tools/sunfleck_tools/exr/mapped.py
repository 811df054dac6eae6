"""The bytes of a file without reading those that nobody looks at.

Invariant: no memory is taken by what is not looked at. A file that is cut off by somebody meanwhile takes the
process along, as a decoder may: `parallel` survives it.
"""

import mmap
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ..disk import need_regular


@contextmanager
def mapped(path: Path) -> Iterator[mmap.mmap | bytes]:
    """The file's bytes, for as long as the block lasts. Raises `OSError`, also of what is no regular file."""
    need_regular(path)
    with path.open("rb") as file:
        try:
            data = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
        except (ValueError, OSError):  # an empty file; a file system that cannot map
            yield file.read()
            return
        with data:
            if hasattr(mmap, "MADV_RANDOM"):
                # A header and 8 bytes a chunk are looked at: no need of the pages around them.
                data.madvise(mmap.MADV_RANDOM)
            yield data
