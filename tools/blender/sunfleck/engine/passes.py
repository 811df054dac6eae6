"""Passes of the program, with Blender's names.

In go a scene and a view layer, out come passes to request and passes to register in Blender.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import bpy


@dataclass(frozen=True)
class Pass:
    """Blender's name of a pass, its channels, the kind of its values, and its switch in the view layer."""

    names: tuple[str, ...]
    channels: str
    kind: str
    switch: str = ""


COMBINED, NORMAL, POSITION = "Combined", "Normal", "Position"
# Passes in Blender's world space with z up: the program's axes, with y up, and their signs.
AXES = {"X": ("X", 1.0), "Y": ("Z", -1.0), "Z": ("Y", 1.0)}
PASSES = {
    "depth": Pass(("Depth",), "Z", "VALUE", "use_pass_z"),
    "normal": Pass((NORMAL,), "XYZ", "VECTOR", "use_pass_normal"),
    "position": Pass((POSITION,), "XYZ", "VECTOR", "use_pass_position"),
    "motion": Pass(("Vector",), "XYZW", "VECTOR", "use_pass_vector"),
    "cryptomatte": Pass(
        # Blender compresses channels in small letters without loss, whatever the codec of the file.
        tuple(f"CryptoObject{number:02}" for number in range(3)), "rgba", "COLOR", "use_pass_cryptomatte_object"
    ),
    "shafts": Pass(("shafts",), "RGB", "COLOR"),
    "transmittance": Pass(("transmittance",), "RGB", "COLOR"),
    "indirect": Pass(("indirect",), "RGB", "COLOR"),
    "indirect-shafts": Pass(("indirect_shafts",), "RGB", "COLOR"),
    "albedo": Pass(("albedo",), "RGB", "COLOR"),
    "leaf-id": Pass(("leaf_id",), "X", "VALUE"),
    "error": Pass(("error",), "Y", "VALUE"),
}


def wanted(scene: bpy.types.Scene, layer: bpy.types.ViewLayer) -> list[str]:
    """Names of the requested passes: from the panel, and from the view layer."""
    chosen = scene.sunfleck_settings.passes
    return [
        name
        for name, one in PASSES.items()
        if name in chosen or (one.switch and getattr(layer, one.switch, False))
    ]


# Switches of a layer that are not passes of their own, and Cycles' switches that are.
NO_PASSES = {"use_pass_combined", "use_pass_cryptomatte_accurate"}
OF_CYCLES = ("pass_", "use_pass_", "denoising_store_")


def lacking(layer: bpy.types.ViewLayer) -> list[str]:
    """Other passes that a view layer requests, with Blender's names."""
    ours = NO_PASSES | {one.switch for one in PASSES.values()}
    asked = [(layer, ("use_pass_",)), (getattr(layer, "cycles", None), OF_CYCLES)]
    found = [
        one.name
        for owner, starts in asked
        for one in (owner.bl_rna.properties if owner else ())
        if one.type == "BOOLEAN" and one.identifier.startswith(starts) and one.identifier not in ours
        and getattr(owner, one.identifier)
    ]
    return found + [one.name for one in (*layer.aovs, *layer.lightgroups)]


def registered(scene: bpy.types.Scene, layer: bpy.types.ViewLayer) -> Iterator[tuple[str, str, str]]:
    """Name, channels and kind of each pass to register."""
    yield COMBINED, "RGBA", "COLOR"
    for one in wanted(scene, layer):
        for name in PASSES[one].names:
            yield name, PASSES[one].channels, PASSES[one].kind


def signs(name: str) -> tuple[float, ...] | None:
    """Signs of the channels of a pass, relative to the frame's."""
    return tuple(sign for _, sign in AXES.values()) if name in (NORMAL, POSITION) else None


def channels_of(name: str, count: int) -> tuple[str, ...]:
    """Channels of a frame for one of Blender's passes."""
    if name in (NORMAL, POSITION):
        return tuple(f"{name}.{axis}" for axis, _ in AXES.values())
    if name == COMBINED:
        return tuple("RGBA"[:count])
    if name == "Depth":
        return ("Z",)
    channels = next((one.channels for one in PASSES.values() if name in one.names), "")
    return tuple(f"{name}.{channel.upper()}" for channel in channels)
