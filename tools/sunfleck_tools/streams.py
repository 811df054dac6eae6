"""The standard streams, whatever they are: closed, full, or read by nobody.

Invariant: writing to them never raises; what becomes of a command is told by its exit code. Only
output that a disk would not take is a failure, which `lost` tells: who closes a pipe or a stream has
said that it is not wanted.
"""

import errno
import io
import os
import sys
from collections.abc import Callable
from typing import TextIO

UNWANTED = {errno.EPIPE, errno.EBADF, errno.ECONNRESET, errno.ESHUTDOWN}


class Patient(io.TextIOBase):
    """A text stream that goes silent where it cannot write."""

    def __init__(self, stream: TextIO | None):
        self.stream = stream
        self.lost: OSError | None = None
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None:
            # Names of files may be any bytes.
            reconfigure(errors="backslashreplace")

    def write(self, text: str) -> int:
        """Writes, or not."""
        self._try(lambda stream: stream.write(text))
        return len(text)

    def flush(self) -> None:
        """Flushes, or not."""
        self._try(lambda stream: stream.flush())

    def isatty(self) -> bool:
        """True if somebody watches."""
        try:
            return self.stream is not None and self.stream.isatty()
        except (OSError, ValueError):
            return False

    def fileno(self) -> int:
        """Of what is beneath."""
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
        """What is in buffers goes nowhere, lest Python complains at its end."""
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
    """Fills the standard descriptors that are closed, so that no file gets their numbers, and what is meant
    for the terminal."""
    for descriptor in (0, 1, 2):
        try:
            os.fstat(descriptor)
        except OSError:
            opened = os.open(os.devnull, os.O_RDWR)
            if opened != descriptor:
                os.dup2(opened, descriptor)
                os.close(opened)
            # Processes that are started have them too.
            os.set_inheritable(descriptor, True)


class patient_streams:
    """For a block, `sys.stdout` and `sys.stderr` never raise."""

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
