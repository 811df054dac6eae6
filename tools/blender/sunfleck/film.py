"""Cycles' film in, a factor on all light out: in our engine too, whose picture is Cycles'.

Cycles multiplies what its film has gathered by the film's exposure. Light transport is linear. So lights,
the sky and all emission times that factor give the same picture.
"""

from typing import Any

import bpy

from .keys import curves_of


# Our render engine.
ENGINE = "SUNFLECK"
HAVE_FILM = {"CYCLES", ENGINE}


def exposure(scene: bpy.types.Scene) -> float:
    """By what everything that shines is to be multiplied; other engines have no such setting."""
    return of_cycles(scene, "film_exposure", 1.0) if scene.render.engine in HAVE_FILM else 1.0


def changes(scene: bpy.types.Scene) -> bool:
    """Whether it is keyed or driven."""
    paths = {curve.data_path for curve in curves_of(scene)}
    return scene.render.engine in HAVE_FILM and "cycles.film_exposure" in paths


def of_cycles(owner: bpy.types.ID, name: str, default: Any, group: str = "cycles") -> Any:
    """A property of Cycles, which may be switched off."""
    return getattr(getattr(owner, group, None), name, default)
