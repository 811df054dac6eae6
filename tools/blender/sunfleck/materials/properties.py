"""Properties of Blender's data by name, as for Attribute nodes.

In go owners and a name, out come four numbers. Invariant: custom properties take precedence over paths,
and earlier owners over later ones; a missing property is black.
"""

from collections.abc import Iterable
from typing import Any

NOBODY = (0.0, 0.0, 0.0, 0.0)


def first(owners: Iterable[Any], name: str) -> tuple[float, ...]:
    for owner in owners:
        found = None if owner is None else of(owner, name)
        if found is not None:
            return found
    return NOBODY


def of(owner: Any, name: str) -> tuple[float, ...] | None:
    """Value of a property; None unless it is a number or up to four."""
    value = owner.get(name) if hasattr(owner, "get") else None
    if value is None:
        try:
            # Components such as `location.x` are not found.
            is_whole = type(owner.path_resolve(name, False)).__name__ in {"bpy_prop", "bpy_prop_array"}
            value = owner.path_resolve(name) if is_whole else None
        except (ValueError, AttributeError):
            return None
    return four(value)


def four(value: Any) -> tuple[float, ...] | None:
    if isinstance(value, (bool, int, float)):
        return (float(value),) * 3 + (1.0,)
    try:
        parts = [float(part) for part in value]
    except (TypeError, ValueError):
        return None
    if isinstance(value, str) or len(parts) > 4:
        return None
    return tuple([*parts, *(0.0, 0.0, 0.0, 1.0)[len(parts):]])
