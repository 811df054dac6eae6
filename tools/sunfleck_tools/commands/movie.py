"""`sunfleck-tools movie`: a sequence as a movie."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..movie import ENDINGS, check_ending, movie
from ..pictures import files_of, shown
from ..progress import Bar
from ..words import printable
from . import looks
from .arguments import frame_rate

HELP = "shows a sequence as a movie"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describes the command line."""
    looks.add_arguments(parser)
    parser.add_argument(
        "out",
        metavar="OUT",
        type=Path,
        help=f"the movie to write: {', '.join(ENDINGS)}; all but .png by ffmpeg",
    )
    parser.add_argument("--fps", type=frame_rate, help="frames a second (what the frames say, else 24)")
    parser.add_argument(
        "--width", metavar="PX", type=_width, help="about, by averages of whole pixels (the frames' own)"
    )


def run(arguments: argparse.Namespace) -> int:
    """Writes the movie."""
    check_ending(arguments.out)
    out = looks.writable(arguments.out)
    frames = files_of(looks.wanted(arguments))
    bar = Bar()

    def counted():
        pictures = shown(frames, looks.display(arguments), arguments.width, arguments.processes)
        for done, picture in enumerate(pictures, 1):
            yield picture
            bar(done, len(frames))

    faults = movie(counted(), len(frames), out, arguments.fps)
    print(
        printable(
            f"{out}: {len(frames) - len(faults)} of {len(frames)} frames, {out.stat().st_size / 1e6:.1f} MB"
        )
    )
    return looks.tell_faults(faults)


def _width(text: str) -> int:
    if not text.isascii() or not text.isdigit() or not 1 <= int(text) <= 65536:
        raise argparse.ArgumentTypeError(f"`{text}` is no number from 1 to 65536")
    return int(text)
