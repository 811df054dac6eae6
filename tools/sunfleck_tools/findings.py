"""Findings, and the registry of checks.

Invariant: a published id keeps its meaning, as scripts filter by it.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import Enum
from typing import Any, NamedTuple


class Severity(str, Enum):
    """Severity: an error makes a frame unusable or wrong, a warning needs a look."""

    ERROR = "error"
    WARNING = "warning"


class Scope(str, Enum):
    """Subject of a check; each scope has one type of argument."""

    LISTING = "listing"  # sequence.Listing: names alone
    FILE = "file"  # frame.FileBytes: header and chunks, nothing decoded
    FRAME = "frame"  # frame.Frame: decoded pixels
    SEQUENCE = "sequence"  # summary.Rendered: all frames, in order of their numbers


class Found(NamedTuple):
    """Result of a check: a sentence, and its place."""

    message: str
    frame: int | None = None
    path: str | None = None
    channel: str | None = None
    pixel: tuple[int, int] | None = None


@dataclass(frozen=True)
class Finding:
    """`Found` with its check."""

    check: str
    severity: Severity
    message: str
    frame: int | None = None
    path: str | None = None
    channel: str | None = None
    pixel: tuple[int, int] | None = None

    def line(self) -> str:
        """One line of text, beginning with the frame."""
        where = f"frame {self.frame}" if self.frame is not None else "sequence"
        file = f" ({self.path})" if self.path else ""
        return f"{self.severity.value}: {where}: {self.message} [{self.check}]{file}"


@dataclass(frozen=True)
class Check:
    """A registered function."""

    id: str
    severity: Severity
    scope: Scope
    about: str
    rerender: bool
    function: Callable[[Any], Iterator[Found]]

    def run(self, subject: Any) -> Iterator[Finding]:
        """Findings in `subject`, whose type depends on the scope."""
        for found in self.function(subject):
            yield Finding(self.id, self.severity, *found)


CHECKS: dict[str, Check] = {}


def check(
    id: str, severity: Severity, scope: Scope, about: str, rerender: bool = False
) -> Callable[[Callable[[Any], Iterator[Found]]], Callable[[Any], Iterator[Found]]]:
    """Registers a function; `rerender` means that its frames belong into `--list-missing`."""

    def register(function: Callable[[Any], Iterator[Found]]) -> Callable[[Any], Iterator[Found]]:
        if id in CHECKS:
            raise ValueError(f"two checks have the id {id}")
        CHECKS[id] = Check(id, severity, scope, about, rerender, function)
        return function

    return register


def checks_of(scope: Scope) -> list[Check]:
    """All checks of one scope, in the order of their registration."""
    return [entry for entry in CHECKS.values() if entry.scope is scope]


def ordered(findings: list[Finding]) -> list[Finding]:
    """Worst findings first, then by frame."""
    rank = {Severity.ERROR: 0, Severity.WARNING: 1}
    first = float("-inf")
    return sorted(
        findings, key=lambda f: (rank[f.severity], first if f.frame is None else f.frame, f.check, f.message)
    )
