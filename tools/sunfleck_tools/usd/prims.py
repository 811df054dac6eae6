"""Prims of a layer, written attribute by attribute.

Specs are written in one change block, as composition after each of a hundred thousand would take minutes.
Invariant: a name is unique in the whole stage, as Blender's objects have no paths.
"""

from collections.abc import Iterable
from typing import Any

import numpy as np
from pxr import Sdf, Tf, Vt

Types = Sdf.ValueTypeNames


class Names:
    """Valid names of USD, each used once."""

    def __init__(self):
        self._taken: set[str] = set()

    def new(self, name: str) -> str:
        """The name itself if it is valid and free, or one like it."""
        wanted = Tf.MakeValidIdentifier(name or "unnamed")
        found, count = wanted, 1
        while found.casefold() in self._taken:
            count += 1
            found = f"{wanted}_{count}"
        self._taken.add(found.casefold())
        return found


class Prim:
    """Prim under construction."""

    def __init__(self, spec: Sdf.PrimSpec):
        self.spec = spec
        self.path = spec.path

    @classmethod
    def root(
        cls, layer: Sdf.Layer, name: str, kind: str = "", specifier: Sdf.Specifier = Sdf.SpecifierDef
    ) -> "Prim":
        """Creates a prim at the top of a layer."""
        return cls(Sdf.PrimSpec(layer, name, specifier, kind))

    def child(self, name: str, kind: str = "") -> "Prim":
        """Creates a prim below this one."""
        return Prim(Sdf.PrimSpec(self.spec, name, Sdf.SpecifierDef, kind))

    def set(
        self, name: str, kind: Sdf.ValueTypeName, value: object, uniform: bool = False, custom: bool = False
    ) -> None:
        """Sets a constant attribute."""
        self._attribute(name, kind, uniform, custom).default = value

    def animate(
        self,
        name: str,
        kind: Sdf.ValueTypeName,
        codes: Iterable[float],
        values: Iterable,
        custom: bool = False,
    ) -> None:
        """Sets an attribute at time codes; a single value is constant."""
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
        """Sets metadata of an attribute."""
        self.spec.attributes[name].SetInfo(key, value)

    def connect(self, name: str, kind: Sdf.ValueTypeName, target: Sdf.Path) -> None:
        """Connects an input or output to its source."""
        self._attribute(name, kind, False, False).connectionPathList.explicitItems = [target]

    def relate(self, name: str, *targets: Sdf.Path) -> None:
        """Sets a relationship."""
        relationship = Sdf.RelationshipSpec(self.spec, name, False, Sdf.VariabilityUniform)
        relationship.targetPathList.explicitItems = list(targets)

    def apply(self, *schemas: str) -> None:
        """Applies API schemas."""
        self.spec.SetInfo("apiSchemas", Sdf.TokenListOp.Create(prependedItems=list(schemas)))

    def refer_to(self, target: Sdf.Path) -> None:
        """Refers to another prim of the layer."""
        self.spec.referenceList.Prepend(Sdf.Reference("", target))

    def remember(self, values: dict) -> None:
        """Sets custom data under `sunfleck`, for programs that use it."""
        before = dict(self.spec.customData).get("sunfleck", {})
        if values:
            self.spec.customData = {"sunfleck": {**before, **_plain(values)}}

    def say_name(self, key: str) -> None:
        """Stores the renderer's name of the object."""
        self.set("userProperties:sunfleck_name", Types.String, key, custom=True)


def _plain(value: object) -> Any:
    """Values as custom data takes them: lists of numbers only."""
    if isinstance(value, dict):
        return {Tf.MakeValidIdentifier(str(key)): _plain(each) for key, each in value.items()}
    if isinstance(value, (list, tuple)) and all(isinstance(each, (int, float)) for each in value):
        return Vt.DoubleArray([float(each) for each in value])
    return value if isinstance(value, (bool, int, float, str)) else str(value)


def texture_coordinates(layer: int) -> str:
    """Name of a set of texture coordinates."""
    return "st" if layer == 0 else f"st{layer}"


def vectors(kind: Any, rows: np.ndarray) -> Iterable:
    """Rows as an array of vectors; a single array converts twice as fast."""
    return kind.FromNumpy(np.ascontiguousarray(rows, np.float64 if kind is Vt.Vec3dArray else np.float32))


def quaternions(rows: np.ndarray) -> Vt.QuatdArray:
    """Quaternions from rows of x, y, z, w. USD computes the arc cosine of w, whose error in single
    precision is below 0.04 degrees."""
    return Vt.QuatdArray.FromNumpy(np.ascontiguousarray(rows, np.float64))
