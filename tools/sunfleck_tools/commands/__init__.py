"""The commands, a module each: `HELP`, `add_arguments(parser)`, and `run(arguments)`, which returns the exit code."""

COMMANDS = ("validate",)
"""Modules of this package; a command has its module's name, with hyphens."""

OK, FINDINGS, USAGE, IO = 0, 1, 2, 4
"""Exit codes."""
