"""When a prim is seen: `UsdGeom.Imageable.ComputeVisibility`, over time.

Whatever is invisible hides all below it, so a node says for its children what its prim says for its own.
Prims that stand elsewhere in glTF than in the stage bring along what their ancestors say.
"""

import numpy as np
from pxr import Usd, UsdGeom

from .places import reach
from .source import Source


def says_visibility(prim: Usd.Prim, source: Source) -> bool:
    """True if a prim has a word of its own on it."""
    if UsdGeom.Tokens.visibility not in source.authored(prim):
        return False
    imageable = UsdGeom.Imageable(prim)
    return bool(imageable) and imageable.GetVisibilityAttr().HasAuthoredValue()


def is_hidden_by_purpose(prim: Usd.Prim, purpose: str, source: Source) -> bool:
    """True if a shape of a purpose is invisible by what it or what it is in says for that purpose
    (VisibilityAPI: `renderVisibility` and so on); the nearest word counts."""
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
    """A prim and its ancestors, as far as `last`."""
    found = [prim]
    while found[-1] != last and found[-1].GetParent():
        found.append(found[-1].GetParent())
    return found


def seen(prims: list[Usd.Prim], source: Source) -> tuple[np.ndarray, np.ndarray] | None:
    """Codes, and from each on whether all the prims let be seen; None if they always do."""
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
