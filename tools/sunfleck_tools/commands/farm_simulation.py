"""`sunfleck-tools farm-simulation`: what becomes of a sequence on farms of many sizes, by size of chunk.

Nothing is rendered: times are given, or are the defaults. The same flags print the same tables."""

import argparse
from collections.abc import Callable
from dataclasses import replace

from ..errors import ToolError
from ..farm import HOUR_S, Farm, Outcome, Work, simulate
from .arguments import from_zero, positive

HELP = "simulates a render farm: throughput and waste by size of chunk"
MOST = 1_000_000
"""Nodes and frames; each takes some hundred bytes."""
LEAST, LARGEST = 1e-6, 1e9
"""Of seconds, megabytes and rates, beside 0: nothing over- or underflows."""

COLUMNS = ("chunk", "hours", "frames/h", "ideal", "start", "write", "lost", "idle", "failures")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describes the command line."""
    farm = Farm(1)

    def flag(name: str, kind: Callable[[str], object], default: object, what: str) -> None:
        parser.add_argument(name, metavar="N", type=kind, default=default, help=f"{what} (%(default)s)")

    flag("--nodes", _counts, "10,1000,10000", "sizes of farms, separated by commas")
    flag("--chunks", _counts, "1,2,4,8,16,32,64", "frames that a task renders, likewise")
    flag("--frames", _count, 100_000, "of the sequence")
    flag("--frame-seconds", _above_zero, 60.0, "mean time of a frame on a node")
    flag("--spread", _spread, 0.25, "standard deviation of that time by its mean")
    flag("--dispatch-seconds", _amount, farm.dispatch_s, "of the manager for a task, one after the other")
    flag("--start-seconds", _amount, farm.start_s, "from the manager's word until the program runs")
    flag("--load-seconds", _amount, farm.load_s, "of the scene, beside reading its files")
    flag("--scene-mb", _amount, 100.0, "that each start reads")
    flag("--frame-mb", _amount, 4.0, "that each frame writes")
    flag("--disk-mb-per-second", _above_zero, 5000.0, "of the disk that all nodes share")
    flag("--failures-per-hour", _amount, 0.01, "of a node")
    flag("--restart-seconds", _amount, farm.restart_s, "of a node that failed")
    flag("--seed", _seed, 0, "of times of frames and failures")


def run(arguments: argparse.Namespace) -> int:
    """Prints a table a farm."""
    for nodes in arguments.nodes:
        farm = Farm(
            nodes=nodes, dispatch_s=arguments.dispatch_seconds, start_s=arguments.start_seconds,
            load_s=arguments.load_seconds, scene_mb=arguments.scene_mb, frame_mb=arguments.frame_mb,
            disk_mb_per_s=arguments.disk_mb_per_second, failures_per_h=arguments.failures_per_hour,
            restart_s=arguments.restart_seconds,
        )  # fmt: skip
        work = Work(arguments.frames, arguments.frame_seconds, arguments.spread)
        print(f"{nodes} nodes, {work.frames} frames of {work.frame_s:g} s")
        print("".join(f"{name:>10}" for name in COLUMNS))
        for chunk in arguments.chunks:
            try:
                outcome = simulate(farm, replace(work, chunk=chunk), arguments.seed)
            except ValueError as error:
                raise ToolError(str(error)) from None
            print(_line(chunk, outcome), flush=True)
    print("shares are of the time of all nodes; ideal: in frames that were kept")
    return 0


def _line(chunk: int, outcome: Outcome) -> str:
    shares = (outcome.rendering, outcome.starting, outcome.writing, outcome.lost, outcome.idle)
    cells = [f"{chunk}", f"{outcome.seconds / HOUR_S:.3f}", f"{outcome.frames_per_h:.0f}"]
    cells += [f"{100 * share:.1f} %" for share in shares] + [f"{outcome.failures}"]
    return "".join(f"{cell:>10}" for cell in cells)


def _amount(text: str) -> float:
    number = from_zero(text)
    if number and not LEAST <= number <= LARGEST:
        raise argparse.ArgumentTypeError(f"`{text}` is neither 0 nor from {LEAST:g} to {LARGEST:g}")
    return number


def _above_zero(text: str) -> float:
    positive(text)
    return _amount(text)


def _spread(text: str) -> float:
    spread = from_zero(text)
    if spread > 10:
        raise argparse.ArgumentTypeError(f"`{text}` is no spread from 0 to 10")
    return spread


def _count(text: str) -> int:
    if not text.isascii() or not text.isdigit() or len(text) > 7 or not 1 <= int(text) <= MOST:
        raise argparse.ArgumentTypeError(f"`{text}` is no number from 1 to {MOST}")
    return int(text)


def _counts(text: str) -> tuple[int, ...]:
    return tuple(_count(part) for part in text.split(","))


def _seed(text: str) -> int:
    if not text.isascii() or not text.isdigit() or len(text) > 18:
        raise argparse.ArgumentTypeError(f"`{text}` is no whole number from 0 on")
    return int(text)
