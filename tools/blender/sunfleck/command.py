"""`blender -b FILE.blend --command sunfleck export|check|render ...`: the same without a window.

The functions are for scripts too: `from sunfleck import command; command.main(["export", "out.glb"])`.
"""

import argparse
import re
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import bpy

from . import export, extras, program, render
from .losses import by_kind

_handle = None


def main(arguments: Sequence[str]) -> int:
    """Runs the command line for the current scene; returns an exit code."""
    parser = argparse.ArgumentParser(prog="sunfleck")
    verbs = parser.add_subparsers(dest="verb", required=True)
    verbs.add_parser("check", help="say what would be lost")
    one = verbs.add_parser("export", help="write a .glb file")
    one.add_argument("output", type=Path)
    one = verbs.add_parser("render", help="export and render; further flags are those of `sunfleck render`")
    one.add_argument("--folder")
    verbs.add_parser("tools", help="`sunfleck-tools`, as they came with the extension", add_help=False)
    try:
        known, others = parser.parse_known_args(arguments)
        if known.verb == "tools":
            return do_tools(others)
        if others and known.verb != "render":
            parser.error(f"what is {' '.join(others)}?")
        if any(word.split("=")[0] == "--out" for word in others):
            parser.error("--folder, not --out, says where frames go")
    except SystemExit as stop:
        return int(stop.code or 0)
    scene = bpy.context.scene
    try:
        return VERBS[known.verb](scene, known, others)
    except export.NotExportable as error:
        print(f"error: {error}", file=sys.stderr)
        return 3


def do_check(scene: bpy.types.Scene, _known: argparse.Namespace, _others: list[str]) -> int:
    told = export.checked(scene)
    for frame, counted in told.counts.of:
        print(f"frame {frame}: {counted}")
    for name, word in told.materials.items():
        print(f"material `{name}`: {word}")
    for finding in by_kind(told.findings):
        print(f"{finding.severity.lower()}{finding}")
    return 0


def do_export(scene: bpy.types.Scene, known: argparse.Namespace, _others: list[str]) -> int:
    for finding in by_kind(export.exported(scene, known.output).findings):
        print(f"{finding.severity.lower()}{finding}", file=sys.stderr)
    return 0


def do_render(scene: bpy.types.Scene, known: argparse.Namespace, others: list[str]) -> int:
    executable = program.find()
    if executable is None:
        print(f"error: {program.MISSING}", file=sys.stderr)
        return 4
    # `//` is the folder of the .blend file, as in Blender.
    folder = Path(bpy.path.abspath(known.folder)).resolve() if known.folder else export.default_folder(scene)
    glb: Path = export.make(folder)
    for warning in export.export(scene, glb):
        print(f"warning{warning}", file=sys.stderr)
    asked = {word.split("=")[0] for word in others}
    own = [flag for flag in render.flags(scene, animation=True, size=size_of(others, scene)) if flag.split("=")[0] not in asked]
    run = render.Run(executable, glb, folder, [*own, *others])
    while not run.is_over():
        tell(run)
        time.sleep(render.LOOK_S)
    code: int = run.wait()
    tell(run)
    for warning in run.warnings():
        print(warning, file=sys.stderr)
    if code:
        print(run.error(), file=sys.stderr)
    return code


def tell(run: render.Run) -> None:
    """Prints frames that were written since the last call."""
    for news in run.news():
        if news["event"] == "frame_written":
            print(f"frame {news['frame']} written to {news['path']}", flush=True)


def size_of(words: Sequence[str], scene: bpy.types.Scene) -> tuple[int, int] | None:
    """Width and height by the flag `--size`, for a render border; None without one that can be read."""
    found = re.search(r"(?:^| )--size[= ](?:(\d+)x(\d+)|([\d.]+)%)(?: |$)", " ".join(words))
    if not found:
        return None
    width, height, percent = found.groups()
    if width:
        return int(width), int(height)
    sides: list[int] = extras.settings(scene)["resolution"]
    # As the program rounds.
    wide, high = (max(1, int(side * float(percent) / 100.0 + 0.5)) for side in sides)
    return wide, high


def do_tools(words: list[str]) -> int:
    """Runs the tools in this process, as Blender's Python has their packages."""
    inside = Path(__file__).parent / "tools"
    if not inside.is_dir():
        print("error: the tools are in the extension that tools/blender/build makes", file=sys.stderr)
        return 4
    bpy.utils.expose_bundled_modules()
    sys.path.insert(0, str(inside))
    try:
        from sunfleck_tools.cli import main as tools

        return tools(words)
    finally:
        sys.path.remove(str(inside))


VERBS: dict[str, Callable[[bpy.types.Scene, argparse.Namespace, list[str]], int]] = {
    "check": do_check, "export": do_export, "render": do_render,
}  # fmt: skip


def register() -> None:
    global _handle
    _handle = bpy.utils.register_cli_command("sunfleck", main)


def unregister() -> None:
    global _handle
    if _handle is not None:
        bpy.utils.unregister_cli_command(_handle)
        _handle = None
