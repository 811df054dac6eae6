"""The commands, a module each: `HELP`, `add_arguments(parser)`, and `run(arguments)`, which
returns the exit code."""

COMMANDS = ("validate", "compare", "contact_sheet", "movie", "peers", "export_usd", "import_usd", "farm_simulation")
"""Modules of this package; a command has its module's name, with hyphens."""

OK, FINDINGS, USAGE, SCENE, IO = 0, 1, 2, 3, 4
INTERRUPTED, TERMINATED = 130, 143
"""Exit codes; the last two as shells have them of signals: 128 and the signal's number."""
