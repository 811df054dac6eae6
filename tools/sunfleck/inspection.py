"""Contents of an input. In goes a path, out comes the JSON of `sunfleck inspect`."""

import json
import os
from collections.abc import Iterable
from typing import Any

from .flags import as_flags, joined, path_text
from .process import answer


def inspect(
    scene: str | os.PathLike[str], frames: str | float | Iterable[float] | None = None, **settings: object
) -> dict[str, Any]:
    """Frame range and rate, cameras, lights, matrices of all nodes at `frames` (by default the first;
    fractions are allowed), and losses. Every field is described in docs/inspect.schema.json. `settings` are
    flags of `sunfleck inspect`.

    Raises a `SunfleckError`, as `render` does.
    """
    chosen = [] if frames is None else [f"--frames={joined('frames', frames)}"]
    found: dict[str, Any] = json.loads(answer(["inspect", "--json", *chosen, *as_flags(settings), "--", path_text("scene", scene)]))
    return found
