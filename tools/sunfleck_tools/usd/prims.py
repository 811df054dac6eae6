"""Prims of a layer, written attribute by attribute.

Written as specs in one block of changes: composing after each of a hundred thousand would take minutes.
Invariant: a name is used once in the whole stage, since Blender's objects have no paths.
"""

from collections.abc import Iterable
from typing import Any

import numpy as np
from pxr import Sdf, Tf, Vt

Types = Sdf.ValueTypeNames


class Names:
    """Names that USD takes, each handed out once."""

    def __init__(self):
        self._taken: set[str] = set()

    def new(self, name: str) -> str:
        """The name itself if it can be, or one like it."""
        wanted = Tf.MakeValidIdentifier(name or "unnamed")
        found, count = wanted, 1
        while found.casefold() in self._taken:
            count += 1
            found = f"{wanted}_{count}"
        self._taken.add(found.casefold())
        return found


class Prim:
    """A prim under construction."""

    def __init__(self, spec: Sdf.PrimSpec):
        self.spec = spec
        self.path = spec.path

    @classmethod
    def root(
        cls, layer: Sdf.Layer, name: str, kind: str = "", specifier: Sdf.Specifier = Sdf.SpecifierDef
    ) -> "Prim":
        """A prim at the top of a layer."""
        return cls(Sdf.PrimSpec(layer, name, specifier, kind))

    def child(self, name: str, kind: str = "") -> "Prim":
        """A prim below this one."""
        return Prim(Sdf.PrimSpec(self.spec, name, Sdf.SpecifierDef, kind))

    def set(
        self, name: str, kind: Sdf.ValueTypeName, value: object, uniform: bool = False, custom: bool = False
    ) -> None:
        """An attribute that does not change."""
        self._attribute(name, kind, uniform, custom).default = value

    def animate(
        self,
        name: str,
        kind: Sdf.ValueTypeName,
        codes: Iterable[float],
        values: Iterable,
        custom: bool = False,
    ) -> None:
        """An attribute with a value at each time code; a single one does not change."""
        codes, values = list(codes), list(values)
        if len(codes) == 1:
            return self.set(name, kind, values[0], custom=custom)
        path, layer = self._attribute(name, kind, False, custom).path, self.spec.layer
        for code, value in zip(codes, values):
            layer.SetTimeSample(path, code, value)

    def _attribute(
        self, name: str, kind: Sdf.ValueTypeName, uniform: bool, custom: bool
    ) -> Sdf.AttributeSpec:
        variability = Sdf.VariabilityUniform if uniform else Sdf.VariabilityVarying
        return Sdf.AttributeSpec(self.spec, name, kind, variability, custom)

    def annotate(self, name: str, key: str, value: object) -> None:
        """Metadata of an attribute."""
        self.spec.attributes[name].SetInfo(key, value)

    def connect(self, name: str, kind: Sdf.ValueTypeName, target: Sdf.Path) -> None:
        """An input or output that another one feeds."""
        self._attribute(name, kind, False, False).connectionPathList.explicitItems = [target]

    def relate(self, name: str, *targets: Sdf.Path) -> None:
        """A relationship."""
        relationship = Sdf.RelationshipSpec(self.spec, name, False, Sdf.VariabilityUniform)
        relationship.targetPathList.explicitItems = list(targets)

    def apply(self, *schemas: str) -> None:
        """Applied API schemas."""
        self.spec.SetInfo("apiSchemas", Sdf.TokenListOp.Create(prependedItems=list(schemas)))

    def refer_to(self, target: Sdf.Path) -> None:
        """Everything that another prim of the layer has."""
        self.spec.referenceList.Prepend(Sdf.Reference("", target))

    def remember(self, values: dict) -> None:
        """Custom data below `sunfleck`, for programs that know of it."""
        before = dict(self.spec.customData).get("sunfleck", {})
        if values:
            self.spec.customData = {"sunfleck": {**before, **_plain(values)}}

    def say_name(self, key: str) -> None:
        """The name that the renderer knows the thing by."""
        self.set("userProperties:sunfleck_name", Types.String, key, custom=True)


def _plain(value: object) -> Any:
    """Values as custom data takes them: lists of numbers only."""
    if isinstance(value, dict):
        return {Tf.MakeValidIdentifier(str(key)): _plain(each) for key, each in value.items()}
    if isinstance(value, (list, tuple)) and all(isinstance(each, (int, float)) for each in value):
        return Vt.DoubleArray([float(each) for each in value])
    return value if isinstance(value, (bool, int, float, str)) else str(value)


def vectors(kind: Any, rows: np.ndarray) -> Iterable:
    """Rows as an array of vectors; as one array they are made in half the time."""
    return kind.FromNumpy(np.ascontiguousarray(rows, np.float64 if kind is Vt.Vec3dArray else np.float32))


def quaternions(rows: np.ndarray) -> Vt.QuatdArray:
    """Rows of x, y, z, w. USD takes the arc cosine of w, which in single precision loses turns by less
    than 0.04 degrees."""
    return Vt.QuatdArray.FromNumpy(np.ascontiguousarray(rows, np.float64))
