"""Meshes with `MeshLightAPI` as emissive surfaces. In goes a prim, out comes its radiance. Invariant: each is a
loss, `usd-mesh-light`, as emissive surfaces light others by indirect light alone."""

import numpy as np
from pxr import Usd, UsdGeom, UsdLux

from .lamp_inputs import LampInputs
from .lamp_sizes import linears
from .losses import Losses
from .source import Source


def read_glow(prim: Usd.Prim, source: Source, lost: Losses) -> tuple[float, float, float] | None:
    """The radiance of a mesh that is a light, W/(m2 sr); None for others."""
    if not prim.HasAPI(UsdLux.LightAPI):
        return None
    inputs, codes = LampInputs(prim, lost), source.codes[:1]
    radiance = inputs.radiance(codes)[0]
    if UsdLux.LightAPI(prim).GetNormalizeAttr().Get(source.first):
        radiance = radiance / max(_area(prim, codes), 1e-30)
    if any(attribute.ValueMightBeTimeVarying() for attribute in inputs.attributes()):
        lost.add("usd-light-input", prim, "how it changes over time is not carried")
    inputs.say_the_rest("MeshLight")
    what = "a mesh that is a light is seen to shine, and lights other things by indirect light alone"
    lost.add("usd-mesh-light", prim, what)
    return tuple(radiance.tolist())


def _area(prim: Usd.Prim, codes: np.ndarray) -> float:
    """Area of a mesh in the world, in stage units squared: fans of triangles around each face's first
    corner."""
    mesh = UsdGeom.Mesh(prim)
    points = np.array(mesh.GetPointsAttr().Get(codes[0]), float).reshape(-1, 3) @ linears(prim, codes)[0].T
    counts = np.array(mesh.GetFaceVertexCountsAttr().Get(codes[0]), int)
    corners = points[np.array(mesh.GetFaceVertexIndicesAttr().Get(codes[0]), int)]
    starts = np.repeat(np.cumsum(counts) - counts, counts)
    along = corners - corners[starts]
    crosses = np.cross(along[:-1], along[1:])[starts[:-1] == starts[1:]]
    faces = starts[:-1][starts[:-1] == starts[1:]]
    sums = [np.bincount(faces, crosses[:, axis], len(corners)) for axis in range(3)]
    return float(0.5 * np.linalg.norm(sums, axis=0).sum())
