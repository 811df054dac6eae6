"""Visibility of prims over time, as by `UsdGeom.Imageable.ComputeVisibility`.

An invisible prim hides its descendants, and so does its node. Prims with other ancestors in glTF than in
the stage keep the visibility of those in the stage.
"""

import numpy as np
from pxr import Usd, UsdGeom

from .places import reach
from .source import Source


def says_visibility(prim: Usd.Prim, source: Source) -> bool:
    """True if a prim has authored visibility."""
    if UsdGeom.Tokens.visibility not in source.authored(prim):
        return False
    imageable = UsdGeom.Imageable(prim)
    return bool(imageable) and imageable.GetVisibilityAttr().HasAuthoredValue()


def is_hidden_by_purpose(prim: Usd.Prim, purpose: str, source: Source) -> bool:
    """True if a shape's purpose is invisible by its own or inherited VisibilityAPI (`renderVisibility` and
    so on); the nearest opinion counts."""
    if purpose not in ("render", "proxy", "guide"):
        return False
    at = prim
    while at and not at.IsPseudoRoot():
        if at.HasAPI(UsdGeom.VisibilityAPI):
            attribute = at.GetAttribute(f"{purpose}Visibility")
            value = attribute.Get(source.first) if attribute and attribute.HasAuthoredValue() else None
            if value in (UsdGeom.Tokens.invisible, UsdGeom.Tokens.visible):
                return value == UsdGeom.Tokens.invisible
        at = at.GetParent()
    return False


def up_to(prim: Usd.Prim, last: Usd.Prim) -> list[Usd.Prim]:
    """A prim and its ancestors up to `last`."""
    found = [prim]
    while found[-1] != last and found[-1].GetParent():
        found.append(found[-1].GetParent())
    return found


def seen(prims: list[Usd.Prim], source: Source) -> tuple[np.ndarray, np.ndarray] | None:
    """Codes, and visibility from each on, combined over all prims; None if it is always visible."""
    saying = [prim for prim in prims if says_visibility(prim, source)]
    attributes = [UsdGeom.Imageable(prim).GetVisibilityAttr() for prim in saying]
    if not attributes:
        return None
    samples = [code for attribute in attributes for code in attribute.GetTimeSamples()]
    _, last = reach(source.codes)
    codes = np.unique([source.first, *(code for code in samples if source.first < code <= last)])
    shown = np.array(
        [all(each.Get(code) != UsdGeom.Tokens.invisible for each in attributes) for code in codes.tolist()]
    )
    return None if shown.all() else (codes, shown)
