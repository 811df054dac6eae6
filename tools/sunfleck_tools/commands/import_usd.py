"""`sunfleck-tools import-usd`: a USD stage as glTF that sunfleck renders."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from . import OK

HELP = "writes a USD stage as glTF that sunfleck renders"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describes the command line."""
    parser.add_argument("source", metavar="SCENE.usd", type=Path, help="a stage: .usd, .usda, .usdc or .usdz")
    parser.add_argument("target", metavar="OUT.glb", type=Path, help="the file to write")


def run(arguments: argparse.Namespace) -> int:
    """Writes the file and says what it lacks."""
    # USD takes a while to load, and no other command needs it.
    from ..usd import import_usd

    imported = import_usd(arguments.source, arguments.target)
    counts = ", ".join(f"{count} {kind}" for kind, count in imported.counts.items() if count)
    print(f"{arguments.target}: frames {imported.frames[0]} to {imported.frames[1]}; {counts}")
    for lost in imported.lost:
        print(f"warning: {lost}", file=sys.stderr)
    return OK
