"""A progress bar on the error stream, where somebody can see it."""

import sys
import time

WIDTH = 30
BETWEEN_S = 0.1
CLEARED = "\r\x1b[K"


class Bar:
    """Call it with how many are done of how many; silent where the error stream is no terminal."""

    def __init__(self) -> None:
        self.visible = sys.stderr is not None and sys.stderr.isatty()
        self.began = self.shown = time.monotonic()

    def __call__(self, done: int, of: int) -> None:
        self.show(done / of, f"{done} of {of}")

    def show(self, share: float, what: str) -> None:
        """A share of 0 to 1, and what it is of. At 1 the bar goes."""
        now = time.monotonic()
        if not self.visible or (share < 1 and now - self.shown < BETWEEN_S):
            return
        self.shown = now
        left = f", about {(now - self.began) * (1 - share) / share:.0f} s left" if share > 0 else ""
        filled = int(WIDTH * share)
        bar = "#" * filled + "-" * (WIDTH - filled)
        sys.stderr.write(f"\r[{bar}] {what}{left}\x1b[K{CLEARED if share >= 1 else ''}")
        sys.stderr.flush()

    def clear(self) -> None:
        """Of a run that ended early."""
        if self.visible:
            sys.stderr.write(CLEARED)
            sys.stderr.flush()
