"""What `validate` costs beside decoding alone: processor and wall time over a folder, all in turns.

    python -m tests.cost ../out/many        (in tools/; tests.many_frames makes such a folder)
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import resource
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import OpenEXR

from sunfleck_tools import Options, validate
from sunfleck_tools.exr.pixel_hash import pixel_hash
from sunfleck_tools.parallel import in_processes
from sunfleck_tools.sequence import list_sequence


def decoded(path: str) -> dict:
    """Pixels by OpenEXR, as its users get them."""
    part = OpenEXR.File(path, separate_channels=True)
    return {name: channel.pixels for name, channel in part.channels().items()}


def decode_only(path: str) -> None:
    """The least that there is to do."""
    decoded(path)


def decode_and_hash(path: str) -> None:
    """The least that finds damage in every compression."""
    pixel_hash(decoded(path))


def processor_seconds() -> float:
    """Of this process and of all that have ended."""
    for child in multiprocessing.active_children():
        child.join()
    usages = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(usage.ru_utime + usage.ru_stime for usage in usages)


def measured(work: Callable[[], object]) -> tuple[float, float]:
    """Processor and wall seconds."""
    processor, wall = processor_seconds(), time.monotonic()
    work()
    return processor_seconds() - processor, time.monotonic() - wall


def main() -> None:
    """Prints a line for each: the least of the rounds."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--rounds", type=int, default=2)
    arguments = parser.parse_args()
    paths = [str(file.path) for file in list_sequence(arguments.folder).frames]
    processes = os.cpu_count() or 1

    def over_all(function: Callable[[str], None]) -> Callable[[], object]:
        return lambda: list(in_processes(function, paths, processes, lambda path: None))

    def as_python_has_it() -> None:
        with ProcessPoolExecutor(processes, mp_context=multiprocessing.get_context("spawn")) as pool:
            list(pool.map(decode_only, paths))

    works = {
        "decoding alone": as_python_has_it,
        "decoding, freed memory kept": over_all(decode_only),
        "decoding and hash, likewise": over_all(decode_and_hash),
        "validate": lambda: validate(arguments.folder, Options()),
        "validate, with thumbnails": lambda: validate(arguments.folder, Options(thumbnails=True)),
    }
    least = dict.fromkeys(works, (float("inf"), float("inf")))
    for _ in range(arguments.rounds):
        for name, work in works.items():
            least[name] = tuple(map(min, least[name], measured(work)))
    alone = least["decoding alone"]
    print(f"{len(paths)} frames, {processes} processes, the least of {arguments.rounds} rounds")
    for name, (processor, wall) in least.items():
        each = 1e3 * processor / len(paths)
        print(f"{name:28} {processor:7.1f} s of processors ({each:.1f} ms a frame, {processor / alone[0]:.2f}), {wall:6.1f} s by the clock")


if __name__ == "__main__":
    main()
