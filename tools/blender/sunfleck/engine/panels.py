"""Blender's own panels that apply to the engine."""

from collections.abc import Iterator

import bpy

from ..film import ENGINE

# Settings that the engine ignores.
NOT_OURS = {
    "RENDER_PT_simplify",
    "RENDER_PT_freestyle",
    "VIEWLAYER_PT_layer_passes",
    "VIEWLAYER_PT_filter",
    "VIEWLAYER_PT_freestyle",
    "VIEWLAYER_PT_freestyle_edge_detection_options",
    "VIEWLAYER_PT_freestyle_linestyle",
}
# Prefixes of Eevee's panels whose settings Cycles shares.
SHARED = ("EEVEE_MATERIAL_PT_", "EEVEE_WORLD_PT_surface", "EEVEE_WORLD_PT_volume", "DATA_PT_EEVEE_light")


def ours() -> Iterator[set[str]]:
    for panel in bpy.types.Panel.__subclasses__():
        engines = getattr(panel, "COMPAT_ENGINES", None)
        if not isinstance(engines, set) or panel.__name__ in NOT_OURS:
            continue
        is_shared = panel.__name__.startswith(SHARED) and "BLENDER_EEVEE" in engines
        if "BLENDER_RENDER" in engines or is_shared:
            yield engines


def register() -> None:
    for engines in ours():
        engines.add(ENGINE)


def unregister() -> None:
    for engines in ours():
        engines.discard(ENGINE)
