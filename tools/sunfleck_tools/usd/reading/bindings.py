"""Which material a prim is bound to, by UsdShade's rules: its own binding, else an ancestor's, or a collection's.

Of the purposes of bindings `preview` comes first, as materials here are UsdPreviewSurfaces; then what is for all, then `full`.
"""

from __future__ import annotations

from dataclasses import dataclass

from pxr import Usd, UsdShade


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
    """The material of a prim. An instance's parts see the bindings of the instance."""
    api = UsdShade.MaterialBindingAPI(prim)
    for purpose in (UsdShade.Tokens.preview, UsdShade.Tokens.full):
        # Each of them falls back to what is for all purposes.
        material = api.ComputeBoundMaterial(purpose)[0]
        if material:
            return material.GetPrim()
    return None


def read_bound(prim: Usd.Prim) -> Bound:
    """All bindings of a prim."""
    subsets = [each.GetPrim() for each in UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets()]
    return Bound(bound_material(prim), [(each, bound_material(each)) for each in subsets])
