"""Reuse of freed memory for the next frame.

By default, glibc returns a channel's pages to the system after every frame, and each comes back cleared by
a page fault: a fifth of the time for decoding. Invariant: a process keeps at most its peak memory.
"""

import ctypes

TRIM_THRESHOLD, TOP_PAD, MMAP_THRESHOLD = -1, -2, -3
"""Parameters of glibc's `mallopt`, by its `malloc.h`."""
KEPT_BYTES = (1 << 31) - 1
KEPT_BYTES_AT_ONCE = 32 << 20
"""Largest threshold of glibc before 2.35."""
GROWTH_BYTES = 64 << 20
"""Growth of the heap: address space, used once it is written to."""


def keep_freed_memory() -> None:
    """Applies to this process from now on. Does nothing if the C library has no `mallopt`."""
    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (AttributeError, OSError, TypeError):
        return
    mallopt(MMAP_THRESHOLD, KEPT_BYTES) or mallopt(MMAP_THRESHOLD, KEPT_BYTES_AT_ONCE)
    mallopt(TRIM_THRESHOLD, KEPT_BYTES)
    mallopt(TOP_PAD, GROWTH_BYTES)
