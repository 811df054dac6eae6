"""What commands that make pictures of a sequence share.

It is their arguments, and how they tell of frames that they cannot show.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterable
from math import isfinite
from pathlib import Path

from ..display import CURVES, Display
from ..errors import ToolError
from ..sequence import Listing, list_sequence, list_sequences
from ..words import printable
from . import FINDINGS, OK
from .arguments import count, frames

MOST_FRAMES = 100_000
MOST_FAULTS = 8
"""Frames whose faults are told one by one."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Which frames, and how they are shown."""
    parser.add_argument("target", metavar="DIR|PATTERN", help="a folder, or frames such as out/x.####.exr")
    parser.add_argument(
        "--frames",
        metavar="LIST",
        type=frames,
        help="which, as in `sunfleck render` (from the first to the last)",
    )
    parser.add_argument(
        "--display", choices=CURVES, default="agx", help="how light is brought into a screen's range (agx)"
    )
    parser.add_argument(
        "--exposure", metavar="EV", type=stops, default=0.0, help="brightens by powers of two (0)"
    )
    parser.add_argument(
        "--processes",
        metavar="N",
        type=count,
        default=os.cpu_count() or 1,
        help="that decode (all processors)",
    )


def display(arguments: argparse.Namespace) -> Display:
    """The choice of `--display` and `--exposure`."""
    return Display(arguments.display, arguments.exposure)


def wanted(arguments: argparse.Namespace) -> Listing:
    """The one sequence to show: frames that are expected are those that are shown."""
    return _bounded([list_sequence(arguments.target, arguments.frames)])[0]


def all_wanted(arguments: argparse.Namespace) -> list[Listing]:
    """The sequences to show."""
    return _bounded(list_sequences(arguments.target, arguments.frames))


def _bounded(listings: list[Listing]) -> list[Listing]:
    count = sum(len(listing.expected) for listing in listings)
    if count > MOST_FRAMES:
        raise ToolError(f"{count} frames are more than {MOST_FRAMES}: choose some with --frames")
    return listings


def tell_faults(faults: Iterable[tuple[int, str]]) -> int:
    """Prints what could not be shown; the exit code."""
    faults = list(faults)
    for number, fault in faults[:MOST_FAULTS]:
        print(printable(f"error: frame {number} is not shown: {fault}"), file=sys.stderr)
    if len(faults) > MOST_FAULTS:
        print(
            f"... and {len(faults) - MOST_FAULTS} more; `sunfleck-tools validate` says all about them",
            file=sys.stderr,
        )
    return FINDINGS if faults else OK


def writable(path: Path) -> Path:
    """The path, once it is known that a file can be written there: before hours of work, not after."""
    if path.is_dir():
        raise ToolError(f"{path} is a folder: name a file")
    if not path.parent.is_dir():
        raise ToolError(f"there is no folder {path.parent} for {path.name}", is_usage=False)
    return path


def stops(text: str) -> float:
    """Powers of two."""
    try:
        stops = float(text)
    except ValueError:
        stops = float("inf")
    if not isfinite(stops) or abs(stops) > 100:
        raise argparse.ArgumentTypeError(f"`{text}` is no number from -100 to 100")
    return stops
