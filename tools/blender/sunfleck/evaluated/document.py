"""glTF file under construction: its lists, and one buffer.

Invariant: counts and bounds of accessors are those of the buffer; equal arrays are stored once.
"""

import json
import os
import struct
from pathlib import Path

import numpy

GENERATOR = "sunfleck add-on"
COMPONENTS = {
    numpy.dtype("f4"): 5126,
    numpy.dtype("u4"): 5125,
    numpy.dtype("u2"): 5123,
    numpy.dtype("u1"): 5121,
}
SHAPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
VERTICES, INDICES = 34962, 34963
JSON_CHUNK, BINARY_CHUNK = 0x4E4F534A, 0x004E4942


class Document:
    """Contents of the file."""

    def __init__(self):
        self.lists = {name: [] for name in ("nodes", "meshes", "materials", "textures", "images", "samplers", "cameras", "accessors")}
        self.lights, self.views, self.pieces, self.size = [], [], [], 0
        self.animation = {"name": "scene", "channels": [], "samplers": []}
        self.extensions, self.scene_extras, self.asset_extras = set(), {}, {}
        self.known = {}

    def add(self, kind, thing):
        """Appends an entry; returns its index."""
        self.lists[kind].append(thing)
        return len(self.lists[kind]) - 1

    def once(self, kind, thing):
        """Index of an entry, which is appended unless it exists."""
        key = (kind, json.dumps(thing, sort_keys=True))
        if key not in self.known:
            self.known[key] = self.add(kind, thing)
        return self.known[key]

    def light(self, thing):
        self.lights.append(thing)
        return len(self.lights) - 1

    def view(self, data, target=None):
        """Index of a buffer view of bytes."""
        gap = -self.size % 4
        self.pieces.append(b"\0" * gap)
        view = {"buffer": 0, "byteOffset": self.size + gap, "byteLength": len(data)}
        self.pieces.append(data)
        self.size += gap + len(data)
        self.views.append(view if target is None else {**view, "target": target})
        return len(self.views) - 1

    def accessor(self, array, target=None, bounds=False, normalized=False):
        """Index of an accessor of an array of rows."""
        array = numpy.ascontiguousarray(array)
        width = 1 if array.ndim == 1 else array.shape[1]
        data = array.tobytes()
        key = (data, array.dtype.str, width, target, normalized)
        if key in self.known:
            return self.known[key]
        said = {
            "bufferView": self.view(data, target), "componentType": COMPONENTS[array.dtype], "count": len(array),
            "type": SHAPES[width],
        }
        if normalized:
            said["normalized"] = True
        if bounds:
            rows = array.reshape(len(array), width)
            said["min"], said["max"] = rows.min(axis=0).tolist(), rows.max(axis=0).tolist()
        self.known[key] = self.add("accessors", said)
        return self.known[key]

    def channel(self, target, times_s, values, interpolation="LINEAR"):
        """Adds a channel of keys."""
        times_s = numpy.asarray(times_s, "f4")
        # Drops times that are equal in single precision.
        kept = numpy.concatenate([[True], numpy.diff(times_s) > 0.0])
        values = numpy.asarray(values, values.dtype if values.dtype == numpy.uint8 else "f4")
        a_time = len(values) // len(times_s)
        values = values.reshape(len(times_s), a_time, -1)[kept].reshape(int(kept.sum()) * a_time, -1)
        sampler = {
            "input": self.accessor(times_s[kept], bounds=True),
            "output": self.accessor(values[:, 0] if values.shape[1] == 1 else values),
        }
        if interpolation != "LINEAR":
            sampler["interpolation"] = interpolation
        key = ("sampler", sampler["input"], sampler["output"], interpolation)
        if key not in self.known:
            self.animation["samplers"].append(sampler)
            self.known[key] = len(self.animation["samplers"]) - 1
        self.animation["channels"].append({"sampler": self.known[key], "target": target})

    def node_channel(self, node, path, times_s, values, interpolation="LINEAR"):
        self.channel({"node": node, "path": path}, times_s, values, interpolation)

    def pointer_channel(self, pointer, times_s, values, interpolation="LINEAR"):
        """Adds a channel of keys for the target of a JSON pointer."""
        self.extensions.add("KHR_animation_pointer")
        target = {"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": pointer}}}
        self.channel(target, times_s, values, interpolation)

    def said(self):
        """The file's JSON."""
        children = {child for node in self.lists["nodes"] for child in node.get("children", ())}
        roots = [index for index in range(len(self.lists["nodes"])) if index not in children]
        scene = {"name": "scene", "nodes": roots} if roots else {"name": "scene"}
        asset = {"version": "2.0", "generator": GENERATOR}
        said = {
            "asset": {**asset, "extras": self.asset_extras} if self.asset_extras else asset,
            "scene": 0,
            "scenes": [{**scene, "extras": self.scene_extras} if self.scene_extras else scene],
            **{name: things for name, things in self.lists.items() if things},
        }
        if self.views:
            said["bufferViews"], said["buffers"] = self.views, [{"byteLength": self.size}]
        if self.animation["channels"]:
            said["animations"] = [self.animation]
        if self.lights:
            self.extensions.add("KHR_lights_punctual")
            said["extensions"] = {"KHR_lights_punctual": {"lights": self.lights}}
        if self.extensions:
            said["extensionsUsed"] = sorted(self.extensions)
        return said

    def write(self, path):
        """Writes a .glb file, whole or not at all."""
        text = json.dumps(self.said(), separators=(",", ":"), allow_nan=False).encode()
        text += b" " * (-len(text) % 4)
        rest = -self.size % 4
        chunks = [(JSON_CHUNK, len(text), [text])]
        if self.size:
            chunks.append((BINARY_CHUNK, self.size + rest, [*self.pieces, b"\0" * rest]))
        beside = Path(path).with_name(f"{Path(path).name}.{os.getpid()}.tmp")
        try:
            with open(beside, "wb") as file:
                file.write(struct.pack("<4sII", b"glTF", 2, 12 + sum(8 + length for _, length, _ in chunks)))
                for kind, length, pieces in chunks:
                    file.write(struct.pack("<II", length, kind))
                    file.writelines(pieces)
            beside.replace(path)
        except OSError as problem:
            raise OSError(f"{path} cannot be written: {problem.strerror}; free room there, or choose another place") from problem
        finally:
            beside.unlink(missing_ok=True)
