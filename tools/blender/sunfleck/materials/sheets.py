"""Thin-walled Principled BSDFs, for leaves since Blender 5.2.

In goes a shader, out comes the share of the light that its base scatters to the other side, and whether it
is a thin dielectric. Invariant: what is said by other than numbers, but for the weight, is no sheet here.
"""

import bpy


def is_zero(shader: bpy.types.ShaderNode, name: str) -> bool:
    return name not in shader.inputs or (not shader.inputs[name].is_linked and shader.inputs[name].default_value == 0.0)


def is_thin_wall(shader: bpy.types.ShaderNode) -> bool:
    wall = shader.inputs.get("Thin Wall")
    return wall is not None and not wall.is_linked and bool(wall.default_value)


def is_sheet(shader: bpy.types.ShaderNode) -> bool:
    """Whether it is a thin wall that scatters to both sides."""
    return is_thin_wall(shader) and not is_zero(shader, "Subsurface Weight") and not shader.inputs["Subsurface Anisotropy"].is_linked


def through(shader: bpy.types.ShaderNode) -> float:
    """Transmitted share of subsurface scattering, from its anisotropy."""
    return unit(0.5 * (1.0 + shader.inputs["Subsurface Anisotropy"].default_value))


def is_frosted(roughness: float, ior: float) -> bool:
    """Whether a thin dielectric blurs transmission by more than the program's minimum roughness."""
    ior = max(1.0, ior)
    return roughness**2 * 3.4 * (ior - 1.0) * (ior - 0.5) ** 2 / ior**3 > 0.03**2


def is_rough(roughness: float, ior: float) -> bool:
    """Whether a refracting face is rougher than the program's minimum roughness, and refracts at all."""
    return roughness >= 0.03 and 1.0 + 1e-3 < ior <= 3.0


def unit(value: float) -> float:
    return min(1.0, max(0.0, value))
