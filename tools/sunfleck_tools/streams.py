"""Standard streams that may be closed, full or without a reader.

Invariant: writing never raises, so a command's exit code tells its result. Only a failed write to a disk
is an error, in `lost`; a closed pipe or stream means that output is not wanted.
"""

import errno
import io
import os
import sys
from collections.abc import Callable
from typing import TextIO

UNWANTED = {errno.EPIPE, errno.EBADF, errno.ECONNRESET, errno.ESHUTDOWN}


class Patient(io.TextIOBase):
    """Text stream that becomes silent when it cannot write."""

    def __init__(self, stream: TextIO | None):
        self.stream = stream
        self.lost: OSError | None = None
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None:
            # Names of files may have any bytes.
            reconfigure(errors="backslashreplace")

    def write(self, text: str) -> int:
        """Writes if possible."""
        self._try(lambda stream: stream.write(text))
        return len(text)

    def flush(self) -> None:
        """Flushes if possible."""
        self._try(lambda stream: stream.flush())

    def isatty(self) -> bool:
        """True for a terminal."""
        try:
            return self.stream is not None and self.stream.isatty()
        except (OSError, ValueError):
            return False

    def fileno(self) -> int:
        """Descriptor of the underlying stream."""
        if self.stream is None:
            raise io.UnsupportedOperation("there is no stream")
        return self.stream.fileno()

    def _try(self, action: Callable[[TextIO], object]) -> None:
        if self.stream is None:
            return
        try:
            action(self.stream)
        except OSError as error:
            if error.errno not in UNWANTED:
                self.lost = error
            self._silence(self.stream)
        except ValueError:  # closed
            self.stream = None

    def _silence(self, stream: TextIO) -> None:
        """Discards buffers, so that Python does not complain on exit."""
        try:
            descriptor = stream.fileno()
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, descriptor)
            os.close(nowhere)
            stream.flush()
        except (OSError, ValueError):
            pass
        self.stream = None


def open_descriptors() -> None:
    """Opens closed standard descriptors, so that no file gets their numbers, and with them the terminal's
    output."""
    for descriptor in (0, 1, 2):
        try:
            os.fstat(descriptor)
        except OSError:
            opened = os.open(os.devnull, os.O_RDWR)
            if opened != descriptor:
                os.dup2(opened, descriptor)
                os.close(opened)
            # Child processes inherit them.
            os.set_inheritable(descriptor, True)


class patient_streams:
    """Makes `sys.stdout` and `sys.stderr` never raise during a block."""

    def __enter__(self) -> "patient_streams":
        open_descriptors()
        self._before = sys.stdout, sys.stderr
        self.output, self.errors = Patient(sys.stdout), Patient(sys.stderr)
        sys.stdout, sys.stderr = self.output, self.errors
        return self

    def __exit__(self, *_: object) -> None:
        self.output.flush()
        self.errors.flush()
        sys.stdout, sys.stderr = self._before
