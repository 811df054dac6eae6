"""Properties of Blender's data by name, as Attribute nodes look them up.

In go owners and a name, out come four numbers. Invariant: a custom property comes before a path, an earlier
owner before a later one; what nobody has is black.
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
    """None if it has none that is a number or up to four."""
    value = owner.get(name) if hasattr(owner, "get") else None
    if value is None:
        try:
            # Of a part of a property, like `location.x`, nobody knows.
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
