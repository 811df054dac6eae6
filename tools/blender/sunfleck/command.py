"""`blender -b FILE.blend --command sunfleck export|check|render ...`: the same without a window.

The functions are for scripts too: `from sunfleck import command; command.main(["export", "out.glb"])`.
"""

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import bpy

from . import export, program, render
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
    one.add_argument("--folder", type=Path)
    verbs.add_parser("tools", help="`sunfleck-tools`, as they came with the extension", add_help=False)
    try:
        known, others = parser.parse_known_args(arguments)
        if known.verb == "tools":
            return do_tools(others)
        if others and known.verb != "render":
            parser.error(f"what is {' '.join(others)}?")
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
    folder = known.folder or export.default_folder(scene)
    folder.mkdir(parents=True, exist_ok=True)
    glb = folder / f"{folder.name}.glb"
    for warning in export.export(scene, glb):
        print(f"warning{warning}", file=sys.stderr)
    asked = {word.split("=")[0] for word in others}
    own = [flag for flag in render.flags(scene, animation=True) if flag.split("=")[0] not in asked]
    run = render.Run(executable, glb, folder, [*own, *others])
    code: int = run.wait()
    for news in run.news():
        if news["event"] == "frame_written":
            print(f"frame {news['frame']} written to {news['path']}")
    for warning in run.warnings():
        print(warning, file=sys.stderr)
    if code:
        print(run.error(), file=sys.stderr)
    return code


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
