"""`sunfleck-tools`: a command line to a command, and outcomes to exit codes."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from importlib import import_module

from .commands import COMMANDS, IO, OK, SCENE, USAGE
from .errors import SceneError, ToolError


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs a command line and returns its exit code."""
    try:
        chosen = _parser().parse_args(arguments)
        return chosen.run(chosen)
    except SystemExit as exit:  # from argparse
        return exit.code if isinstance(exit.code, int) else USAGE
    except ToolError as error:
        print(f"error: {error}", file=sys.stderr)
        return USAGE if error.is_usage else IO
    except SceneError as error:
        print(f"error: {error}", file=sys.stderr)
        return SCENE
    except BrokenPipeError:
        # Whoever read has enough; Python must not complain at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return OK
    except MemoryError:
        print("error: the memory is not enough for these frames", file=sys.stderr)
        return IO
    except OSError as error:
        print(f"error: {error}", file=sys.stderr)
        return IO
    except KeyboardInterrupt:
        return 130


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="sunfleck-tools", description="Tools around sunfleck's frames and scenes.")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    for name in COMMANDS:
        module = import_module(f".commands.{name}", __package__)
        command = commands.add_parser(name.replace("_", "-"), help=module.HELP, description=module.__doc__)
        module.add_arguments(command)
        command.set_defaults(run=module.run)
    return parser
