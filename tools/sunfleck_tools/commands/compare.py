"""`sunfleck-tools compare`: how far frames are from other frames."""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import asdict
from math import isfinite
from pathlib import Path

from ..comparison import Compared, compare
from ..difference import Errors, IdErrors
from ..display import CURVES, Display
from ..errors import ToolError
from ..layers import split
from ..limits import ChannelLimit, Limits
from ..progress import Bar
from ..words import printable
from . import FINDINGS, OK, looks
from .arguments import count, from_zero, limit, positive, share_limit

LIMITS = {
    "--max-rmse": "root mean square error: of the colour, and of every other channel; or of those named, "
                  "such as diffuse.*=0.01",
    "--max-relmse": "relative mean square error, likewise",
    "--max-error": "difference of a value, likewise",
}
HELP = "says how far frames are from other frames"
FORMAT_VERSION = 1


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Describes the command line."""
    parser.add_argument(
        "output", metavar="OUTPUT", type=Path, help="a frame, or a folder or pattern such as out/x.####.exr"
    )
    parser.add_argument(
        "reference", metavar="REFERENCE", type=Path, help="what it is compared with, by number"
    )
    for flag, what in LIMITS.items():
        parser.add_argument(
            flag, metavar="[CHANNELS=]X", type=limit, action="append", default=[], help=f"largest {what}"
        )
    parser.add_argument(
        "--max-flip", metavar="X", type=from_zero, help="largest mean FLIP (pip install flip-evaluator)"
    )
    parser.add_argument(
        "--max-ids", metavar="[CHANNELS=]SHARE", type=share_limit, action="append", default=[],
        help="largest share of a channel's ids that differ, 0 to 1",
    )  # fmt: skip
    parser.add_argument("--flip", action="store_true", help="computes FLIP (pip install flip-evaluator)")
    parser.add_argument(
        "--picture", metavar="FILE|DIR", type=Path, help="writes output, reference and difference as PNG"
    )
    parser.add_argument(
        "--white", metavar="X", type=positive, help="difference that is white there (99.9 %% are below)"
    )
    parser.add_argument(
        "--display", choices=CURVES, default="agx", help="how light is brought into a screen's range (agx)"
    )
    parser.add_argument(
        "--exposure", metavar="EV", type=looks.stops, default=0.0, help="brightens by powers of two (0)"
    )
    parser.add_argument("--json", action="store_true", help="as JSON on the output stream")
    parser.add_argument("--processes", metavar="N", type=count, help="that decode (all processors)")


def run(arguments: argparse.Namespace) -> int:
    """Compares and prints."""
    wants_flip = arguments.flip or arguments.max_flip is not None
    if wants_flip:
        needs_flip("--max-flip" if arguments.max_flip is not None else "--flip")
    results = compare(
        arguments.output,
        arguments.reference,
        wants_flip,
        _pictures(arguments),
        Display(arguments.display, arguments.exposure),
        arguments.white,
        arguments.processes,
        Bar(),
    )
    for note in dict.fromkeys(note for result in results for note in result.notes):
        print(printable(f"note: {note}"), file=sys.stderr)
    limits = _limits(arguments)
    print(
        json.dumps(as_object(results, limits), indent=1, allow_nan=False)
        if arguments.json
        else as_text(results, limits)
    )
    return FINDINGS if any(r.difference is None or limits.any and r.exceeded(limits) for r in results) else OK


def _limits(arguments: argparse.Namespace) -> Limits:
    """What the flags say; of several for all channels the last counts."""
    given = {
        "rmse": arguments.max_rmse, "relative_mse": arguments.max_relmse, "max_error": arguments.max_error, "ids": arguments.max_ids,
    }  # fmt: skip
    general = {
        name: value for name, values in given.items() for channels, value in values if channels is None
    }
    single = [
        ChannelLimit(name, channels, x)
        for name, values in given.items()
        for channels, x in values
        if channels is not None
    ]
    return Limits(**general, flip=arguments.max_flip, channels=tuple(single))


def needs_flip(flag: str) -> None:
    """Refuses where the package is missing."""
    try:
        import flip_evaluator  # noqa: F401
    except ImportError:
        raise ToolError(f"{flag} needs a package: pip install flip-evaluator") from None


def _pictures(arguments: argparse.Namespace) -> Path | None:
    path = arguments.picture
    if path is None:
        return None
    if arguments.output.is_file():
        if path.suffix.lower() != ".png":
            raise ToolError(f"{path} is no name of a PNG file: expected one that ends in .png")
        return looks.writable(path)
    path.mkdir(parents=True, exist_ok=True)
    return path


def as_text(results: list[Compared], limits: Limits) -> str:
    """A line a frame, the worst first; of two files alone, a line a channel too."""
    lines = []
    for result in sorted(results, key=_rank, reverse=True):
        number = result.pair.number
        name = "frame" if number is None else f"frame {number}"
        name += f" of {result.pair.sequence}" if result.pair.sequence else ""
        if result.difference is None:
            lines.append(f"error: {name}: {result.fault}")
            continue
        found = result.difference
        flip = "" if found.flip is None else f"  FLIP {found.flip:.4f}"
        white = "" if result.white is None else f"  white is {result.white:.4g} in {result.pair.picture}"
        part = (
            ""
            if found.shared is None
            else f"  in the {found.shared[0]} x {found.shared[1]} pixels that both have"
        )
        over = "".join(f"; too much: {sentence}" for sentence in result.exceeded(limits))
        if found.color is not None:
            layer = split(found.picture[0])[0]
            lines.append(
                f"{name}: {layer + ' ' if layer else ''}RGB  {_line(found.color)}{flip}{white}{part}{over}"
            )
        elif over or part:
            lines.append(f"{name}:{part}{over}".replace(":; ", ": ").replace(":  ", ": "))
        if found.color is None or len(results) == 1:
            width = max(map(len, [*found.channels, *found.ids]))
            lines += [
                f"{name}: {channel:{width}}  {_line(errors)}" for channel, errors in found.channels.items()
            ]
            lines += [
                f"{name}: {channel:{width}}  {_id_line(errors)}" for channel, errors in found.ids.items()
            ]
        if len(results) == 1 and found.unmatched:
            lines.append(f"only in one of the two: {', '.join(found.unmatched)}")
    return "\n".join(map(printable, lines))


def _line(errors: Errors) -> str:
    if errors.rmse is None:
        return f"not finite {errors.not_finite}"
    ratio = "" if errors.mean_ratio is None else f"mean ratio {errors.mean_ratio:.6f}  "
    where = "" if errors.pixel is None else f" at {errors.pixel[0]}, {errors.pixel[1]} in {errors.channel}"
    bad = f"  not finite {errors.not_finite}" if errors.not_finite else ""
    return f"{ratio}RMSE {errors.rmse:.6f}  relMSE {errors.relative_mse:.3e}  max {errors.max_error:.6f}{where}{bad}"


def _id_line(errors: IdErrors) -> str:
    where = "" if errors.pixel is None else f", first at {errors.pixel[0]}, {errors.pixel[1]}"
    return f"{errors.different} of {errors.pixels} ids differ{where}"


def _rank(result: Compared) -> tuple[bool, float]:
    measures = result.difference and result.difference.measures
    return result.difference is None, measures.relative_mse or 0.0 if measures else 0.0


def as_object(results: list[Compared], limits: Limits) -> dict:
    """What compare.schema.json describes."""
    frames = []
    for result in results:
        found = result.difference
        frames.append(
            {
                "frame": result.pair.number,
                "sequence": result.pair.sequence or None,
                "output": result.pair.output,
                "reference": result.pair.reference,
                "fault": result.fault,
                "exceeded": result.exceeded(limits),
                "picture_channels": [] if found is None else list(found.picture),
                "color": None if found is None or found.color is None else asdict(found.color),
                "flip": None if found is None else found.flip,
                "channels": [] if found is None else [{"name": name, **asdict(e)} for name, e in found.channels.items()],
                "ids": [] if found is None else [{"name": name, **asdict(e)} for name, e in found.ids.items()],
                "shared": None if found is None or found.shared is None else list(found.shared),
                "unmatched": [] if found is None else found.unmatched,
                "picture": result.pair.picture if result.white is not None else None,
                "white": result.white,
            }
        )
    said = asdict(limits)
    channels = [{**channel, "limit": _number(channel["limit"])} for channel in said.pop("channels")]
    return {"format_version": FORMAT_VERSION, "limits": said, "channel_limits": channels, "frames": frames}


def _number(value: float) -> float | None:
    return value if isfinite(value) else None
