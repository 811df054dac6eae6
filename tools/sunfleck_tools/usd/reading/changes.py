"""Changes of attributes that are read only once. Invariant: equal samples are no change."""

import numpy as np
from pxr import Usd

from .losses import Losses
from .places import codes_of
from .source import Source


def changes(attribute: Usd.Attribute, codes: np.ndarray) -> bool:
    """True if an attribute has different values within the reach of shutters."""
    if not attribute or not attribute.ValueMightBeTimeVarying():
        return False
    first = attribute.Get(float(codes[0]))
    return any(
        not _same(attribute.Get(code), first) for code in codes_of([attribute], codes).tolist()
    )


def say_if_it_changes(
    attribute: Usd.Attribute, source: Source, lost: Losses, what: str, kind: str = "usd-animated"
) -> None:
    """Reports an animated attribute whose value at the first frame is used."""
    if changes(attribute, source.codes):
        lost.add(kind, attribute.GetPrim().GetPath(), f"its {what} changes over time; that of the first frame is taken")


def _same(one: object, other: object) -> bool:
    if one is None or other is None:
        return one is other
    try:
        return bool(np.array_equal(np.asarray(one), np.asarray(other)))
    except (TypeError, ValueError):
        return one == other
