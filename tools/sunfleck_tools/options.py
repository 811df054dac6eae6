"""Options of a validation."""

from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path


@dataclass(frozen=True)
class Options:
    """The defaults suit a sequence that one command rendered."""

    frames: tuple[int, ...] | None = None
    """The frames that must be there; `None` is all from the first to the last found, and those that
    `stats` tells of."""
    fps: Fraction | None = None
    """The frame rate that every file must carry; `None` is the one that most of them carry."""
    reference: Path | None = None
    """A folder or pattern of reference frames to compare with, by number."""
    max_relmse: float = 0.01
    """Largest relative mean square error against the reference."""
    max_flip: float | None = None
    """Largest mean FLIP against the reference; needs the extra `flip`."""
    stats: Path | None = None
    """What `sunfleck render --stats` wrote, for render times in the report."""
    skip_checks: frozenset[str] = frozenset()
    """Ids of checks that are not run."""
    static: bool = False
    """Nothing moves: frames may be equal to the ones before."""
    processes: int | None = None
    """Processes that decode; `None` is one for each processor. 0 decodes in the caller's own: quicker for a
    few small frames, but a decoder that crashes takes the caller along."""
    thumbnails: bool = False
    """Keep small pictures of the frames, for a report."""
