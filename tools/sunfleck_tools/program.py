"""Path of the program `sunfleck`."""

import os
import shutil
import sysconfig
from collections.abc import Iterator
from pathlib import Path

NAME = "sunfleck"
VARIABLE = "SUNFLECK"


def find_program(named: str | None = None) -> str | None:
    """Path as given, else the environment's SUNFLECK, else the program installed with this package, else
    one of the search path."""
    named = named or os.environ.get(VARIABLE)
    if named:
        return shutil.which(named)
    return shutil.which(NAME, path=os.pathsep.join(_folders_of_scripts())) or shutil.which(NAME)


def _folders_of_scripts() -> Iterator[str]:
    """Folders of pip's scripts, as an environment need not be activated."""
    yield sysconfig.get_path("scripts")
    yield sysconfig.get_path("scripts", sysconfig.get_preferred_scheme("user"))
    # pip install --target
    yield str(Path(__file__).parents[1] / "bin")
