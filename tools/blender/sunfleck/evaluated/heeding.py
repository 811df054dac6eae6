"""Cancellable work on large arrays.

In goes a function of arrays, out comes its result; a callback that is polled raises to cancel. The work
then ends by itself. Invariant: it runs on another thread, so it does not use Blender and writes nothing.
"""

from concurrent.futures import ThreadPoolExecutor

# Interval of polling, seconds; smaller arrays finish before that.
LOOK_S = 0.02
MANY_ROWS = 50_000


def heeding(heed, rows, work):
    heed()
    if rows < MANY_ROWS:
        return work()
    pool = ThreadPoolExecutor(max_workers=1)
    try:
        done = pool.submit(work)
        while True:
            try:
                return done.result(LOOK_S)
            except TimeoutError:
                heed()
    finally:
        pool.shutdown(wait=False)


def nobody():
    """A callback that never cancels."""
