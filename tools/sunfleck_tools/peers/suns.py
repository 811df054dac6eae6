"""Variants of a scene with another sun. In goes a GLB with one still camera and one still sun, out comes
another file."""

import json
import math
from collections.abc import Callable
from pathlib import Path

from ..gltf.container import chunks
from ..gltf.writer import glb as glb_bytes


def changed(glb: Path, made: Path, change: Callable[[dict], None]) -> Path:
    """Writes a GLB with a change to its document alone."""
    text, binary = chunks(glb.read_bytes(), glb)
    document = json.loads(text)
    change(document)
    made.write_bytes(glb_bytes(document, binary or b""))
    return made


def with_sun(glb: Path, sun: str, made: Path) -> Path:
    """Writes the file with its sun `ahead` of the camera, or with a disc of this many degrees."""

    def change(document: dict) -> None:
        nodes = document["nodes"]
        node = next(node for node in nodes if "KHR_lights_punctual" in node.get("extensions", {}))
        if sun == "ahead":
            camera = next(node for node in nodes if "camera" in node)["matrix"]
            # The sun emits along -z, and the camera looks along its own -z: half a turn about y.
            turned = [-value for value in camera[0:4]] + camera[4:8] + [-value for value in camera[8:12]]
            node["matrix"] = turned + node["matrix"][12:]
        else:
            node.setdefault("extras", {}).setdefault("sunfleck_light", {})["angle"] = math.radians(float(sun))

    return changed(glb, made, change)
