"""Exposure of Cycles' film as a factor on all light, also with the add-on's engine.

Cycles multiplies the film's radiance by its exposure. Light transport is linear, so the same factor on
lights, the sky and all emission gives the same picture.
"""

from typing import Any

import bpy

from .keys import curves_of


# The add-on's render engine.
ENGINE = "SUNFLECK"
HAVE_FILM = {"CYCLES", ENGINE}


def exposure(scene: bpy.types.Scene) -> float:
    """Factor on all emission; other engines have no such setting."""
    return of_cycles(scene, "film_exposure", 1.0) if scene.render.engine in HAVE_FILM else 1.0


def changes(scene: bpy.types.Scene) -> bool:
    """Whether it is keyed or driven."""
    paths = {curve.data_path for curve in curves_of(scene)}
    return scene.render.engine in HAVE_FILM and "cycles.film_exposure" in paths


def is_a_portal(light: bpy.types.Light) -> bool:
    """Whether it only guides Cycles' sampling."""
    return light.type == "AREA" and bool(of_cycles(light, "is_portal", False))


def of_cycles(owner: bpy.types.ID, name: str, default: Any, group: str = "cycles") -> Any:
    """Property of Cycles, which may be disabled."""
    return getattr(getattr(owner, group, None), name, default)
