"""Sizes of lights in the world, in stage units."""

import numpy as np
from pxr import Usd, UsdGeom

SCALING = (UsdGeom.XformOp.TypeScale, UsdGeom.XformOp.TypeTransform)
THOMSEN = 1.6075
"""Exponent of Knud Thomsen's formula, within 1.1 % for any ellipsoid and exact for a sphere."""


def moving_scales(prim: Usd.Prim) -> list[Usd.Attribute]:
    """Attributes of a prim and its ancestors that may change its size over time."""
    found = []
    while prim and not prim.IsPseudoRoot():
        xformable = UsdGeom.Xformable(prim)
        if xformable:
            found += [
                operation.GetAttr() for operation in xformable.GetOrderedXformOps() if _scales(operation)
            ]
            if xformable.GetResetXformStack():
                break
        prim = prim.GetParent()
    return found


def _scales(operation: UsdGeom.XformOp) -> bool:
    # UsdGeom also has operations that scale one axis, whose names end like these.
    return operation.GetOpType() in SCALING or "scale" in operation.GetOpName()


def linears(prim: Usd.Prim, codes: np.ndarray) -> np.ndarray:
    """Linear part of the transform to the world, for column vectors, a matrix a code."""
    xformable = UsdGeom.Xformable(prim)
    rows = [np.array(xformable.ComputeLocalToWorldTransform(code), float) for code in codes.tolist()]
    found = np.stack(rows)[:, :3, :3].transpose(0, 2, 1)
    return np.where(np.isfinite(found), found, 0.0)


def instance_linears(prim: Usd.Prim, codes: np.ndarray, still: np.ndarray) -> np.ndarray:
    """The same for an instance, which stands elsewhere than the prim: `still` is its transform at the
    first code."""
    found = linears(prim, codes)
    if abs(np.linalg.det(found[0])) > 0:
        return still @ np.linalg.inv(found[0]) @ found
    return np.broadcast_to(still, found.shape)


def ball_area(halves: np.ndarray) -> np.ndarray:
    """Surface areas of ellipsoids, from rows of their three half axes."""
    a, b, c = (halves**THOMSEN).T
    return 4 * np.pi * ((a * b + a * c + b * c) / 3) ** (1 / THOMSEN)
