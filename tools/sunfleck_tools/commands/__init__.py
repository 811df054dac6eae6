"""The commands, a module each: `HELP`, `add_arguments(parser)`, and `run(arguments)`, which
returns the exit code."""

COMMANDS = ("validate", "peers", "export_usd", "import_usd")
"""Modules of this package; a command has its module's name, with hyphens."""
SUCCESSORS = {
    "compare": "sunfleck diff OUTPUT REFERENCE [--picture FILE|DIR]",
    "contact-sheet": "sunfleck preview DIR --size 25% --out OUT.png",
    "movie": "sunfleck preview DIR --out OUT.webp",
    "farm-simulation": "sunfleck farm INPUT --chunk auto",
}
"""Removed commands, and their replacements."""

OK, FINDINGS, USAGE, SCENE, IO = 0, 1, 2, 3, 4
INTERRUPTED, TERMINATED = 130, 143
"""Exit codes; the last two are a shell's for signals: 128 plus the signal's number."""
