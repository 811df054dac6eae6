"""Colours of meshes: primvars displayColor and displayOpacity
(https://openusd.org/release/api/class_usd_geom_gprim.html)."""

from collections.abc import Callable

import numpy as np
from pxr import Usd, UsdGeom, UsdShade

from .losses import Losses
from .shaders import surface_of
from .source import Source

Spread = Callable[[object, str, int], "np.ndarray | None"]
"""Function of values, their interpolation and width that returns a row a corner; None if they do not match
the mesh."""
GREY = (0.18,) * 3
"""Colour without a material or colours: the default diffuse colour of UsdPreviewSurface."""
ROUNDING = 1e-4
READERS = {"diffuseColor": "displayColor", "opacity": "displayOpacity"}


def shows_colors(material: Usd.Prim | None, source: Source) -> bool:
    """Whether a mesh's own colours show: its material reads them, or it has no material."""
    return source.by_us or material is None or reads_colors(material)


def vertex_colors(
    prim: Usd.Prim, material: Usd.Prim | None, code: float, lost: Losses, spread: Spread
) -> np.ndarray | None:
    """COLOR_0 of a mesh, RGB or RGBA, at a time code; None if it has none."""
    api = UsdGeom.PrimvarsAPI(prim)
    rows: list[np.ndarray | None] = []
    for name, width in (("displayColor", 3), ("displayOpacity", 1)):
        primvar = api.FindPrimvarWithInheritance(name)
        if not primvar or not primvar.HasValue():
            rows.append(None)
            continue
        if primvar.ValueMightBeTimeVarying():
            what = f"its {name} changes over time; that of the first frame is taken"
            lost.add("usd-material-animated", prim, what)
        found = spread(primvar.ComputeFlattened(code), primvar.GetInterpolation(), width)
        if found is None:
            lost.add("usd-material-value", prim, f"its {name} does not fit the mesh, and is left out")
        rows.append(None if found is None else within(found, prim, name, lost))
    colors, opacity = rows
    if opacity is None or (opacity >= 1).all():
        return colors
    # With a material, colours multiply its own; without one they replace it.
    plain = np.tile(GREY if material is None else (1.0,) * 3, (len(opacity), 1))
    return np.concatenate([plain if colors is None else colors, opacity], axis=1)


def within(values: np.ndarray, prim: Usd.Prim, name: str, lost: Losses) -> np.ndarray:
    """Values clamped to 0 to 1; more than rounding is reported."""
    if values.size and (values.min() < -ROUNDING or values.max() > 1 + ROUNDING):
        said = f"its {name} goes from {values.min():.4g} to {values.max():.4g}, and is clipped to 0 and 1"
        lost.add("usd-material-value", prim, said)
    return np.clip(values, 0, 1)


def reads_colors(material: Usd.Prim) -> bool:
    """Whether a material's surface reads the mesh's colours."""
    shader, _, dialect = surface_of(UsdShade.Material(material))
    if shader is None or dialect is None:
        return False
    for ours, varname in READERS.items():
        found = shader.GetInput(dialect.names.get(ours, ours))
        for attribute in found.GetValueProducingAttributes() if found else []:
            named = UsdShade.Shader(attribute.GetPrim()).GetInput("varname")
            producers = named.GetValueProducingAttributes() if named else []
            if producers and str(producers[0].Get()) == varname:
                return True
    return False
