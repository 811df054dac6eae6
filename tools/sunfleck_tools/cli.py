"""`sunfleck-tools`: arguments to functions, and outcomes to exit codes."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

from . import checks  # noqa: F401  (registers them)
from .findings import CHECKS, Severity
from .frame_list import format_frames, parse_frames
from .options import Options
from .progress import Bar
from .report.as_json import json_report
from .report.html import html_report
from .report.text import text_report
from .sequence import SequenceError
from .validation import validate

OK, FINDINGS, USAGE, IO = 0, 1, 2, 4


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs a command line and returns its exit code."""
    try:
        chosen = _parser().parse_args(arguments)
        return chosen.run(chosen)
    except SystemExit as exit:  # from argparse
        return exit.code if isinstance(exit.code, int) else USAGE
    except SequenceError as error:
        print(f"error: {error}", file=sys.stderr)
        return USAGE if error.is_usage else IO
    except BrokenPipeError:
        # Whoever read has enough; Python must not complain at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return OK
    except OSError as error:
        print(f"error: {error}", file=sys.stderr)
        return IO
    except KeyboardInterrupt:
        return 130


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="sunfleck-tools", description="Tools around sunfleck's frames.")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    _add_validate(commands.add_parser("validate", help="says whether a sequence of frames can be trusted"))
    return parser


def _add_validate(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("target", metavar="DIR|PATTERN", nargs="?", help="a folder, or frames such as out/x.####.exr")
    parser.add_argument("--frames", metavar="LIST", type=_frames, help="frames that must be there, as in `sunfleck render`")
    parser.add_argument("--fps", type=_fraction, help="the frame rate that every file must carry: 24 or 24000/1001")
    parser.add_argument("--reference", metavar="DIR|PATTERN", type=Path, help="frames to compare with, by number")
    parser.add_argument("--max-relmse", metavar="X", type=_positive, default=0.01, help="against --reference (0.01)")
    parser.add_argument("--max-flip", metavar="X", type=_positive, help="the same by mean FLIP (pip install flip-evaluator)")
    parser.add_argument("--skip-checks", metavar="IDS", type=_checks, default=frozenset(), help="not to run, by commas")
    parser.add_argument("--fail-on", choices=[s.value for s in Severity], default="error", help="what exits with 1 (error)")
    parser.add_argument("--json", action="store_true", help="the report as JSON on the output stream")
    parser.add_argument("--html", metavar="FILE", type=Path, help="also writes the report as a page")
    parser.add_argument("--stats", metavar="FILE", type=Path, help="what `sunfleck render --stats` wrote, for the page")
    parser.add_argument("--list-missing", action="store_true", help="prints only the frames to render (again)")
    parser.add_argument("--list-checks", action="store_true", help="prints all checks and exits")
    parser.add_argument("--processes", metavar="N", type=_count, help="that decode (all processors)")
    parser.set_defaults(run=_validate)


def _validate(chosen: argparse.Namespace) -> int:
    if chosen.list_checks:
        for check in CHECKS.values():
            print(f"{check.id:20} {check.severity.value:8} {check.about}")
        return OK
    if chosen.target is None:
        raise SequenceError("validate what? name a folder, or a pattern such as out/name.####.exr")
    options = Options(
        frames=chosen.frames,
        fps=chosen.fps,
        reference=chosen.reference,
        max_relmse=chosen.max_relmse,
        max_flip=_flip_limit(chosen),
        stats=chosen.stats,
        skip_checks=chosen.skip_checks,
        processes=chosen.processes,
    )
    if chosen.html is not None:
        options = replace(options, thumbnails=True)
    report = validate(chosen.target, options, Bar())
    if chosen.html is not None:
        chosen.html.write_text(html_report(report), encoding="utf-8")
    if chosen.list_missing:
        print(format_frames(report.rerender))
    else:
        print(json_report(report) if chosen.json else text_report(report))
    return FINDINGS if report.fails(Severity(chosen.fail_on)) else OK


def _flip_limit(chosen: argparse.Namespace) -> float | None:
    if chosen.max_flip is None:
        return None
    if chosen.reference is None:
        raise SequenceError("--max-flip compares with --reference, and there is none")
    try:
        import flip_evaluator  # noqa: F401
    except ImportError:
        raise SequenceError("--max-flip needs a package: pip install flip-evaluator") from None
    return chosen.max_flip


def _frames(text: str) -> tuple[int, ...]:
    try:
        return tuple(sorted(parse_frames(text)))
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def _fraction(text: str) -> Fraction:
    try:
        rate = Fraction(text)
    except (ValueError, ZeroDivisionError):
        rate = Fraction(0)
    if rate <= 0:
        raise argparse.ArgumentTypeError(f"`{text}` is no frame rate: write for instance 24 or 24000/1001")
    return rate


def _positive(text: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = 0.0
    if not 0 < number < float("inf"):
        raise argparse.ArgumentTypeError(f"`{text}` is no number above 0")
    return number


def _count(text: str) -> int:
    if not text.isascii() or not text.isdigit() or not 1 <= int(text) <= 1024:
        raise argparse.ArgumentTypeError(f"`{text}` is no number from 1 to 1024")
    return int(text)


def _checks(text: str) -> frozenset[str]:
    ids = frozenset(part.strip() for part in text.split(","))
    if unknown := ids - CHECKS.keys():
        raise argparse.ArgumentTypeError(f"no check is named {', '.join(sorted(unknown))}; --list-checks prints them all")
    return ids
