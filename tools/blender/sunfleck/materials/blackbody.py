"""Blackbody colours, as of Blender's node.

In goes a temperature, K, out come three numbers in the working space. Invariant: they are Blender's own,
queried through lights.
"""

from functools import cache
from typing import Any

import bpy
import numpy
from numpy.typing import NDArray

from .colours import working_space

# Colours are constant outside this range.
LOWEST_K, HIGHEST_K, STEP_K = 800, 12000, 5


def color(kelvin: float) -> tuple[float, ...]:
    temperatures, colors = table(working_space())
    return tuple(float(numpy.interp(kelvin, temperatures, channel)) for channel in colors.T)


@cache
def table(_space: str) -> tuple[NDArray[Any], NDArray[Any]]:
    light = bpy.data.lights.new("sunfleck black body", "SUN")
    try:
        temperatures, colors = numpy.arange(LOWEST_K, HIGHEST_K + 1, STEP_K, float), []
        light.use_temperature = True
        for light.temperature in temperatures:
            colors.append(tuple(light.temperature_color))
        return temperatures, numpy.array(colors)
    finally:
        bpy.data.lights.remove(light)
