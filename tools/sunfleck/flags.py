"""Flags from settings: `shutter_position=0.5` is `--shutter-position 0.5`.

Invariant: no flag is listed here; the program itself reports unknown names and values.
"""

import os
from collections.abc import Iterable, Mapping
from numbers import Real
from operator import index
from typing import Any

from .errors import WrongType

OWN = {
    "frames": "which frames is an argument of its own", "progress": "`progress` takes a function or a bool",
    "dry_run": "nothing would be rendered", "skip": "frames that are kept are not told of: render those that lack",
    "help": "help(sunfleck.render) says what there is, and `sunfleck render --help` all flags",
    "version": "sunfleck.__version__ has it", "json": "it is always JSON that is read", "dependencies": "call the program itself",
}  # fmt: skip
"""Flags that this package sets itself, with the reason."""


def as_flags(settings: dict[str, object]) -> list[str]:
    """Arguments of settings. `True` is a flag alone, `None` and `False` are none; sizes are joined by `x`,
    other lists by commas."""
    flags: list[str] = []
    for name, value in settings.items():
        if name in OWN:
            raise WrongType(f"{name} is no setting from Python: {OWN[name]}", f"leave {name} out")
        if value is None or value is False:
            continue
        flags.append(f"--{name.replace('_', '-')}" if value is True else f"--{name.replace('_', '-')}={_text(name, value)}")
    return flags


def path_text(name: str, value: Any) -> str:
    """Path in the program's form."""
    try:
        text = os.fsdecode(value)
    except TypeError:
        raise WrongType(f"{name} is {_told(value)}", f"give {name} a path: a str or a pathlib.Path") from None
    if not text or "\0" in text:
        raise WrongType(f"{name} is {text!r}, which no file is called", f"give {name} the path of a file")
    return text


def frame_number(value: Any) -> int:
    """Number of one frame."""
    try:
        return index(value)
    except TypeError:
        remedy = "give it a whole number, such as 12; render_frames renders several"
        raise WrongType(f"frame is {_told(value)}", remedy) from None


def joined(name: str, values: object) -> str:
    """Frames or passes in the program's form: a text as it is, a number, or a list."""
    if isinstance(values, Iterable) and not isinstance(values, (str, bytes, Mapping)):
        return ",".join(_word(name, each) for each in values) or "none"
    return _word(name, values)


def _word(name: str, value: object) -> str:
    """One number or text."""
    if isinstance(value, os.PathLike):
        return path_text(name, value)
    # Numbers of numpy are instances of Python's abstract numbers.
    if not isinstance(value, (str, Real)) or isinstance(value, bool) or "\0" in str(value):
        raise WrongType(
            f"{name} is or holds {_told(value)}",
            f"give {name} a text or a number as the command line has it, or a list of them",
        )
    return str(value)


def _told(value: object) -> str:
    text = repr(value)
    return f"{text if len(text) <= 60 else text[:57] + '...'}, a {type(value).__name__}"


def _text(name: str, value: Any) -> str:
    if isinstance(value, os.PathLike):
        return path_text(name, value)
    if name == "size" and not isinstance(value, str):
        try:
            return "x".join(str(index(each)) for each in value)
        except TypeError:
            remedy = 'give it two whole numbers, such as (960, 540), or a text, "50%"'
            raise WrongType(f"size is {_told(value)}", remedy) from None
    return joined(name, value)
