"""Command line of `sunfleck-tools`. In go arguments, out comes the exit code of a command.

Invariant: the exit code is one of the table in `commands`, with a message unless it is 0. Faults of input
or system never give a traceback.
"""

import argparse
import re
import signal
import sys
from collections.abc import Sequence
from importlib import import_module
from typing import NoReturn

from . import __version__
from .commands import COMMANDS, INTERRUPTED, IO, OK, SCENE, SUCCESSORS, TERMINATED, USAGE
from .errors import SceneError, Terminated, ToolError
from .streams import patient_streams
from .words import printable

SEVERITY = re.compile(r"(^|: )(error|warning|note)(\[[\w-]+\])?: ")
DISTRIBUTIONS = {"numpy": "numpy", "OpenEXR": "OpenEXR", "pxr": "usd-core", "PIL": "pillow"}
"""Distributions of packages that some commands import."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs a command line and returns its exit code."""
    with patient_streams() as streams:
        code = _outcome(arguments)
        streams.output.flush()
        if streams.output.lost is not None and code == OK:
            # An output that was wanted in a file is lost.
            print(f"error: the output could not be written: {streams.output.lost.strerror}", file=sys.stderr)
            code = IO
    return code


def _outcome(arguments: Sequence[str] | None) -> int:
    try:
        _hear_termination()
        given = sys.argv[1:] if arguments is None else arguments
        if given and (successor := SUCCESSORS.get(given[0])):
            raise ToolError(f"`{given[0]}` is gone: `{successor}` does its work")
        chosen, rest = _parser().parse_known_args(arguments)
        if rest:
            # By the command's own parser, which shows its usage.
            chosen.parser.error(f"unrecognized arguments: {' '.join(rest)}")
        return chosen.run(chosen)
    except SystemExit as exit:  # from argparse
        return exit.code if isinstance(exit.code, int) else USAGE
    except ToolError as error:
        return _said(error, USAGE if error.is_usage else IO)
    except SceneError as error:
        return _said(error, SCENE)
    except MemoryError as error:
        return _said(
            f"{str(error) or 'memory is not enough'}: choose fewer --processes, or smaller frames", IO
        )
    except OSError as error:
        where = f"{error.filename}: " if error.filename is not None else ""
        return _said(f"{where}{error.strerror or error}", IO)
    except ModuleNotFoundError as error:
        if error.name not in DISTRIBUTIONS:
            raise
        return _said(f"{error.name} is not installed: pip install {DISTRIBUTIONS[error.name]}", USAGE)
    except RecursionError:
        return _said("the input is nested too deeply", SCENE)
    except RuntimeError as error:
        if "start new thread" in str(error):
            return _said("memory is not enough to start a process: choose fewer --processes", IO)
        raise
    except KeyboardInterrupt:
        return INTERRUPTED
    except Terminated:
        return TERMINATED


def _said(what: object, code: int) -> int:
    for line in str(what).splitlines() or [""]:
        # Messages of the program have a severity, with remedies indented below.
        begin = "" if line.startswith("  ") or SEVERITY.search(line) else "error: "
        print(f"{begin}{printable(line)}", file=sys.stderr)
    return code


def _hear_termination() -> None:
    """SIGTERM ends a command as Ctrl-C does, with its temporary files removed."""

    def terminate(*_: object) -> None:
        raise Terminated

    try:
        signal.signal(signal.SIGTERM, terminate)
    except ValueError:  # not the main thread: a caller's own affair
        pass


class Parser(argparse.ArgumentParser):
    """Parser whose errors have printable characters only."""

    def error(self, message: str) -> NoReturn:
        """Ends the program."""
        super().error(printable(message))


def _parser() -> argparse.ArgumentParser:
    parser = Parser(prog="sunfleck-tools", description="Tools around sunfleck's frames and scenes.")
    parser.add_argument("--version", action="version", version=f"sunfleck-tools {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    for name in COMMANDS:
        module = import_module(f".commands.{name}", __package__)
        command = commands.add_parser(name.replace("_", "-"), help=module.HELP, description=module.__doc__)
        module.add_arguments(command)
        command.set_defaults(run=module.run, parser=command)
    return parser
