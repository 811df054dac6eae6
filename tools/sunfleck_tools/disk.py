"""Files on the disk. Only regular files are read, and written files appear whole or not at all.

Invariant: an existing file is unchanged until its replacement is completely on the disk.
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
    """Size in bytes of a regular file; `OSError` for any other, as reading it might never end."""
    found = path.stat()
    if not stat.S_ISREG(found.st_mode):
        kind = next((name for is_kind, name in KINDS if is_kind(found.st_mode)), "something else")
        raise OSError(errno.EINVAL, f"it is {kind}, and only regular files are read", str(path))
    return found.st_size


def writable(path: Path) -> Path:
    """Returns the path after checking that a file can be written there: before hours of work, not after."""
    if path.is_dir():
        raise ToolError(f"{path} is a folder: name a file")
    if not path.parent.is_dir():
        raise ToolError(f"there is no folder {path.parent} for {path.name}", is_usage=False)
    return path


def write_whole(path: Path, data: bytes) -> None:
    """Writes or replaces a file. Raises `ToolError`."""
    with writing(path) as file:
        file.write(data)


@contextmanager
def writing(path: Path) -> Iterator[BinaryIO]:
    """Opens a file for writing, which gets its name when the block ends normally. Raises `ToolError` with
    the reason of a failure."""
    try:
        # A link stays; its target is replaced.
        target = Path(os.path.realpath(path))
        if target.exists() and not target.is_file():
            # Devices and pipes are written to, not replaced.
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
    """Flushes the folder, so that the name survives a power failure where the system supports it."""
    with suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY | getattr(os, "O_DIRECTORY", 0))
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
