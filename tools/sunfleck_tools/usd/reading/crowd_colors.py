"""Colours of instances: the instancer's primvars displayColor and displayOpacity with a value for each.

Invariant: every instance has a colour, or none has.
"""

import numpy as np
from pxr import Usd, UsdGeom

from .colors import within
from .losses import Losses

BY_INSTANCE = ("vertex", "varying", "uniform", "faceVarying")
NAMES = (("displayColor", 3), ("displayOpacity", 1))


def instance_colors(prim: Usd.Prim, code: float, count: int, lost: Losses) -> np.ndarray | None:
    """Rows of RGB and opacity at a time code; NaN for the colour where only opacity exists."""
    api = UsdGeom.PrimvarsAPI(prim)
    rows = np.full((count, 4), (np.nan, np.nan, np.nan, 1.0))
    is_found = False
    for (name, width), columns in zip(NAMES, (slice(0, 3), slice(3, 4))):
        primvar = api.GetPrimvar(name)
        # A single value is inherited by descendants as usual.
        if not primvar or not primvar.HasValue() or primvar.GetInterpolation() not in BY_INSTANCE:
            continue
        values = primvar.ComputeFlattened(code)
        array = np.zeros((0, width)) if values is None else np.array(values, float).reshape(-1, width)
        if len(array) < count or not np.isfinite(array[:count]).all():
            lost.add("usd-primvar", prim, f"its {name} has {len(array)} values for {count} instances, or is not finite")
            continue
        rows[:, columns] = within(array[:count], prim, name, lost)
        is_found = True
    return rows if is_found else None


def say_other_primvars(prim: Usd.Prim, lost: Losses) -> None:
    """Reports other values by instance, which materials of prototypes might read."""
    known = {name for name, _ in NAMES}
    for primvar in UsdGeom.PrimvarsAPI(prim).GetPrimvarsWithAuthoredValues():
        if primvar.GetInterpolation() in BY_INSTANCE and primvar.GetPrimvarName() not in known:
            lost.add("usd-primvar", prim, f"its {primvar.GetPrimvarName()} by instance is not carried")
