"""Command lines run in this process, for the tests."""

import contextlib
import io
import os
import shutil
from pathlib import Path

from sunfleck_tools.cli import main

PROGRAM = shutil.which(os.environ.get("SUNFLECK") or "sunfleck")
"""The renderer, where there is one: tools/test says where it was built."""
NO_PROGRAM = "the program sunfleck is not built: set SUNFLECK"
SEQUENCES = Path(__file__).parents[2] / "sequences"


def run(*arguments: object) -> tuple[int, str, str]:
    """Exit code, output and errors. One process that decodes, unless told otherwise: for a few small frames,
    starting more of them takes longer than their work."""
    if arguments[0] == "validate" and "--processes" not in arguments:
        arguments = (*arguments, "--processes", 1)
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main([str(argument) for argument in arguments])
    return code, out.getvalue(), err.getvalue()
