"""Principled BSDFs that are thin walls, as leaves are since Blender 5.2.

In goes a shader, out comes the share of the light that its base scatters to the other side. Invariant: what is
said by other than numbers, but for the weight, is no sheet here.
"""

import bpy


def is_zero(shader: bpy.types.ShaderNode, name: str) -> bool:
    return name not in shader.inputs or (not shader.inputs[name].is_linked and shader.inputs[name].default_value == 0.0)


def is_sheet(shader: bpy.types.ShaderNode) -> bool:
    """Whether it is a thin wall that scatters to both sides."""
    wall = shader.inputs.get("Thin Wall")
    if wall is None or wall.is_linked or not wall.default_value:
        return False
    return not is_zero(shader, "Subsurface Weight") and not shader.inputs["Subsurface Anisotropy"].is_linked


def through(shader: bpy.types.ShaderNode) -> float:
    """Of what is below the surface, by its anisotropy."""
    return unit(0.5 * (1.0 + shader.inputs["Subsurface Anisotropy"].default_value))


def unit(value: float) -> float:
    return min(1.0, max(0.0, value))
