"""Running program. In go arguments, out come its events or output.

Invariant: the program never outlives the call.
"""

import json
import logging
import os
import subprocess
import tempfile
import warnings
from collections.abc import Generator, Sequence
from contextlib import closing
from functools import lru_cache
from typing import IO

from sunfleck_tools.program import VARIABLE, find_program

from . import __version__
from .diagnostic import diagnostics
from .errors import ProgramError, SunfleckWarning, error_of
from .progress import Event

GRACE_S = 5.0
"""Time until a program that was asked to end is killed. Ending takes a tenth of a second."""
log = logging.getLogger("sunfleck")


def program() -> str:
    """Path of the program of this package's version. Raises `ProgramError`."""
    found = find_program()
    if found is None:
        named = os.environ.get(VARIABLE)
        if named:
            raise ProgramError(f"{VARIABLE} names {named}, and there is no such program: name one that is there, or unset it")
        where = "neither beside this Python nor on the PATH"
        raise ProgramError(f"there is no program sunfleck, {where}: install the wheel, or let {VARIABLE} name it")
    _need_this_version(found, os.stat(found).st_mtime_ns)
    return found


@lru_cache
def _need_this_version(path: str, _changed_ns: int) -> None:
    try:
        asked = subprocess.run([path, "--version"], stdin=subprocess.DEVNULL, capture_output=True, timeout=60)
    except (OSError, subprocess.TimeoutExpired) as error:
        raise ProgramError(f"{path} cannot be run ({error}): install the wheel that is made for this machine") from error
    words = asked.stdout.decode("utf-8", "replace").split()
    if asked.returncode != 0 or len(words) != 2 or words[0] != "sunfleck":
        raise ProgramError(f"{path} is not sunfleck: let {VARIABLE} name the program, or take it off the PATH")
    if words[1] != __version__:
        raise ProgramError(
            f"{path} is version {words[1]}, and this Python package {__version__}: "
            f"install both from one wheel, or let {VARIABLE} name a program of {__version__}"
        )


def events(arguments: Sequence[str]) -> Generator[Event, None, None]:
    """Runs the program and yields its events: the objects of `--progress jsonl`, one a line. Raises its
    error once it has ended; warnings become `SunfleckWarning`s, notes go to the logger `sunfleck`."""
    with closing(_lines([program(), *arguments])) as lines:
        for line in lines:
            try:
                event = json.loads(line)
            except ValueError as error:
                words = f"the program tells what is no JSON ({line[:80]!r}): let {VARIABLE} name sunfleck itself"
                raise ProgramError(words) from error
            yield event


def answer(arguments: Sequence[str]) -> bytes:
    """Runs the program to its end and returns its output. Raises as `events` does."""
    return b"".join(_lines([program(), *arguments]))


def _lines(command: Sequence[str]) -> Generator[bytes, None, None]:
    # A file in place of a pipe never fills up, so nobody has to read it meanwhile.
    with tempfile.TemporaryFile() as error_stream:
        process = _start(command, error_stream)
        assert process.stdout is not None
        try:
            yield from process.stdout
            process.wait()
        finally:
            process.stdout.close()
            _end(process)
        error_stream.seek(0)
        said = error_stream.read().decode("utf-8", "replace")
    if process.returncode != 0:
        raise error_of(process.returncode, said)
    for found in diagnostics(said):
        if found.severity == "warning":
            warnings.warn(found.text, SunfleckWarning, stacklevel=2)
        else:
            log.info(found.text)


def _start(command: Sequence[str], error_stream: IO[bytes]) -> subprocess.Popen[bytes]:
    try:
        return subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=error_stream)
    except OSError as error:
        raise ProgramError(f"{command[0]} cannot be run: {error.strerror or error}") from error


def _end(process: subprocess.Popen[bytes]) -> None:
    """Terminates the program, and waits for its end."""
    if process.poll() is not None:
        return
    process.terminate()
    try:
        process.wait(GRACE_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    except BaseException:  # a second Ctrl-C
        process.kill()
        process.wait()
        raise
