"""Cryptomatte metadata for Blender's compositor and files: names of ids.

In go a layer's name and its manifest, out come names and values of metadata (Cryptomatte Specification
1.2.0).
"""

from collections.abc import Iterator


def is_manifest(name: str) -> bool:
    """Whether a metadata name is that of a manifest."""
    return name.startswith("cryptomatte/") and name.endswith("/manifest")


def metadata(layer: str, manifest: str) -> Iterator[tuple[str, str]]:
    """Metadata of a layer with a name like `ViewLayer.CryptoObject`."""
    key = f"cryptomatte/{hash_of(layer.encode()):08x}"[: len("cryptomatte/") + 7]
    yield f"{key}/name", layer
    yield f"{key}/hash", "MurmurHash3_32"
    yield f"{key}/conversion", "uint32_to_float32"
    yield f"{key}/manifest", manifest


def hash_of(data: bytes) -> int:
    """MurmurHash3_x86_32 with the seed 0 (Appleby 2011)."""
    found, whole = 0, len(data) & ~3
    for at in range(0, whole, 4):
        found = rotated(found ^ mixed(int.from_bytes(data[at : at + 4], "little")), 13) * 5 + 0xE6546B64 & 0xFFFFFFFF
    found ^= mixed(int.from_bytes(data[whole:], "little")) ^ len(data)
    for shift, factor in ((16, 0x85EBCA6B), (13, 0xC2B2AE35)):
        found = (found ^ found >> shift) * factor & 0xFFFFFFFF
    return found ^ found >> 16


def mixed(word: int) -> int:
    return rotated(word * 0xCC9E2D51 & 0xFFFFFFFF, 15) * 0x1B873593 & 0xFFFFFFFF


def rotated(word: int, bits: int) -> int:
    return (word << bits | word >> 32 - bits) & 0xFFFFFFFF
