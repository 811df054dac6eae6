"""Principled BSDFs that are thin walls, as leaves are since Blender 5.2.

In goes a shader, out come shares of the light that its base scatters. Invariant: what is not said by numbers
alone is no sheet here.
"""


def is_zero(shader, name):
    return name not in shader.inputs or (not shader.inputs[name].is_linked and shader.inputs[name].default_value == 0.0)


def is_sheet(shader):
    """Whether it is a thin wall that scatters to both sides."""
    wall = shader.inputs.get("Thin Wall")
    if wall is None or wall.is_linked or not wall.default_value or is_zero(shader, "Subsurface Weight"):
        return False
    return not any(shader.inputs[name].is_linked for name in ("Subsurface Weight", "Subsurface Anisotropy", "Metallic"))


def shares(shader):
    """What is reflected and what is let through: by the anisotropy of what is below the surface."""
    weight, anisotropy, metallic = (
        shader.inputs[name].default_value for name in ("Subsurface Weight", "Subsurface Anisotropy", "Metallic")
    )
    through = unit(weight) * (1.0 - unit(metallic)) * unit(0.5 * (1.0 + anisotropy))
    return 1.0 - through, through


def unit(value):
    return min(1.0, max(0.0, value))
