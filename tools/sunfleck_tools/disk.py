"""Files of the disk. Regular ones alone are read, and what is written appears whole or not at all.

Invariant: a file that was there before stays as it was until what replaces it lies on the
disk to its last byte.
"""

import errno
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from .errors import ToolError

KINDS = (
    (stat.S_ISDIR, "a folder"), (stat.S_ISFIFO, "a FIFO"), (stat.S_ISCHR, "a device"), (stat.S_ISBLK, "a device"),
    (stat.S_ISSOCK, "a socket"),
)  # fmt: skip


def need_regular(path: Path) -> int:
    """The size in bytes of a regular file; `OSError` of any other, which could be read for ever."""
    found = path.stat()
    if not stat.S_ISREG(found.st_mode):
        kind = next((name for is_kind, name in KINDS if is_kind(found.st_mode)), "something else")
        raise OSError(errno.EINVAL, f"it is {kind}, and only regular files are read", str(path))
    return found.st_size


def writable(path: Path) -> Path:
    """The path, once it is known that a file can be written there: before hours of work, not after."""
    if path.is_dir():
        raise ToolError(f"{path} is a folder: name a file")
    if not path.parent.is_dir():
        raise ToolError(f"there is no folder {path.parent} for {path.name}", is_usage=False)
    return path


def write_whole(path: Path, data: bytes) -> None:
    """Writes a file, or replaces one. Raises `ToolError`."""
    with writing(path) as file:
        file.write(data)


@contextmanager
def writing(path: Path) -> Iterator[BinaryIO]:
    """A file to write, which takes its name once the block has ended well. Raises `ToolError`, which says
    why it could not."""
    try:
        # Behind a link it is the file that is replaced, not the link.
        target = Path(os.path.realpath(path))
        if target.exists() and not target.is_file():
            # A device or a pipe takes what it gets; it is not replaced by a file.
            with target.open("wb") as file:
                yield file
            return
        part = target.with_name(f".{target.name}.{os.getpid()}.sunfleck-part")
        try:
            with part.open("wb") as file:
                yield file
                file.flush()
                os.fsync(file.fileno())
            os.replace(part, target)
        finally:
            part.unlink(missing_ok=True)
        _sync_folder(target.parent)
    except OSError as error:
        raise ToolError(f"cannot write {path}: {error.strerror or error}", is_usage=False) from error


def _sync_folder(folder: Path) -> None:
    """So that the name outlives a power cut, where the system can promise that."""
    with suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY | getattr(os, "O_DIRECTORY", 0))
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
