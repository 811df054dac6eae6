"""Parallel map in processes, with bounded memory and tolerance of crashes.

Invariant: results are in the arguments' order, one each; no process outlives its parent, however that
ends.
"""

import multiprocessing
import os
import signal
import sys
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
_MAIN = threading.Lock()
NOT_BEGUN = "no process that decodes could be started, most likely for want of memory"


def in_processes(
    function: Callable[[Argument], Result],
    arguments: Sequence[Argument],
    processes: int,
    if_it_dies: Callable[[Argument], Result],
) -> Iterator[Result]:
    """Yields `function` of each argument, or `if_it_dies` of one that crashes its process. With 0 processes
    it runs in this one.

    Raises the exceptions of `function`, and `MemoryError` if the system killed a process.
    """
    if processes == 0:
        yield from map(function, arguments)
        return
    _learn_of_ends()
    waiting: list[tuple[Argument, Future[Result]]] = []
    remaining = iter(arguments)
    # Not fork, as the caller may have threads.
    context = multiprocessing.get_context("spawn")
    others = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(processes, mp_context=context, initializer=begin_work)
    try:
        while True:
            while len(waiting) < processes * QUEUED_PER_PROCESS:
                argument = next(remaining, None)
                if argument is None:
                    break
                with _signals_later(), _without_main():
                    waiting.append((argument, pool.submit(function, argument)))
            if not waiting:
                return
            argument, future = waiting.pop(0)
            try:
                yield future.result()
            except BrokenProcessPool:
                # Any argument in progress may be the cause, so each is run again, alone.
                pool.shutdown()
                for suspect in [argument, *(argument for argument, _ in waiting)]:
                    yield _alone(function, suspect, context, if_it_dies)
                waiting = []
                pool = ProcessPoolExecutor(processes, mp_context=context, initializer=begin_work)
    except BaseException:
        # Nobody waits for further results, so processes in progress are ended too.
        for process in set(multiprocessing.active_children()) - others:
            process.kill()
        raise
    finally:
        # Waited for, as otherwise the interpreter's exit and the pool's thread race for their pipe (Python
        # 3.11).
        pool.shutdown(cancel_futures=True)


def _learn_of_ends() -> None:
    """Restores SIGCHLD, which a parent may have left ignored: the system would then not report ended
    processes, and Python would wait forever, busily."""
    is_main = threading.current_thread() is threading.main_thread()
    if is_main and hasattr(signal, "SIGCHLD") and signal.getsignal(signal.SIGCHLD) is signal.SIG_IGN:
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)


def begin_work() -> None:
    """Makes a worker process end with its parent."""
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
    """Defers signals while processes start, so that none is left half started. Workers ignore Ctrl-C,
    which is for their parent."""
    if threading.current_thread() is not threading.main_thread() or not hasattr(signal, "pthread_sigmask"):
        yield
        return
    heard: list[int] = []
    # Masks are inherited; signals to other threads of this process are still handled here.
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


@contextmanager
def _without_main() -> Iterator[None]:
    """Keeps workers from importing the caller's script again, as `multiprocessing.spawn` has it by these two
    attributes. They need nothing of it; without `if __name__ == "__main__":` it would run in each, and from
    stdin it would not be found."""
    main = vars(sys.modules["__main__"])
    with _MAIN:
        kept: dict[str, object] = {name: main[name] for name in ("__file__", "__spec__") if name in main}
        main.pop("__file__", None)
        main["__spec__"] = None
        try:
            yield
        finally:
            del main["__spec__"]
            main.update(kept)


def _alone(
    function: Callable[[Argument], Result],
    argument: Argument,
    context: SpawnContext,
    if_it_dies: Callable[[Argument], Result],
) -> Result:
    ours, theirs = context.Pipe(duplex=False)
    process = context.Process(target=_answer, args=(function, argument, theirs), daemon=True)
    with _signals_later(), _without_main():
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
