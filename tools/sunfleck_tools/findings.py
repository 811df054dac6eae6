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
    about: str
    rerender: bool
    function: Callable[[Any], Iterator[Found]]

    @property
    def subject(self) -> type:
        """Type of the function's argument: `sequence.Listing` (names alone), `frame.FileBytes` (header and chunks),
        `frame.Frame` (decoded pixels), or `summary.Rendered` (all frames, in order of their numbers)."""
        return next(iter(self.function.__annotations__.values()))


CHECKS: dict[str, Check] = {}


def check(
    id: str, severity: Severity, about: str, rerender: bool = False
) -> Callable[[Callable[[Any], Iterator[Found]]], Callable[[Any], Iterator[Found]]]:
    """Registers a function; `rerender` means that its frames belong into `--list-missing`."""

    def register(function: Callable[[Any], Iterator[Found]]) -> Callable[[Any], Iterator[Found]]:
        if id in CHECKS:
            raise ValueError(f"two checks have the id {id}")
        CHECKS[id] = Check(id, severity, about, rerender, function)
        return function

    return register


def findings_in(subject: object, skipped: frozenset[str]) -> Iterator[Finding]:
    """Findings of all checks of this type of subject, in the order of their registration."""
    for entry in CHECKS.values():
        if isinstance(subject, entry.subject) and entry.id not in skipped:
            for found in entry.function(subject):
                yield Finding(entry.id, entry.severity, *found)


def ordered(findings: list[Finding]) -> list[Finding]:
    """Worst findings first, then by frame."""
    rank = {Severity.ERROR: 0, Severity.WARNING: 1}
    first = float("-inf")
    return sorted(
        findings, key=lambda f: (rank[f.severity], first if f.frame is None else f.frame, f.check, f.message)
    )
