"""Passes by name, with channels and units as in `src/passes.rs` (a test compares the two)."""

from collections.abc import Iterable

RADIANCE = "W m^-2 sr^-1"
MATTE_LAYER = "CryptoObject"
PASSES: dict[str, tuple[tuple[str, ...], str]] = {
    "beauty": (("R", "G", "B", "A"), RADIANCE),
    "shafts": (("shafts.R", "shafts.G", "shafts.B"), RADIANCE),
    "transmittance": (("transmittance.R", "transmittance.G", "transmittance.B"), "1"),
    "indirect": (("indirect.R", "indirect.G", "indirect.B"), RADIANCE),
    "indirect-shafts": (("indirect_shafts.R", "indirect_shafts.G", "indirect_shafts.B"), RADIANCE),
    "depth": (("Z",), "m"),
    "normal": (("Normal.X", "Normal.Y", "Normal.Z"), "1"),
    "position": (("Position.X", "Position.Y", "Position.Z"), "m"),
    "albedo": (("albedo.R", "albedo.G", "albedo.B"), "1"),
    "leaf-id": (("leaf_id.X",), "id"),
    "error": (("error.Y",), "1"),
    "motion": (("Vector.X", "Vector.Y", "Vector.Z", "Vector.W"), "px"),
    "cryptomatte": ((), "id"),
}
"""Channels in the order of the array, and their unit, `1` without one. Cryptomatte has as many as it
needs."""


def held(names: Iterable[str]) -> dict[str, tuple[tuple[str, ...], str]]:
    """Passes whose channels a file has completely; a plate's beauty has no alpha."""
    there = list(names)
    matte = sorted((name for name in there if name.startswith(MATTE_LAYER)), key=_layer_then_rgba)
    found = {name: (channels or tuple(matte), unit) for name, (channels, unit) in PASSES.items()}
    if "A" not in there:
        found["beauty"] = ("R", "G", "B"), RADIANCE
    return {name: row for name, row in found.items() if row[0] and set(row[0]) <= set(there)}


def _layer_then_rgba(name: str) -> tuple[str, int]:
    layer, _, component = name.rpartition(".")
    return layer, "RGBA".find(component)
