"""Which material a prim has, by UsdShade's rules (UsdShadeMaterialBindingAPI): inherited, by collections, by
strength, by purpose."""

from dataclasses import dataclass

from pxr import Usd, UsdGeom, UsdShade

from .losses import Losses
from .shaders import surface_of

PURPOSES = (UsdShade.Tokens.full, UsdShade.Tokens.preview)
"""Final quality first; either falls back on bindings for all purposes."""


@dataclass(frozen=True)
class Bound:
    """A prim's material, and its subsets of faces each with its own."""

    material: Usd.Prim | None
    subsets: list[tuple[Usd.Prim, Usd.Prim | None]]

    def key(self) -> tuple[str, ...]:
        """What differs between instances of the same prim that look different."""
        return tuple(path_of(each) for each in (self.material, *(material for _, material in self.subsets)))


def path_of(prim: Usd.Prim | None) -> str:
    """A prim's path, of an instance's part that of what all instances share."""
    if prim is None:
        return ""
    return str((prim.GetPrimInPrototype() if prim.IsInstanceProxy() else prim).GetPath())


def bound_material(prim: Usd.Prim) -> Usd.Prim | None:
    """The material of a prim for final pictures; for previews where only that has a surface that is known.

    An instance's parts see the bindings of the instance.
    """
    api = UsdShade.MaterialBindingAPI(prim)
    bound = [api.ComputeBoundMaterial(purpose)[0] for purpose in PURPOSES]
    found = [material for material in bound if material]
    if len(found) == 2 and found[0].GetPrim() != found[1].GetPrim():
        found = [material for material in found if surface_of(material)[2] is not None] or found
    return found[0].GetPrim() if found else None


def _missing(prim: Usd.Prim) -> str | None:
    """What a prim without a material is bound to all the same, itself or by what it is in."""
    while prim and not prim.IsPseudoRoot():
        api = UsdShade.MaterialBindingAPI(prim)
        for purpose in (UsdShade.Tokens.allPurpose, *PURPOSES):
            for target in api.GetDirectBindingRel(purpose).GetTargets():
                return str(target)
        prim = prim.GetParent()
    return None


def _say_subsets_without_a_family(prim: Usd.Prim, lost: Losses) -> None:
    """USD passes materials over of subsets that are not of the family for them."""
    for subset in UsdGeom.Subset.GetAllGeomSubsets(UsdGeom.Imageable(prim)):
        family = str(subset.GetFamilyNameAttr().Get() or "")
        api = UsdShade.MaterialBindingAPI(subset.GetPrim())
        if family != UsdShade.Tokens.materialBind and api.GetDirectBindingRel().GetTargets():
            what = f"is a subset of the family `{family}`, not `materialBind`: its material is passed over"
            lost.add("usd-composition", subset, what)


def read_bound(prim: Usd.Prim, lost: Losses) -> Bound:
    """All bindings of a prim; one that leads to no material is said."""
    bound = bound_material(prim)
    if bound is None and (target := _missing(prim)) is not None:
        lost.add("usd-missing", prim, f"is bound to {target}, which is no material")
    _say_subsets_without_a_family(prim, lost)
    subsets = [each.GetPrim() for each in UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets()]
    return Bound(bound, [(each, bound_material(each)) for each in subsets])
