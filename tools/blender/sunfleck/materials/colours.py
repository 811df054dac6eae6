"""Conversion of the working space to linear Rec. 709, glTF's space."""

from typing import Any

import bpy
import numpy

# From XYZ-based definitions, both with the white point D65 (the spaces' own white is adapted after Bradford).
REC709_FROM = {
    "Linear Rec.2020": ((1.660491, -0.587641, -0.072850), (-0.124550, 1.132900, -0.008349), (-0.018151, -0.100579, 1.118730)),
    "ACEScg": ((1.705052, -0.621791, -0.083261), (-0.130257, 1.140803, -0.010546), (-0.024003, -0.128969, 1.152972)),
}


def working_space() -> str:
    """Blender's name of the working space."""
    return (
        getattr(bpy.data.colorspace, "working_space", "Linear Rec.709")
        if hasattr(bpy.data, "colorspace")
        else "Linear Rec.709"
    )


def rec709(color: Any) -> Any:
    """Colour, or rows of colours, from the working space; colours outside Rec. 709 are negative here, and
    become black later."""
    matrix = REC709_FROM.get(working_space())
    if matrix is None:
        return color
    found = numpy.maximum(numpy.asarray(color, float) @ numpy.array(matrix).T, 0.0)
    return tuple(found.tolist()) if found.ndim == 1 else found
