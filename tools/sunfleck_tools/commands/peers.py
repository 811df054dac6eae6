"""`sunfleck-tools peers`: Mitsuba and Cycles on the same scene, with as many bounces."""

import argparse
import sys
from io import StringIO
from pathlib import Path

import numpy as np

from ..disk import writable, write_whole
from ..errors import ToolError
from . import OK
from .arguments import add_reading, positive

HELP = "renders the same scene by Mitsuba and Cycles, for reference frames and error against time"
RENDERERS = ("mitsuba-llvm", "mitsuba-scalar", "cycles", "cycles-denoised")
MOST_SAMPLES = 1 << 20
# More bounces make no difference from all.
MOST_BOUNCES = 64


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments."""
    parser.add_argument("scene", metavar="INPUT", type=Path, help="a sequence or scene (.ron), or glTF")
    parser.add_argument("--frame", metavar="F", type=float, help="the moment (the first frame)")
    parser.add_argument(
        "--renderers",
        metavar="LIST",
        type=_renderers,
        default=RENDERERS,
        help=f"of {', '.join(RENDERERS)} (all)",
    )
    parser.add_argument(
        "--samples", metavar="LIST", type=_samples, default=(1, 4, 16, 64), help="a pixel (1,4,16,64)"
    )
    parser.add_argument(
        "--reference", metavar="FILE.exr", type=Path, help="a converged frame, filtered by a box"
    )
    parser.add_argument(
        "--reference-noise",
        metavar="X",
        type=positive,
        default=0.0,
        help="its own noise, taken out of the RMSE",
    )
    parser.add_argument(
        "--out", metavar="FILE.csv", type=Path, help="error against time, for `sunfleck bench --peers`"
    )
    parser.add_argument("--pictures", metavar="DIR", type=Path, help="where the frames go")
    parser.add_argument(
        "--bounces",
        metavar="N|all",
        type=bounces,
        default=0,
        help="scatterings beyond direct light and single scattering (0)",
    )
    parser.add_argument(
        "--size", metavar="WxH", type=_size, help="of the picture (the reference's, else the scene's)"
    )
    add_reading(parser)


def run(arguments: argparse.Namespace) -> int:
    """Renders and measures."""
    from ..peers import measure, write_table
    from ..peers.measure import available
    from ..peers.scene import read_scene

    if arguments.out is None and arguments.pictures is None:
        raise ToolError(
            "nothing would be kept: give --pictures DIR, or --reference FILE.exr with --out FILE.csv"
        )
    if (arguments.out is None) != (arguments.reference is None):
        raise ToolError(
            "an error is measured against a reference: --reference FILE.exr and --out FILE.csv go together"
        )
    if missing := [sentence for name in arguments.renderers if (sentence := available(name)) is not None]:
        raise ToolError("\n".join(missing))
    out = writable(arguments.out) if arguments.out is not None else None
    reference = None if arguments.reference is None else colors(arguments.reference)
    scene = read_scene(arguments.scene, arguments.frame, arguments.sunfleck, arguments.allow)
    scene.size = arguments.size or scene.size
    scene.bounces = arguments.bounces
    if reference is not None:
        scene.size = (reference.shape[1], reference.shape[0])
    if arguments.pictures is not None:
        arguments.pictures.mkdir(parents=True, exist_ok=True)
    for note in scene.notes:
        print(f"note: {note}", file=sys.stderr)
    points = []
    for point in measure(
        scene,
        arguments.renderers,
        arguments.samples,
        reference,
        arguments.reference_noise,
        arguments.pictures,
    ):
        points.append(point)
        error = "" if point.rmse is None else f", RMSE {point.rmse:.4f}, mean ratio {point.mean_ratio:.4f}"
        print(
            f"{point.renderer} {point.version}: {point.samples} spp, {point.cpu_s:.3f} CPU s{error}",
            flush=True,
        )
    if out is not None:
        table, size = StringIO(newline=""), f"{scene.size[0]} x {scene.size[1]}"
        write_table(table, points, f"{arguments.scene.name} at {size}, by sunfleck-tools peers")
        write_whole(out, table.getvalue().encode())
    return OK


def colors(path: Path) -> np.ndarray:
    from ..analysis import read_picture

    frame, fault = read_picture(path)
    if frame is None:
        raise ToolError(f"{path}: {fault}", is_usage=False)
    return np.stack(frame.group(), axis=-1).astype(np.float64)


def bounces(text: str) -> int:
    if text == "all":
        return MOST_BOUNCES
    if not (text.isascii() and text.isdigit() and int(text) <= MOST_BOUNCES):
        raise argparse.ArgumentTypeError(f"`{text}` is no number from 0 to {MOST_BOUNCES}, nor `all`")
    return int(text)


def _renderers(text: str) -> tuple[str, ...]:
    names = tuple(part.strip() for part in text.split(","))
    if unknown := [name for name in names if name not in RENDERERS]:
        raise argparse.ArgumentTypeError(
            f"no renderer is named {', '.join(unknown)}: there are {', '.join(RENDERERS)}"
        )
    return names


def _samples(text: str) -> tuple[int, ...]:
    parts = [part.strip() for part in text.split(",")]
    if not all(part.isascii() and part.isdigit() and 1 <= int(part) <= MOST_SAMPLES for part in parts):
        raise argparse.ArgumentTypeError(f"`{text}` is no list of numbers from 1 to {MOST_SAMPLES}")
    return tuple(map(int, parts))


def _size(text: str) -> tuple[int, int]:
    sides = text.split("x")
    if len(sides) != 2 or not all(
        side.isascii() and side.isdigit() and 1 <= int(side) <= 65536 for side in sides
    ):
        raise argparse.ArgumentTypeError(f"`{text}` is no size: write for instance 960x540")
    return int(sides[0]), int(sides[1])
