"""`sunfleck-tools export-usd`: what sunfleck renders as a USD stage."""

import argparse
import re
import sys
from pathlib import Path

from ..errors import ToolError
from ..words import printable
from . import OK
from .arguments import add_reading, frame_rate, frames

HELP = "writes what sunfleck renders as a USD stage"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments."""
    parser.add_argument("source", metavar="INPUT", type=Path, help="a sequence or scene (.ron), or glTF")
    parser.add_argument("target", metavar="OUT.usdc|usda|usdz", type=Path, help="the stage to write")
    parser.add_argument(
        "--for", dest="reader", choices=["usd", "blender"], default="usd", help="whose light units (usd)"
    )
    parser.add_argument(
        "--point-instancer", action="store_true", help="one PointInstancer for leaves that share meshes"
    )
    parser.add_argument(
        "--samples-per-frame", metavar="N", type=int, choices=range(1, 65), default=1, help="time samples (1)"
    )
    parser.add_argument("--frames", metavar="A-B", type=frames, help="first and last frame (the input's)")
    parser.add_argument(
        "--fps", type=frame_rate, help="frames a second, if the input does not say: 24 or 24000/1001"
    )
    add_reading(parser)


def run(arguments: argparse.Namespace) -> int:
    """Writes the stage and prints the losses."""
    # USD loads slowly, and no other command needs it.
    from pxr import Tf

    from ..usd import ExportOptions, export_usd

    options = ExportOptions(
        for_blender=arguments.reader == "blender",
        point_instancer=arguments.point_instancer,
        samples_per_frame=arguments.samples_per_frame,
        frames=(arguments.frames[0], arguments.frames[-1]) if arguments.frames else None,
        fps=arguments.fps,
        program=arguments.sunfleck,
        allowed=tuple(arguments.allow),
    )
    try:
        exported = export_usd(arguments.source, arguments.target, options)
    except Tf.ErrorException as error:
        said = re.search(r"writing file: ([^']+)", str(error))
        raise ToolError(
            f"cannot write {arguments.target}: {said[1] if said else error}", is_usage=False
        ) from None
    kinds = ", ".join(f"{count} {kind}" for kind, count in sorted(exported.prims.items()))
    print(printable(f"{arguments.target}: frames {exported.frames[0]} to {exported.frames[-1]}; {kinds}"))
    for lost in exported.lost:
        print(printable(f"note: {lost}"), file=sys.stderr)
    return OK
