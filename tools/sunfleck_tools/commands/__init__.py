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
"""Commands that are gone, and what does their work."""

OK, FINDINGS, USAGE, SCENE, IO = 0, 1, 2, 3, 4
INTERRUPTED, TERMINATED = 130, 143
"""Exit codes; the last two as shells have them of signals: 128 and the signal's number."""
