"""`sunfleck-tools import-usd`: a USD stage as glTF that sunfleck renders."""

import argparse
import json
import re
import sys
from pathlib import Path

from ..errors import SceneError
from ..disk import write_whole
from . import OK
from .arguments import frame_range

HELP = "writes a USD stage as glTF that sunfleck renders"
PURPOSES = ("render", "proxy", "guide")
VARIANT = re.compile(r"(/[^{}]+)((?:\{[^{}=]+=[^{}=]*\})+)")
MOST_SAID = 20
"""Maximum number of messages for a kind of loss."""
REPORT_VERSION = 1
"""Version of `--report`, which changes when a field changes its meaning."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments."""
    parser.add_argument("source", metavar="SCENE.usd", type=Path, help="a stage: .usd, .usda, .usdc or .usdz")
    parser.add_argument("target", metavar="OUT.glb", type=Path, help="the file to write")
    parser.add_argument(
        "--frames", metavar="A-B", type=frame_range, help="first and last frame (the stage's)"
    )
    parser.add_argument(
        "--purpose",
        metavar="LIST",
        type=_purposes,
        default=("render",),
        help=f"shown beside `default`, of {','.join(PURPOSES)} (render)",
    )
    parser.add_argument(
        "--variant",
        metavar="PRIM{SET=CHOICE}",
        type=_variants,
        action="append",
        default=[],
        help="takes a variant; may be repeated",
    )
    parser.add_argument(
        "--mask",
        metavar="PRIM",
        action="append",
        default=[],
        help="reads only what is at this path, and what that needs; may be repeated",
    )
    parser.add_argument(
        "--strict", action="store_true", help="refuses a stage of which anything would be lost"
    )
    parser.add_argument(
        "--report", metavar="FILE.json", type=Path, help="also writes counts, frames and losses as JSON"
    )


def run(arguments: argparse.Namespace) -> int:
    """Writes the file and prints the losses."""
    # USD loads slowly, and no other command needs it.
    from ..usd import ImportOptions, import_usd

    report: Path | None = arguments.report
    if report is not None and not report.parent.is_dir():
        raise SceneError(f"{report}: there is no folder {report.parent}")
    variants = tuple(variant for variants in arguments.variant for variant in variants)
    options = ImportOptions(
        arguments.frames, arguments.purpose, variants, tuple(arguments.mask), arguments.strict
    )
    imported = import_usd(arguments.source, arguments.target, options)
    counts = ", ".join(f"{count} {kind}" for kind, count in imported.counts.items() if count)
    print(f"{arguments.target}: frames {imported.frames[0]} to {imported.frames[1]}; {counts}")
    for line in _warnings(imported):
        print(f"warning: {line}", file=sys.stderr)
    if report is not None:
        write_whole(report, _report(arguments.source, imported).encode())
    return OK


def _warnings(imported) -> list[str]:
    """Losses, one a line, by kind; of frequent kinds the first few."""
    lines = []
    for kind in imported.lost:
        found = [lost for lost in imported.every if lost.kind == kind.kind]
        lines += [str(lost) for lost in found[:MOST_SAID]]
        if len(found) > MOST_SAID:
            lines.append(f"[{kind.kind}] {len(found) - MOST_SAID} times more: --report lists each")
    return lines


def _report(source: Path, imported) -> str:
    """JSON that `import_usd.schema.json` describes."""
    losses = [
        {"id": lost.kind, "count": lost.count, "first_place": lost.place, "sentence": lost.sentence}
        for lost in imported.every
    ]
    said = {
        "format_version": REPORT_VERSION,
        "source": str(source),
        "frames": {"first": imported.frames[0], "last": imported.frames[1]},
        "fps": {"numerator": imported.fps.numerator, "denominator": imported.fps.denominator},
        "counts": imported.counts,
        "losses": losses,
    }
    return json.dumps(said, indent=2, ensure_ascii=False) + "\n"


def _purposes(text: str) -> tuple[str, ...]:
    names = tuple(name for name in text.split(",") if name and name != "default")
    if unknown := [name for name in names if name not in PURPOSES]:
        raise argparse.ArgumentTypeError(
            f"`{unknown[0]}` is no purpose: write for instance {','.join(PURPOSES)}"
        )
    return names


def _variants(text: str) -> list[tuple[str, str, str]]:
    match = VARIANT.fullmatch(text)
    if match is None:
        raise argparse.ArgumentTypeError(
            f"`{text}` is no variant: write for instance /World/tree{{season=autumn}}"
        )
    pairs = (pair.split("=") for pair in match[2].strip("{}").split("}{"))
    return [(match[1], name, choice) for name, choice in pairs]
