"""Options of a validation."""

from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path


@dataclass(frozen=True)
class Options:
    """The defaults suit a sequence that one command rendered."""

    frames: tuple[int, ...] | None = None
    """Expected frames; `None` is all from the first to the last found, and those in `stats`."""
    fps: Fraction | None = None
    """Expected frame rate of every file; `None` is that of the majority."""
    reference: Path | None = None
    """A folder or pattern of reference frames to compare with, by number."""
    max_relmse: float = 0.01
    """Largest relative mean square error against the reference."""
    max_flip: float | None = None
    """Largest mean FLIP against the reference; needs the extra `flip`."""
    stats: Path | None = None
    """File of `sunfleck render --stats`, for render times in the report."""
    skip_checks: frozenset[str] = frozenset()
    """Ids of checks to skip."""
    static: bool = False
    """True if nothing moves: frames may equal their predecessors."""
    processes: int | None = None
    """Number of decoding processes; `None` is one a processor. 0 decodes in the caller's process: faster
    for a few small frames, but a crash of the decoder ends the caller."""
    thumbnails: bool = False
    """Whether to keep small pictures of the frames, for a report."""
