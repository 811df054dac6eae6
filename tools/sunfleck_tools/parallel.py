"""A function over many arguments in processes, with bounded memory, surviving a process that dies.

Invariant: results come in the arguments' order, one each.
"""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from typing import TypeVar

from .memory import keep_freed_memory

Argument, Result = TypeVar("Argument"), TypeVar("Result")
QUEUED_PER_PROCESS = 4


def in_processes(
    function: Callable[[Argument], Result],
    arguments: Sequence[Argument],
    processes: int,
    if_it_dies: Callable[[Argument], Result],
) -> Iterator[Result]:
    """`function` of each argument; of those that kill their process, `if_it_dies`. With 0 processes, in this one."""
    if processes == 0:
        yield from map(function, arguments)
        return
    waiting: list[tuple[Argument, Future[Result]]] = []
    remaining = iter(arguments)
    # Not fork: the caller may have threads.
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(processes, mp_context=context, initializer=keep_freed_memory)
    try:
        while True:
            while len(waiting) < processes * QUEUED_PER_PROCESS:
                argument = next(remaining, None)
                if argument is None:
                    break
                waiting.append((argument, pool.submit(function, argument)))
            if not waiting:
                return
            argument, future = waiting.pop(0)
            try:
                yield future.result()
            except BrokenProcessPool:
                # Any of those under way may be the cause: each of them again, alone.
                pool.shutdown(wait=False)
                for suspect in [argument, *(argument for argument, _ in waiting)]:
                    yield _alone(function, suspect, context, if_it_dies)
                waiting = []
                pool = ProcessPoolExecutor(processes, mp_context=context, initializer=keep_freed_memory)
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


def _alone(function, argument, context, if_it_dies):
    with ProcessPoolExecutor(1, mp_context=context) as pool:
        try:
            return pool.submit(function, argument).result()
        except BrokenProcessPool:
            return if_it_dies(argument)
