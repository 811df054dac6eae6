"""Material bindings by UsdShade's rules (UsdShadeMaterialBindingAPI): inheritance, collections, strength,
purpose."""

from dataclasses import dataclass

from pxr import Usd, UsdGeom, UsdShade

from .losses import Losses
from .shaders import surface_of

PURPOSES = (UsdShade.Tokens.full, UsdShade.Tokens.preview)
"""Final quality first; either falls back on bindings for all purposes."""


@dataclass(frozen=True)
class Bound:
    """Material of a prim, and its subsets of faces with their materials."""

    material: Usd.Prim | None
    subsets: list[tuple[Usd.Prim, Usd.Prim | None]]

    def key(self) -> tuple[str, ...]:
        """Key of a binding, equal for instances that look the same."""
        return tuple(path_of(each) for each in (self.material, *(material for _, material in self.subsets)))


def path_of(prim: Usd.Prim | None) -> str:
    """Path of a prim; for a part of an instance, that of the prototype."""
    if prim is None:
        return ""
    return str((prim.GetPrimInPrototype() if prim.IsInstanceProxy() else prim).GetPath())


def bound_material(prim: Usd.Prim) -> Usd.Prim | None:
    """Material of a prim for final pictures; the one for previews if only that has a known surface.

    Parts of an instance inherit its bindings.
    """
    api = UsdShade.MaterialBindingAPI(prim)
    bound = [api.ComputeBoundMaterial(purpose)[0] for purpose in PURPOSES]
    found = [material for material in bound if material]
    if len(found) == 2 and found[0].GetPrim() != found[1].GetPrim():
        found = [material for material in found if surface_of(material)[2] is not None] or found
    return found[0].GetPrim() if found else None


def _missing(prim: Usd.Prim) -> str | None:
    """Path of a missing material to which a prim or its ancestor is bound."""
    while prim and not prim.IsPseudoRoot():
        api = UsdShade.MaterialBindingAPI(prim)
        for purpose in (UsdShade.Tokens.allPurpose, *PURPOSES):
            for target in api.GetDirectBindingRel(purpose).GetTargets():
                return str(target)
        prim = prim.GetParent()
    return None


def _say_subsets_without_a_family(prim: Usd.Prim, lost: Losses) -> None:
    """Reports subsets outside the material family, whose materials USD ignores."""
    for subset in UsdGeom.Subset.GetAllGeomSubsets(UsdGeom.Imageable(prim)):
        family = str(subset.GetFamilyNameAttr().Get() or "")
        api = UsdShade.MaterialBindingAPI(subset.GetPrim())
        if family != UsdShade.Tokens.materialBind and api.GetDirectBindingRel().GetTargets():
            what = f"is a subset of the family `{family}`, not `materialBind`: its material is passed over"
            lost.add("usd-composition", subset, what)


def read_bound(prim: Usd.Prim, lost: Losses) -> Bound:
    """All bindings of a prim; missing materials are reported."""
    bound = bound_material(prim)
    if bound is None and (target := _missing(prim)) is not None:
        lost.add("usd-missing", prim, f"is bound to {target}, which is no material")
    _say_subsets_without_a_family(prim, lost)
    subsets = [each.GetPrim() for each in UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets()]
    return Bound(bound, [(each, bound_material(each)) for each in subsets])
