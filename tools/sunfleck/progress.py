"""Progress of a run. In go the program's events, out comes a bar, or calls of a function."""

from collections.abc import Callable
from typing import Any

from sunfleck_tools.progress import Bar

from .errors import WrongType

Event = dict[str, Any]
Progress = Callable[[Event], None]
"""Called with each event of `--progress jsonl` (docs/command-line.md)."""


class EventBar:
    """Bar on standard error, if that is a terminal."""

    def __init__(self) -> None:
        self._bar = Bar()
        self._frames, self._done = 1, 0
        self._fractions: dict[int, float] = {}

    def __call__(self, event: Event) -> None:
        """Handles an event."""
        kind = event["event"]
        if kind == "started":
            self._frames = event["frames"]
        elif kind == "frame_progress":
            # Threads may report out of order.
            frame = event["frame"]
            self._fractions[frame] = max(self._fractions.get(frame, 0.0), event["fraction"])
        elif kind in ("frame_written", "frame_given_up", "frame_skipped"):
            self._done += 1
            self._fractions.pop(event["frame"], None)
        done = self._done + sum(self._fractions.values())
        share = 1.0 if kind == "finished" else min(1.0, done / max(1, self._frames))
        self._bar.show(share, f"frame {min(self._done + 1, self._frames)} of {self._frames}")

    def close(self) -> None:
        """Removes the bar."""
        self._bar.clear()


def watcher(progress: Progress | bool | None) -> Progress:
    """The given function; a bar for `None` and `True`, if there is a terminal; silence for `False`."""
    if callable(progress):
        return progress
    if progress is not None and not isinstance(progress, bool):
        raise WrongType(
            f"progress is {progress!r}: frames are read from the program's own events",
            "give it a function, which gets each event as a dict; True for a bar, or False for silence",
        )
    return (lambda event: None) if progress is False else EventBar()
