"""`sunfleck-tools contact-sheet`: a folder's sequences as one PNG, frames side by side."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..contact_sheet import contact_sheet
from ..disk import write_whole
from ..errors import ToolError
from ..pictures import files_of, shown
from ..png import png
from ..words import printable
from . import looks
from .arguments import count

HELP = "shows sequences as one picture"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describes the command line."""
    looks.add_arguments(parser)
    parser.add_argument("out", metavar="OUT.png", type=Path, help="the picture to write")
    parser.add_argument("--width", metavar="PX", type=count, default=160, help="of a frame, about (160)")
    parser.add_argument("--columns", metavar="N", type=count, help="frames in a row")


def run(arguments: argparse.Namespace) -> int:
    """Writes the sheet."""
    if arguments.out.suffix.lower() != ".png":
        raise ToolError(f"{arguments.out} is no name of a PNG file: expected one that ends in .png")
    out = looks.writable(arguments.out)
    listings = looks.all_wanted(arguments)
    frames = [frame for listing in listings for frame in files_of(listing)]
    pictures = shown(frames, looks.display(arguments), arguments.width, arguments.processes)
    sheet = contact_sheet(pictures, [len(listing.expected) for listing in listings], arguments.columns)
    write_whole(out, png(sheet.pixels))
    height, width, _ = sheet.pixels.shape
    print(
        printable(
            f"{out}: {len(frames) - len(sheet.faults)} of {len(frames)} frames in {width}x{height} pixels"
        )
    )
    return looks.tell_faults(sheet.faults)
