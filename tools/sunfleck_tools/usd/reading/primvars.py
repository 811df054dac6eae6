"""Normals, texture coordinates and other primvars of a mesh. Invariant: returned values are finite and
match the mesh."""

from dataclasses import dataclass

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from .changes import say_if_it_changes
from .faces import Faces, value_of
from .losses import Losses
from .source import Source

MOST_LAYERS = 8
COORDINATES = {getattr(Sdf.ValueTypeNames, f"{name}Array") for name in
               ("TexCoord2f", "TexCoord2d", "TexCoord2h", "TexCoord3f", "TexCoord3d", "TexCoord3h", "Float2", "Double2", "Half2")}  # fmt: skip
FIRST_LAYERS = ("st", "UVMap")
UPWARD, FROM_TOP = np.array([1, -1]), np.array([0, 1])
"""glTF counts rows of texels from the top."""


@dataclass(frozen=True)
class Stream:
    """Values with their glTF name: a row for each point (`vertex`, `varying`), corner, face (`uniform`),
    or one."""

    name: str
    values: np.ndarray
    interpolation: str

    @property
    def is_by_point(self) -> bool:
        """Whether corners at a point share a row."""
        return self.interpolation in ("vertex", "varying", "constant")

    def rows(self, faces: Faces) -> np.ndarray:
        """A row for each corner."""
        return self.values[_places(self.interpolation, faces)]


def _places(interpolation: str, faces: Faces) -> np.ndarray | None:
    if interpolation in ("vertex", "varying"):
        return faces.corners
    if interpolation == "faceVarying":
        return np.arange(len(faces.corners))
    if interpolation == "uniform":
        return np.repeat(np.arange(faces.count), faces.counts)
    return np.zeros(len(faces.corners), np.int64) if interpolation == "constant" else None


class Primvars:
    """Primvars of one prim at one time."""

    def __init__(self, prim: Usd.Prim, code: float, faces: Faces, source: Source, lost: Losses):
        self.prim, self.code, self.faces, self.lost = prim, code, faces, lost
        self.authored = source.authored(prim)

    def normals(self) -> Stream | None:
        """Unit normals; the primvar takes precedence over the attribute."""
        if "normals" not in self.authored and "primvars:normals" not in self.authored:
            return None
        primvar = UsdGeom.PrimvarsAPI(self.prim).GetPrimvar("normals")
        if primvar and primvar.HasValue():
            found = self.fit("NORMAL", primvar.ComputeFlattened(self.code), primvar.GetInterpolation(), 3)
        else:
            gprim = UsdGeom.PointBased(self.prim)
            found = self.fit(
                "NORMAL", value_of(gprim.GetNormalsAttr(), self.code), gprim.GetNormalsInterpolation(), 3
            )
        if found is None:
            return None
        lengths = np.linalg.norm(found.values, axis=1)
        if not (lengths > 1e-6).all():
            self.lost.add("usd-primvar", self.prim, "some of its normals have no length: all are those of its faces")
            return None
        return Stream(found.name, found.values / lengths[:, None], found.interpolation)

    def coordinates(self) -> tuple[list[Stream], list[str]]:
        """Texture coordinates, and their names here."""
        streams: list[Stream] = []
        names: list[str] = []
        for name, kind, primvar in self._coordinates()[:MOST_LAYERS]:
            width = 3 if "3" in str(kind) else 2
            values = primvar.ComputeFlattened(self.code)
            found = self.fit(f"TEXCOORD_{len(names)}", values, primvar.GetInterpolation(), width)
            if found is not None:
                streams.append(
                    Stream(found.name, found.values[:, :2] * UPWARD + FROM_TOP, found.interpolation)
                )
                names.append(name)
        return streams, names

    def say_what_changes(self, source: Source, bends: bool) -> None:
        """Reports animated values that are read at one time only: coordinates, and normals of undeformed
        meshes."""
        for name, _, primvar in self._coordinates()[:MOST_LAYERS]:
            for attribute in (primvar.GetAttr(), primvar.GetIndicesAttr()):
                say_if_it_changes(attribute, source, self.lost, f"set of texture coordinates `{name}`")
        for name in () if bends else ("normals", "primvars:normals"):
            if name in self.authored:
                say_if_it_changes(self.prim.GetAttribute(name), source, self.lost, name)

    def _coordinates(self) -> list[tuple[str, Sdf.ValueTypeName, UsdGeom.Primvar]]:
        """Primvars of texture coordinates, by their names; the usual ones first."""
        names = [name for name in self.authored if name.startswith("primvars:")]
        primvars = [UsdGeom.Primvar(self.prim.GetAttribute(name)) for name in names]
        typed = [(each.GetTypeName(), each) for each in primvars if each and each.HasValue()]
        found = [(each.GetPrimvarName(), kind, each) for kind, each in typed if kind in COORDINATES]
        return sorted(found, key=lambda each: (each[0] not in FIRST_LAYERS, each[0]))

    def fit(self, name: str, values, interpolation: str, width: int) -> Stream | None:
        """Values as a stream; None, after a report, if they do not match."""
        array = np.zeros((0, width)) if values is None else np.array(values, float).reshape(-1, width)
        if not len(array) or not len(self.faces.corners):
            return None
        needed = self._needed(interpolation)
        if needed is None or len(array) < needed or not np.isfinite(array).all():
            what = f"{name}: {len(array)} values of interpolation `{interpolation}` that do not fit its faces"
            self.lost.add("usd-primvar", self.prim, f"{what}, or are not finite, are not carried")
            return None
        return Stream(name, array, interpolation)

    def _needed(self, interpolation: str) -> int | None:
        """Number of values that the faces need; None for an unknown interpolation."""
        if interpolation in ("vertex", "varying"):
            return self.faces.ends[1] + 1
        places = _places(interpolation, self.faces)
        return None if places is None else int(places.max()) + 1
