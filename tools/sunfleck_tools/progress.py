"""A progress bar on the error stream, where somebody can see it."""

from __future__ import annotations

import sys
import time

WIDTH = 30
BETWEEN_S = 0.1


class Bar:
    """Call it with how many are done of how many; silent where the error stream is no terminal."""

    def __init__(self) -> None:
        self.visible = sys.stderr.isatty()
        self.began = self.shown = time.monotonic()

    def __call__(self, done: int, of: int) -> None:
        now = time.monotonic()
        if not self.visible or (done < of and now - self.shown < BETWEEN_S):
            return
        self.shown = now
        left = (now - self.began) * (of - done) / done
        filled = WIDTH * done // of
        bar = "#" * filled + "-" * (WIDTH - filled)
        end = "\r\x1b[K" if done == of else ""
        sys.stderr.write(f"\r[{bar}] {done} of {of}, about {left:.0f} s left\x1b[K{end}")
        sys.stderr.flush()
