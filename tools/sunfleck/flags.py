"""Settings to flags: `shutter_position=0.5` is `--shutter-position 0.5`.

Invariant: no flag of the program is listed here; a name or value that it does not know is its own error.
"""

from __future__ import annotations

import os
from collections.abc import Iterable

OWN = {
    "frames": "which frames is an argument of its own", "progress": "`progress` takes a function or a bool",
    "dry_run": "nothing would be rendered", "skip": "frames that are kept are not told of: render those that lack",
    "json": "it is always JSON that is read", "dependencies": "call the program itself",
}  # fmt: skip
"""Flags that are not for callers here, and why."""


def as_flags(settings: dict[str, object]) -> list[str]:
    """The arguments. `True` is a flag alone, `None` and `False` are none; sizes are joined by `x`, other lists by commas."""
    flags: list[str] = []
    for name, value in settings.items():
        if name in OWN:
            raise TypeError(f"{name} is no setting from Python: {OWN[name]}")
        if value is None or value is False:
            continue
        flags.append(f"--{name.replace('_', '-')}" if value is True else f"--{name.replace('_', '-')}={_text(name, value)}")
    return flags


def joined(values: object) -> str:
    """Frames or passes as the program takes them: a text as it is, a number, or a list."""
    if isinstance(values, Iterable) and not isinstance(values, (str, bytes)):
        return ",".join(map(str, values)) or "none"
    return str(values)


def _text(name: str, value: object) -> str:
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if name == "size" and not isinstance(value, str):
        return "x".join(map(str, value))
    return joined(value)
