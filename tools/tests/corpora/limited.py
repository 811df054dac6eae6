"""A program under limits, to how it ended.

Invariant: it, and whatever it started, is gone when the outcome is there.
"""

import os
import signal
import subprocess
import tempfile
import threading
from collections.abc import Sequence
from dataclasses import dataclass, field

ADDRESSES_PER_MEMORY = 3
"""Addresses that are reserved (threads' stacks, files in memory) are no memory: so many times the limit
may be asked for."""
UNDER_LIMITS = 'ulimit -c 0; ulimit -S -t "$1"; ulimit -v "$2"; shift 2; exec "$@"'
TEXT_BYTES = 1 << 20
"""Of what a program says are looked at."""


@dataclass(frozen=True)
class Limits:
    """Of one run: processor seconds of all threads, bytes resident at once, and seconds by the clock. The
    last are for programs that wait: other work on the machine makes a second of the processor longer."""

    cpu_s: int = 60
    memory_bytes: int = 2 << 30
    wall_s: float = 300


@dataclass(frozen=True)
class Ended:
    """How a run ended; `code` is negative after a signal, as `subprocess` has it."""

    code: int
    out: str
    err: str
    cpu_s: float
    peak_bytes: int
    took_too_long: bool


def run_limited(
    command: Sequence[object], limits: Limits, environment: dict[str, str] | None = None
) -> Ended:
    """Runs the command to its end, or to the limits'. Raises `OSError` if there is no `sh`."""
    addresses_kb = limits.memory_bytes * ADDRESSES_PER_MEMORY // 1024
    line = ["sh", "-c", UNDER_LIMITS, "sh", str(limits.cpu_s), str(addresses_kb), *map(str, command)]
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        process = subprocess.Popen(
            line, stdin=subprocess.DEVNULL, stdout=out, stderr=err, env=environment, start_new_session=True
        )  # fmt: skip
        watch = _Watch(process.pid, limits.wall_s)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        watch.end()
        return Ended(
            process.returncode, _text(out), _text(err), usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024,
            watch.has_barked or process.returncode == -signal.SIGXCPU,
        )  # fmt: skip


@dataclass
class _Watch:
    """Kills a process group after its time, and what is left of it at the end."""

    group: int
    wall_s: float
    has_barked: bool = False
    timer: threading.Timer = field(init=False)

    def __post_init__(self) -> None:
        self.timer = threading.Timer(self.wall_s, self._bark)
        self.timer.daemon = True
        self.timer.start()

    def end(self) -> None:
        self.timer.cancel()
        self._kill()

    def _bark(self) -> None:
        self.has_barked = True
        self._kill()

    def _kill(self) -> None:
        try:
            os.killpg(self.group, signal.SIGKILL)
        except (ProcessLookupError, PermissionError):
            # Nothing is left of it.
            pass


def _text(file) -> str:
    file.seek(0)
    return file.read(TEXT_BYTES).decode("utf-8", "replace")
