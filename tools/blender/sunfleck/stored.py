"""Custom properties of Blender's data: those that exports wrote, and those written by hand.

In go an owner of properties and what is wanted, out come dictionaries. Invariant: what an export wrote
earlier is never mistaken for a property written by hand, whatever has been unticked since.
"""

import json


def plain(value):
    """Custom property as a dictionary."""
    return value.to_dict() if hasattr(value, "to_dict") else {}


def custom(owner):
    """All custom properties that JSON can hold."""
    found = {}
    for name, value in owner.items():
        simple = getattr(value, "to_dict", None) or getattr(value, "to_list", None)
        try:
            found[name] = json.loads(json.dumps(simple() if simple else value, allow_nan=False))
        except (TypeError, ValueError):
            continue
    return found


def by_hand(owner):
    """Those of `custom`, and of their fields, that no export wrote."""
    ours, found = of_exports(owner), {}
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


def is_by_hand(owner, name):
    """Whether there is a property of that name that no export wrote."""
    return name in owner and name not in {one.split(".")[0] for one in of_exports(owner)}


def of_exports(owner):
    """Names of properties, or of their fields as `name.field`, that the last export wrote."""
    own = getattr(owner, "sunfleck_settings", None)
    return set(own.stored.split()) if own is not None else set()


def put(owner, written):
    """Writes properties, except to linked data; earlier ones of the add-on are removed."""
    if owner.library is not None:
        return
    own = getattr(owner, "sunfleck_settings", None)
    said = " ".join(
        f"{name}.{field}" if field else name
        for name, value in written.items()
        for field in (value if isinstance(value, dict) else [""])
    )
    if own is not None and own.stored != said:
        for name in {one.split(".")[0] for one in of_exports(owner)} - written.keys():
            owner.pop(name, None)
        own.stored = said
    for name, value in written.items():
        owner[name] = value
