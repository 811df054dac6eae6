"""glTF document under construction, and its .glb file. Invariant: every view starts at a multiple of four
bytes."""

import hashlib
import json
import struct

import numpy as np

from .container import BINARY_CHUNK, JSON_CHUNK

KINDS = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
FLOAT, UNSIGNED_INT, UNSIGNED_SHORT = 5126, 5125, 5123


class GlbWriter:
    """Lists of a document, by name, and its bytes."""

    def __init__(self, generator: str):
        self.document: dict = {"asset": {"version": "2.0", "generator": generator}, "scene": 0}
        self.extensions: set[str] = set()
        self._binary = bytearray()
        self._known: dict[bytes, int] = {}

    def add(self, kind: str, value: dict) -> int:
        """Appends to a list of the document; returns the index."""
        values = self.document.setdefault(kind, [])
        values.append(value)
        return len(values) - 1

    def view(self, data: bytes) -> int:
        """Adds a buffer view of bytes."""
        start = len(self._binary)
        self._binary += data
        self._binary += b"\0" * (-len(self._binary) % 4)
        return self.add("bufferViews", {"buffer": 0, "byteOffset": start, "byteLength": len(data)})

    def floats(self, rows: np.ndarray, with_bounds: bool = False) -> int:
        """Adds an accessor of rows of numbers; equal rows share one."""
        return self._accessor(FLOAT, np.ascontiguousarray(rows, "<f4").reshape(len(rows), -1), with_bounds)

    def indices(self, triangles: np.ndarray) -> int:
        """Adds an accessor of triangles' corners; equal ones share one."""
        return self._accessor(UNSIGNED_INT, np.ascontiguousarray(triangles, "<u4").reshape(-1, 1))

    def joints(self, rows: np.ndarray) -> int:
        """Adds an accessor of four joints a vertex; equal rows share one."""
        return self._accessor(UNSIGNED_SHORT, np.ascontiguousarray(rows, "<u2"))

    def _accessor(self, component: int, rows: np.ndarray, with_bounds: bool = False) -> int:
        data = rows.tobytes()
        key = b"%d %d %d " % (component, rows.shape[1], with_bounds) + hashlib.blake2b(data).digest()
        if key not in self._known:
            accessor = {
                "bufferView": self.view(data),
                "componentType": component,
                "count": len(rows),
                "type": KINDS[rows.shape[1]],
            }
            if with_bounds:
                accessor["min"], accessor["max"] = rows.min(axis=0).tolist(), rows.max(axis=0).tolist()
            self._known[key] = self.add("accessors", accessor)
        return self._known[key]

    def animate(
        self, node: int, path: str, times_s: np.ndarray, rows: np.ndarray, interpolation: str = "LINEAR"
    ) -> None:
        """Animates a node's property; a file has a single animation."""
        self._channel({"node": node, "path": path}, times_s, rows, interpolation)

    def animate_value(self, pointer: str, times_s: np.ndarray, rows: np.ndarray) -> None:
        """Animates the target of a JSON pointer (KHR_animation_pointer)."""
        self.extensions.add("KHR_animation_pointer")
        target = {"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": pointer}}}
        self._channel(target, times_s, rows, "LINEAR")

    def _channel(self, target: dict, times_s: np.ndarray, rows: np.ndarray, interpolation: str) -> None:
        if "animations" not in self.document:
            self.document["animations"] = [{"channels": [], "samplers": []}]
        animation = self.document["animations"][0]
        sampler = {
            "input": self.floats(times_s[:, None], True),
            "output": self.floats(rows),
            "interpolation": interpolation,
        }
        animation["samplers"].append(sampler)
        animation["channels"].append({"sampler": len(animation["samplers"]) - 1, "target": target})

    def bytes(self) -> bytes:
        """Bytes of the file."""
        if self._binary:
            self.document["buffers"] = [{"byteLength": len(self._binary)}]
        if self.extensions:
            self.document["extensionsUsed"] = sorted(self.extensions)
        return glb(self.document, bytes(self._binary))


def glb(document: dict, binary: bytes) -> bytes:
    """Bytes of a file with a document and a buffer, which may be empty."""
    text = json.dumps(document, separators=(",", ":"), allow_nan=False).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), JSON_CHUNK) + text
    if binary:
        chunks += struct.pack("<II", len(binary), BINARY_CHUNK) + binary
    return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks
