"""Progress bar on standard error, if it is a terminal."""

import sys
import time

WIDTH = 30
BETWEEN_S = 0.1
CLEARED = "\r\x1b[K"


class Bar:
    """Callable with the numbers done and in all; silent if standard error is no terminal."""

    def __init__(self) -> None:
        self.visible = sys.stderr is not None and sys.stderr.isatty()
        self.began = self.shown = time.monotonic()

    def __call__(self, done: int, of: int) -> None:
        self.show(done / of, f"{done} of {of}")

    def show(self, share: float, what: str) -> None:
        """Shows a fraction from 0 to 1 and its subject. At 1 the bar is removed."""
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
        """Removes the bar of a run that ended early."""
        if self.visible:
            sys.stderr.write(CLEARED)
            sys.stderr.flush()
