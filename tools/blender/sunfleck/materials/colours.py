"""Colours of the file's working space as linear Rec. 709, which is what glTF has."""

from typing import Any

import bpy
import numpy

# From XYZ-based definitions, both with the white point D65 (the spaces' own white is adapted after Bradford).
REC709_FROM = {
    "Linear Rec.2020": ((1.660491, -0.587641, -0.072850), (-0.124550, 1.132900, -0.008349), (-0.018151, -0.100579, 1.118730)),
    "ACEScg": ((1.705052, -0.621791, -0.083261), (-0.130257, 1.140803, -0.010546), (-0.024003, -0.128969, 1.152972)),
}


def working_space() -> str:
    """Its name in Blender."""
    return (
        getattr(bpy.data.colorspace, "working_space", "Linear Rec.709")
        if hasattr(bpy.data, "colorspace")
        else "Linear Rec.709"
    )


def rec709(color: Any) -> Any:
    """Of a colour, or of rows of colours, in the working space; what Rec. 709 lacks is negative
    here and black there."""
    matrix = REC709_FROM.get(working_space())
    if matrix is None:
        return color
    found = numpy.maximum(numpy.asarray(color, float) @ numpy.array(matrix).T, 0.0)
    return tuple(found.tolist()) if found.ndim == 1 else found
