"""`sunfleck-tools validate`: whether a sequence of frames can be trusted."""

import argparse
from pathlib import Path

from .. import checks  # noqa: F401  (registers them)
from ..disk import write_whole
from ..errors import ToolError
from ..findings import CHECKS, Severity
from ..frame_list import format_frames
from ..options import Options
from ..progress import Bar
from ..report.as_json import json_report
from ..report.html import html_report
from ..report.text import text_report
from ..validation import validate
from . import FINDINGS, OK
from .arguments import count, frame_rate, frames, limit

HELP = "says whether a sequence of frames can be trusted"
MOST_RELMSE = 0.01


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments."""
    parser.add_argument(
        "target", metavar="DIR|PATTERN", nargs="?", help="a folder, or frames such as out/x.####.exr"
    )
    parser.add_argument(
        "--frames", metavar="LIST", type=frames, help="frames that must be there, as in `sunfleck render`"
    )
    parser.add_argument(
        "--fps", type=frame_rate, help="the frame rate that every file must carry: 24 or 24000/1001"
    )
    parser.add_argument(
        "--reference", metavar="DIR|PATTERN", type=Path, help="frames to compare with, by number"
    )
    parser.add_argument(
        "--max-relmse", metavar="X", type=limit, help=f"against --reference ({MOST_RELMSE})"
    )
    parser.add_argument(
        "--max-flip", metavar="X", type=limit, help="the same by mean FLIP (pip install flip-evaluator)"
    )
    parser.add_argument(
        "--skip-checks", metavar="IDS", type=_checks, default=frozenset(), help="not to run, by commas"
    )
    parser.add_argument(
        "--fail-on", choices=[s.value for s in Severity], default="error", help="what exits with 1 (error)"
    )
    parser.add_argument("--json", action="store_true", help="the report as JSON on the output stream")
    parser.add_argument("--html", metavar="FILE", type=Path, help="also writes the report as a page")
    parser.add_argument(
        "--stats", metavar="FILE", type=Path, help="what `sunfleck render --stats` wrote, for the page"
    )
    parser.add_argument(
        "--static", action="store_true", help="nothing moves: frames may be equal to the ones before"
    )
    parser.add_argument(
        "--list-missing", action="store_true", help="prints only the frames to render (again), or `none`"
    )
    parser.add_argument(
        "--write-missing",
        metavar="FILE",
        type=Path,
        help="also writes them to FILE; findings are no failure then",
    )
    parser.add_argument("--list-checks", action="store_true", help="prints all checks and exits")
    parser.add_argument("--processes", metavar="N", type=count, help="that decode (all processors)")


def run(arguments: argparse.Namespace) -> int:
    """Validates and prints the report."""
    if arguments.list_checks:
        for check in CHECKS.values():
            print(f"{check.id:20} {check.severity.value:8} {check.about}")
        return OK
    if arguments.target is None:
        raise ToolError("validate what? name a folder, or a pattern such as out/name.####.exr")
    for flag, path in (("--html", arguments.html), ("--write-missing", arguments.write_missing)):
        if path is not None and (path.suffix.lower() == ".exr" or path == arguments.stats):
            raise ToolError(f"{flag} {path} would be lost: it is read here; name another file, .html or .txt")
    options = Options(
        frames=arguments.frames,
        fps=arguments.fps,
        reference=arguments.reference,
        max_relmse=_relmse_limit(arguments),
        max_flip=_flip_limit(arguments),
        stats=arguments.stats,
        skip_checks=arguments.skip_checks,
        static=arguments.static,
        processes=arguments.processes,
        thumbnails=arguments.html is not None,
    )
    report = validate(arguments.target, options, Bar())
    if arguments.html is not None:
        write_whole(arguments.html, html_report(report).encode())
    # `sunfleck render --frames none` renders nothing, and succeeds.
    missing = format_frames(report.rerender) or "none"
    if arguments.list_missing:
        print(missing)
    else:
        print(json_report(report) if arguments.json else text_report(report))
    if arguments.write_missing is not None:
        # The list is meant for `sunfleck render --frames @FILE`.
        write_whole(arguments.write_missing, missing.encode() + b"\n")
        return OK
    return FINDINGS if report.fails(Severity(arguments.fail_on)) else OK


def _relmse_limit(arguments: argparse.Namespace) -> float:
    if arguments.max_relmse is not None and arguments.reference is None:
        raise ToolError("--max-relmse compares with --reference, and there is none")
    return MOST_RELMSE if arguments.max_relmse is None else arguments.max_relmse


def _flip_limit(arguments: argparse.Namespace) -> float | None:
    if arguments.max_flip is None:
        return None
    if arguments.reference is None:
        raise ToolError("--max-flip compares with --reference, and there is none")
    try:
        import flip_evaluator  # noqa: F401
    except ImportError:
        raise ToolError("--max-flip needs a package: pip install flip-evaluator") from None
    return arguments.max_flip


def _checks(text: str) -> frozenset[str]:
    ids = frozenset(part.strip() for part in text.split(","))
    if unknown := ids - CHECKS.keys():
        raise argparse.ArgumentTypeError(
            f"no check is named {', '.join(sorted(unknown))}; --list-checks prints them all"
        )
    return ids
