"""Reader of .glb files for verification, independent of the writer.

In goes a path, out come world matrices, visibility and deformed vertices for arrays of times. Invariant:
interpolation is glTF's: steps, lines, shortest arcs. Times are compared in single precision, as in files.
"""

import json
import struct
from pathlib import Path

import numpy

KINDS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
RESTS = {"translation": (0.0, 0.0, 0.0), "rotation": (0.0, 0.0, 0.0, 1.0), "scale": (1.0, 1.0, 1.0)}
VISIBLE = "/extensions/KHR_node_visibility/visible"


class File:
    def __init__(self, path):
        data = Path(path).read_bytes()
        (length,) = struct.unpack_from("<I", data, 12)
        self.said = json.loads(data[20 : 20 + length])
        self.bytes = data[28 + length :]
        self.nodes, self.read = self.said.get("nodes", []), {}
        self.parents = {child: index for index, node in enumerate(self.nodes) for child in node.get("children", ())}
        self.channels = {}
        for animation in self.said.get("animations", ()):
            for channel in animation["channels"]:
                self.channels[self.target(channel["target"])] = animation["samplers"][channel["sampler"]]
        extras = self.said["scenes"][self.said.get("scene", 0)].get("extras", {})
        self.settings = extras.get("sunfleck", {})

    @staticmethod
    def target(target):
        if target["path"] != "pointer":
            return target["node"], target["path"]
        pointer = target["extensions"]["KHR_animation_pointer"]["pointer"]
        is_visible = pointer.startswith("/nodes/") and pointer.endswith(VISIBLE)
        return (int(pointer.split("/")[2]), "visible") if is_visible else (pointer, "pointer")

    def seconds(self, frames):
        """Times of frames, as in keys."""
        said = self.settings
        frames = numpy.asarray(frames, float) - said.get("frame_at_zero", 0)
        base = said.get("fps_base", 1.0)
        return frames * (1.001 if abs(base - 1.001) < 1e-6 else base) / said.get("fps", 24.0)

    def accessor(self, number):
        if number not in self.read:
            said = self.said["accessors"][number]
            view = self.said["bufferViews"][said["bufferView"]]
            kind, width = numpy.dtype(KINDS[said["componentType"]]), WIDTHS[said["type"]]
            start = view.get("byteOffset", 0) + said.get("byteOffset", 0)
            found = numpy.frombuffer(self.bytes, kind, said["count"] * width, start)
            self.read[number] = found.reshape(-1, width) if width > 1 else found
        return self.read[number]

    def sampled(self, thing, path, seconds, still):
        """Values at times, (times, channels)."""
        sampler = self.channels.get((thing, path))
        if sampler is None:
            return numpy.broadcast_to(numpy.asarray(still, float), (len(seconds), len(still)))
        times = self.accessor(sampler["input"]).astype("f4")
        values = self.accessor(sampler["output"]).astype(float).reshape(len(times), -1)
        return interpolated(times, values, numpy.asarray(seconds, "f4"), sampler.get("interpolation", "LINEAR"), path)

    def worlds(self, seconds):
        """World matrices (nodes, times, 4, 4)."""
        return self.joined([self.local(index, seconds) for index in range(len(self.nodes))], numpy.matmul)

    def joined(self, own, join):
        """What each node has itself, joined with what is above."""
        found = {}

        def of(index):
            if index not in found:
                found[index] = join(of(self.parents[index]), own[index]) if index in self.parents else own[index]
            return found[index]

        return [of(index) for index in range(len(own))]

    def local(self, index, seconds):
        node = self.nodes[index]
        if "matrix" in node:
            matrix = numpy.array(node["matrix"], float).reshape(4, 4).T
            return numpy.broadcast_to(matrix, (len(seconds), 4, 4))
        translation, rotation, scale = (self.sampled(index, path, seconds, node.get(path, rest)) for path, rest in RESTS.items())
        made = numpy.zeros((len(seconds), 4, 4))
        made[:, :3, :3] = rotations(rotation) * scale[:, None, :]
        made[:, :3, 3], made[:, 3, 3] = translation, 1.0
        return made

    def visible(self, seconds):
        """Visibility (nodes, times)."""
        still = [node.get("extensions", {}).get("KHR_node_visibility", {}).get("visible", True) for node in self.nodes]
        own = [self.sampled(index, "visible", seconds, (float(one),))[:, 0] != 0.0 for index, one in enumerate(still)]
        return self.joined(own, numpy.logical_and)

    def weights(self, index, seconds):
        """Weights of a node's mesh, (times, targets)."""
        node = self.nodes[index]
        still = node.get("weights", self.said["meshes"][node["mesh"]].get("weights", ()))
        return self.sampled(index, "weights", seconds, still)

    def triangles(self, mesh, weights=()):
        """Corners (triangles, 3, 3) of a mesh with these weights."""
        found = []
        for primitive in self.said["meshes"][mesh]["primitives"]:
            positions = self.accessor(primitive["attributes"]["POSITION"]).astype(float)
            for weight, target in zip(weights, primitive.get("targets", ())):
                if weight:
                    positions = positions + weight * self.accessor(target["POSITION"])
            found.append(positions[self.accessor(primitive["indices"]).reshape(-1, 3)])
        return numpy.concatenate(found)


def interpolated(times, values, seconds, interpolation, path):
    after = numpy.searchsorted(times, seconds, side="right")
    low = numpy.clip(after - 1, 0, len(times) - 1)
    high = numpy.clip(after, 0, len(times) - 1)
    if interpolation == "STEP":
        return values[low]
    span = times[high].astype(float) - times[low].astype(float)
    share = numpy.divide(
        seconds.astype(float) - times[low], span, out=numpy.zeros(len(seconds)), where=span > 0.0
    )[:, None]
    share = numpy.clip(share, 0.0, 1.0)
    if path != "rotation":
        return (1.0 - share) * values[low] + share * values[high]
    return arc(values[low], values[high], share)


def arc(start, end, share):
    """Shortest arc, at constant speed."""
    cosine = (start * end).sum(axis=1, keepdims=True)
    end = numpy.where(cosine < 0.0, -end, end)
    angle = numpy.arccos(numpy.clip(numpy.abs(cosine), 0.0, 1.0))
    sine = numpy.sin(angle)
    near = sine < 1e-6
    safe = numpy.where(near, 1.0, sine)
    a = numpy.where(near, 1.0 - share, numpy.sin((1.0 - share) * angle) / safe)
    b = numpy.where(near, share, numpy.sin(share * angle) / safe)
    found = a * start + b * end
    return found / numpy.linalg.norm(found, axis=1, keepdims=True)


def rotations(quaternions):
    x, y, z, w = (quaternions / numpy.linalg.norm(quaternions, axis=1, keepdims=True)).T
    rows = (
        (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
        (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
        (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
    )
    return numpy.stack([numpy.stack(row, axis=-1) for row in rows], axis=1)
