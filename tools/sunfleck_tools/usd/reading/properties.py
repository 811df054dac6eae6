"""Custom properties of prims to extras: the reverse of `usd/properties.py`."""

import json
from typing import Any

import numpy as np
from pxr import Usd

from ..properties import SPACE
from .places import codes_of
from .source import Source

OURS = f"{SPACE}sunfleck"


def read_properties(
    prim: Usd.Prim, source: Source
) -> tuple[dict[str, dict], dict[str, tuple[np.ndarray, np.ndarray]]]:
    """Properties `sunfleck...` by name and field, and animated ones by `name.field`, codes and rows."""
    found: dict[str, dict] = {}
    carried: dict[str, tuple[np.ndarray, np.ndarray]] = {}
    if not any(name.startswith(OURS) for name in source.authored(prim)):
        return found, carried
    for attribute in prim.GetAuthoredPropertiesInNamespace(SPACE.rstrip(":")):
        name, _, field = attribute.GetName().removeprefix(SPACE).partition(":")
        if (
            not attribute.GetName().startswith(OURS)
            or not field
            or not isinstance(attribute, Usd.Attribute)
        ):
            continue
        value = _plain(attribute.Get(source.first))
        if value is None:
            continue
        found.setdefault(name, {})[field] = value
        codes = codes_of([attribute], source.codes)
        if len(codes) > 1:
            rows = [np.ravel(attribute.Get(code)) for code in codes.tolist()]
            if all(len(row) in (1, 3) and row.dtype.kind in "fiu" for row in rows):
                carried[f"{name}.{field}"] = codes, np.array(rows, float)
    return found, carried


def _plain(value: Any) -> object:
    if isinstance(value, str) and value[:1] in ("[", "{"):
        try:
            return json.loads(value)
        except ValueError:
            return value
    if isinstance(value, (bool, int, str)) or value is None:
        return value
    if isinstance(value, float):
        return value if np.isfinite(value) else None
    array = np.ravel(value)
    return array.tolist() if array.dtype.kind in "fiu" and np.isfinite(array).all() else None


def custom_data(prim: Usd.Prim) -> dict:
    """Custom data of a prim under `sunfleck`, in JSON's types."""
    found = prim.GetCustomDataByKey("sunfleck")
    return _unpacked(found) if isinstance(found, dict) else {}


def _unpacked(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _unpacked(each) for key, each in value.items()}
    return value if isinstance(value, (bool, int, float, str)) else list(map(float, value))


def number_of(prim: Usd.Prim, name: str, source: Source) -> int | None:
    """Integer property."""
    if f"{SPACE}{name}" not in source.authored(prim):
        return None
    value = prim.GetAttribute(f"{SPACE}{name}").Get(source.first)
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return int(value) if is_number and 0 <= value < 2**31 and value == int(value) else None


def text_of(prim: Usd.Prim, name: str, source: Source) -> str | None:
    """Text property."""
    if f"{SPACE}{name}" not in source.authored(prim):
        return None
    value = prim.GetAttribute(f"{SPACE}{name}").Get()
    return value if isinstance(value, str) and value else None
