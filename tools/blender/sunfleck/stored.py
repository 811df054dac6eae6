"""Custom properties of Blender's data: those that exports wrote, and those written by hand.

In go an owner of properties and what is wanted, out come dictionaries. Invariant: what an export wrote
earlier is never mistaken for a property written by hand, whatever has been unticked since.
"""

import json
from collections.abc import Iterator
from typing import Any

# Add-ons before this stored a light's property as a whole; these are the fields that they may have written.
OF_LIGHTS = (
    "type", "shape", "size", "power_w", "strength_w_m2", "color", "spread", "angle", "radius", "soft_falloff", "shines_inward",
    "visible_to_camera", "visible_in_mirrors", "limb_darkening", "fractal", "picture_rotation", "image",
)


def custom(owner: Any) -> dict[str, Any]:
    """All custom properties that JSON can hold."""
    found = {}
    for name, value in owner.items():
        simple = getattr(value, "to_dict", None) or getattr(value, "to_list", None)
        try:
            found[name] = json.loads(json.dumps(simple() if simple else value, allow_nan=False))
        except (TypeError, ValueError):
            continue
    return found


def by_hand(owner: Any) -> dict[str, Any]:
    """Those of `custom`, and of their fields, that no export wrote."""
    ours = of_exports(owner)
    found: dict[str, Any] = {}
    for name, value in custom(owner).items():
        if name in ours:
            continue
        if isinstance(value, dict):
            left = {field: one for field, one in value.items() if f"{name}.{field}" not in ours}
            if left or not value:
                found[name] = left
        else:
            found[name] = value
    return found


def fields_by_hand(owner: Any, name: str) -> dict[str, Any]:
    """Fields of a property that no export wrote."""
    return fields(by_hand(owner).get(name))


def fields(value: Any) -> dict[str, Any]:
    """Those of a dictionary; what else is written by hand has none."""
    return value if isinstance(value, dict) else {}


def is_by_hand(owner: Any, name: str) -> bool:
    """Whether there is a property of that name that no export wrote."""
    return name in owner and name not in {one.split(".")[0] for one in of_exports(owner)}


def of_exports(owner: Any) -> set[str]:
    """Names of properties, or of their fields as `name.field`, that the last export wrote."""
    own = getattr(owner, "sunfleck_settings", None)
    found = set(own.stored.split()) if own is not None else set()
    if "sunfleck_light" in found:
        found = found - {"sunfleck_light"} | {f"sunfleck_light.{field}" for field in OF_LIGHTS}
    return found


def put(owner: Any, written: dict[str, Any]) -> None:
    """Writes properties, except to linked data; earlier ones of the add-on are removed."""
    if owner.library is not None:
        return
    own, kept = getattr(owner, "sunfleck_settings", None), by_hand(owner)
    said = " ".join(names(written, kept))
    if own is not None and own.stored != said:
        for name in {one.split(".")[0] for one in of_exports(owner)} - written.keys():
            owner.pop(name, None)
        own.stored = said
    for name, value in written.items():
        owner[name] = value


def names(written: dict[str, Any], kept: dict[str, Any]) -> Iterator[str]:
    """Names for `stored`, without fields that only repeat what is written by hand."""
    for name, value in written.items():
        if not isinstance(value, dict):
            yield name
            continue
        by_others = fields(kept.get(name))
        yield from (f"{name}.{field}" for field, one in value.items() if field not in by_others or by_others[field] != one)
