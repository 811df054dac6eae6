"""Kinds of prims by type. Invariant: prims of one type in a stage have one kind, so USD is queried once a
type."""

from dataclasses import dataclass

from pxr import Tf, Usd, UsdGeom, UsdShade, UsdVol

from .shapes import is_shape
from .volumes import FIELDS

NOWHERE = (UsdShade.Material, UsdShade.Shader, UsdGeom.Subset)
"""Types without a place in the scene."""
NOTHING = ("HoudiniLayerInfo",)
"""Types unknown to USD without any effect on pictures."""


@dataclass(frozen=True)
class Kind:
    """Kind of a type of prims."""

    stands_nowhere: bool
    is_xformable: bool
    is_gprim: bool
    is_shape: bool
    is_mesh: bool
    is_camera: bool
    is_instancer: bool
    is_volume: bool
    is_unknown: bool


class Kinds:
    """Kinds of one stage: stages define fallbacks for types that USD does not know."""

    def __init__(self) -> None:
        self._known: dict[str, Kind] = {}

    def of(self, prim: Usd.Prim) -> Kind:
        """The kind of a prim."""
        name = prim.GetTypeName()
        found = self._known.get(name)
        if found is None:
            found = self._known[name] = Kind(
                any(prim.IsA(kind) for kind in NOWHERE) or name in FIELDS,
                prim.IsA(UsdGeom.Xformable),
                prim.IsA(UsdGeom.Gprim),
                is_shape(prim),
                prim.IsA(UsdGeom.Mesh),
                prim.IsA(UsdGeom.Camera),
                prim.IsA(UsdGeom.PointInstancer),
                prim.IsA(UsdVol.Volume),
                bool(name) and name not in NOTHING and prim.GetPrimTypeInfo().GetSchemaType() == Tf.Type.Unknown,
            )
        return found
