"""Prims that are drawn, and those that need no node of their own. Invariant: a shape of another type or purpose is
reported."""

from itertools import product

import numpy as np
from pxr import Usd, UsdGeom, UsdLux

from ..properties import SPACE
from .kinds import Kinds
from .losses import Losses
from .options import ImportOptions
from .places import STILL, is_placed, is_reset, local_matrices
from .shapes import is_shape
from .source import Source
from .visibility import is_hidden_by_purpose, says_visibility


def _predicate(is_abstract: bool, is_defined: bool):
    """Predicate of the children to read, those of instances included. Below an `over` or a `class`, which
    may contain prototypes, undefined prims are read too."""
    kinds = Usd.PrimIsActive & Usd.PrimIsLoaded
    kinds = kinds if is_abstract else kinds & ~Usd.PrimIsAbstract
    return Usd.TraverseInstanceProxies(kinds & Usd.PrimIsDefined if is_defined else kinds)


PREDICATES = {pair: _predicate(*pair) for pair in product((False, True), repeat=2)}


def _bounds_fog_of_ours(prim: Usd.Prim) -> bool:
    """True for the guide box of fog that `export-usd` writes."""
    return bool(prim.GetParent().GetPropertiesInNamespace(f"{SPACE}sunfleck_fog_volume"))


def children_of(prim: Usd.Prim) -> list[Usd.Prim]:
    """Children to read."""
    return list(prim.GetFilteredChildren(PREDICATES[prim.IsAbstract(), prim.IsDefined()]))


class Drawn:
    """Answers about prims of one stage."""

    def __init__(self, kinds: Kinds, source: Source, options: ImportOptions, lost: Losses):
        self.kinds, self.source, self.options, self.lost = kinds, source, options, lost

    def holds(self, prim: Usd.Prim) -> bool:
        """Whether a shape is drawn; one of another type or purpose is reported."""
        kind = self.kinds.of(prim)
        if not (kind.is_gprim or kind.is_instancer):
            return True
        purpose = UsdGeom.Imageable(prim).ComputePurpose()
        if purpose != UsdGeom.Tokens.default_ and purpose not in self.options.purposes:
            if not (self.source.by_us or _bounds_fog_of_ours(prim)):
                self.lost.add("usd-purpose", prim, f"is of purpose `{purpose}`, which is not drawn")
            return False
        if is_hidden_by_purpose(prim, str(purpose), self.source):
            return False
        if not (kind.is_shape or kind.is_instancer or kind.is_volume):
            self.lost.add("usd-shape", prim, f"a {prim.GetTypeName()} is not carried, only faces are")
            return False
        return True

    def joins(self, prim: Usd.Prim) -> bool:
        """True if a prim can be merged into its parent's node."""
        kind = self.kinds.of(prim)
        if not (kind.is_shape or kind.is_camera or kind.is_volume or prim.HasAPI(UsdLux.LightAPI)):
            return False
        if (
            says_visibility(prim, self.source)
            or any(self.kinds.of(child).is_xformable for child in children_of(prim))
            or not self.holds(prim)
        ):
            return False
        if is_placed(prim, self.source):
            if is_reset(prim, self.source):
                return False
            _, matrices = local_matrices(prim, self.source)
            return bool(np.abs(matrices - STILL).max() < 1e-12)
        return True

    def only_shapes(self, prototype: Usd.Prim) -> list[Usd.Prim] | None:
        """Visible shapes of a prototype; None if it has more than untransformed shapes."""
        children = [child for child in children_of(prototype) if child.IsA(UsdGeom.Imageable)]
        stands = prototype.IsA(UsdGeom.Xformable) and not UsdGeom.Xformable(prototype).GetOrderedXformOps()
        if not stands or says_visibility(prototype, self.source) or prototype.IsA(UsdGeom.PointInstancer):
            return None
        if is_shape(prototype):
            return None if children else [prototype] if self.holds(prototype) else []
        return (
            children if children and all(is_shape(each) and self.joins(each) for each in children) else None
        )
