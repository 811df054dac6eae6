"""A function over many arguments in processes, with bounded memory, surviving a process that dies.

Invariant: results come in the arguments' order, one each; and no process outlives the one that started
it, however that ends.
"""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnContext
from typing import TypeVar

from .memory import keep_freed_memory

Argument = TypeVar("Argument")
Result = TypeVar("Result")
QUEUED_PER_PROCESS = 4
KILLED = "the system ended the process that decoded a frame, most likely for want of memory"
WAITING = (signal.SIGINT, signal.SIGTERM)
NOT_BEGUN = "no process that decodes could be started, most likely for want of memory"


def in_processes(
    function: Callable[[Argument], Result],
    arguments: Sequence[Argument],
    processes: int,
    if_it_dies: Callable[[Argument], Result],
) -> Iterator[Result]:
    """`function` of each argument; of those that crash their process, `if_it_dies`. With 0
    processes, in this one.

    Raises what `function` raises, and `MemoryError` where the system killed a process.
    """
    if processes == 0:
        yield from map(function, arguments)
        return
    _learn_of_ends()
    waiting: list[tuple[Argument, Future[Result]]] = []
    remaining = iter(arguments)
    # Not fork: the caller may have threads.
    context = multiprocessing.get_context("spawn")
    others = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(processes, mp_context=context, initializer=begin_work)
    try:
        while True:
            while len(waiting) < processes * QUEUED_PER_PROCESS:
                argument = next(remaining, None)
                if argument is None:
                    break
                with _signals_later():
                    waiting.append((argument, pool.submit(function, argument)))
            if not waiting:
                return
            argument, future = waiting.pop(0)
            try:
                yield future.result()
            except BrokenProcessPool:
                # Any of those under way may be the cause: each of them again, alone.
                pool.shutdown()
                for suspect in [argument, *(argument for argument, _ in waiting)]:
                    yield _alone(function, suspect, context, if_it_dies)
                waiting = []
                pool = ProcessPoolExecutor(processes, mp_context=context, initializer=begin_work)
    except BaseException:
        # Nobody waits for results any more, not for those that are under way either.
        for process in set(multiprocessing.active_children()) - others:
            process.kill()
        raise
    finally:
        # Waited for: the interpreter's end and the pool's own thread would race for the pipe
        # between them (Python 3.11).
        pool.shutdown(cancel_futures=True)


def _learn_of_ends() -> None:
    """Who starts a program may leave it SIGCHLD ignored, and the system then keeps from it that a process has
    ended: Python waits for ever, busily."""
    is_main = threading.current_thread() is threading.main_thread()
    if is_main and hasattr(signal, "SIGCHLD") and signal.getsignal(signal.SIGCHLD) is signal.SIG_IGN:
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)


def begin_work() -> None:
    """Of a process that works for another: it ends with that one."""
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGTERM})
    threading.Thread(target=_end_with_parent, daemon=True).start()
    keep_freed_memory()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
    os._exit(1)


@contextmanager
def _signals_later() -> Iterator[None]:
    """For a block that starts processes, signals wait, lest one is left half started. Ctrl-C waits in the
    processes for ever: it is for the one that started them."""
    if threading.current_thread() is not threading.main_thread() or not hasattr(signal, "pthread_sigmask"):
        yield
        return
    heard: list[int] = []
    # A mask is inherited, and a signal that another thread of this process gets is heard here all the same.
    handlers = {number: signal.signal(number, lambda number, _: heard.append(number)) for number in WAITING}
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, WAITING)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        for number, handler in handlers.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)
        for first in heard[:1]:
            signal.raise_signal(first)


def _alone(
    function: Callable[[Argument], Result],
    argument: Argument,
    context: SpawnContext,
    if_it_dies: Callable[[Argument], Result],
) -> Result:
    ours, theirs = context.Pipe(duplex=False)
    process = context.Process(target=_answer, args=(function, argument, theirs), daemon=True)
    with _signals_later():
        process.start()
    theirs.close()
    has_begun = False
    try:
        has_begun = ours.recv()
        is_result, answer = ours.recv()
    except EOFError:
        process.join()
        if not has_begun:
            raise MemoryError(NOT_BEGUN) from None
        if process.exitcode == -signal.SIGKILL:
            raise MemoryError(KILLED) from None
        return if_it_dies(argument)
    finally:
        ours.close()
    process.join()
    if not is_result:
        raise answer
    return answer


def _answer(function: Callable[[Argument], object], argument: Argument, pipe: Connection) -> None:
    begin_work()
    pipe.send(True)
    answer: tuple[bool, object]
    try:
        answer = True, function(argument)
    except Exception as error:
        answer = False, error
    pipe.send(answer)
