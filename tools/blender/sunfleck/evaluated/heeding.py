"""Work on large arrays while somebody may lose interest in it.

In goes a function of arrays, out comes what it gives; whoever is asked in between raises to end the waiting. The
work then goes on unheard. Invariant: it is done elsewhere, so it asks Blender nothing and writes nothing.
"""

from concurrent.futures import ThreadPoolExecutor

# How often one is asked, seconds; what has fewer rows is done before that.
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
    """Nobody loses interest."""
