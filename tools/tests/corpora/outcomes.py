"""How a run ended to an outcome, and its first error to a sentence.

Invariant: the outcome is told by what can be seen from outside: exit code, signal, output,
memory, and the picture.
"""

import re
from enum import Enum

from sunfleck_tools.commands import IO, SCENE

from .limited import Ended, Limits


class Outcome(str, Enum):
    """What became of a file, from good to bad."""

    DONE = "done"
    WITH_LOSSES = "done with losses"
    BLACK_WITH_CAUSE = "black, said why"
    REFUSED = "refused"
    BLACK = "black"
    HANG = "hang"
    MEMORY = "too much memory"
    PANIC = "panic"
    TRACEBACK = "traceback"
    CRASH = "crash"
    OTHER_EXIT = "other exit"

    @property
    def is_fault(self) -> bool:
        """Of the program, whatever the file is."""
        return self not in (Outcome.DONE, Outcome.WITH_LOSSES, Outcome.BLACK_WITH_CAUSE, Outcome.REFUSED)

    def is_worse_than(self, other: "Outcome") -> bool:
        """By the order of this list."""
        order = list(Outcome)
        return order.index(self) > order.index(other)


REFUSALS = (SCENE, IO)
RUST_PANIC = 101
OUT_OF_MEMORY = re.compile(
    r"memory allocation of \d+ bytes failed|MemoryError|bad_alloc|the memory is not enough"
)
ERROR_LINE = re.compile(r"^(?:.*?: )?error(?:\[[\w-]+\])?: (?P<sentence>.*(?:(?<=:)\n\s+.*)?)$", re.MULTILINE)
"""What ends with a colon goes on in the next line."""
WARNING_LINE = re.compile(r"^(?:.*?: )?warning(?:\[(?P<id>[\w-]+)\])?: ", re.MULTILINE)


def outcome_of(ended: Ended, limits: Limits, findings: int | None = None) -> Outcome:
    """Without a look at the picture. A command that finds faults in files says so by the
    exit code `findings`."""
    said = ended.out + ended.err
    if ended.peak_bytes > limits.memory_bytes or (ended.code != 0 and OUT_OF_MEMORY.search(said)):
        return Outcome.MEMORY
    if ended.took_too_long:
        return Outcome.HANG
    if ended.code == RUST_PANIC or "panicked at" in ended.err:
        return Outcome.PANIC
    if "Traceback (most recent call last)" in ended.err:
        return Outcome.TRACEBACK
    if ended.code < 0:
        return Outcome.CRASH
    if ended.code == 0:
        return Outcome.WITH_LOSSES if WARNING_LINE.search(ended.err) else Outcome.DONE
    if ended.code == findings:
        return Outcome.WITH_LOSSES
    if ended.code in REFUSALS and ERROR_LINE.search(ended.err):
        return Outcome.REFUSED
    return Outcome.OTHER_EXIT


def loss_ids(ended: Ended) -> list[str]:
    """Of the warnings, in the order they are said."""
    return [match["id"] for match in WARNING_LINE.finditer(ended.err) if match["id"]]


def sentence_of(ended: Ended) -> str:
    """The first error that is said; without one, the last line."""
    if match := ERROR_LINE.search(ended.err):
        return " ".join(match["sentence"].split())
    lines = (ended.err.strip() or ended.out.strip()).splitlines()
    return lines[-1].strip() if lines else f"exit code {ended.code}, and not a word"


def group_of(sentence: str) -> str:
    """The sentence without what differs from file to file: names and numbers."""
    without_names = re.sub(r"`[^`]*`|\"[^\"]*\"|'[^']*'", "`…`", sentence)
    without_paths = re.sub(r"\S*/\S*", "…", without_names)
    return re.sub(r"\d+(?:\.\d+)?(?:e[-+]?\d+)?", "N", without_paths)
