"""Counts of visible geometry at every frame, from Blender's dependency graph and from the written file.

In go a record and a file, out come counts by frame and every difference between the two. Invariant: the
file's counts depend on the file alone (`readback`).
"""

from dataclasses import dataclass

import numpy

from ..stored import fields

# Tolerances for rounding and thinned keys: relative areas, relative extents, and metres.
AREA = 1e-4
BOUNDS_M = 1e-4
BOUNDS = 1e-5


@dataclass
class Counted:
    """Counts of one frame; bounds are two corners in glTF's axes, of boxes around instances."""

    instances: int = 0
    area_m2: float = 0.0
    low: numpy.ndarray = None
    high: numpy.ndarray = None
    lights: int = 0

    def __str__(self):
        extent = "nothing" if self.low is None else f"from {places(self.low)} to {places(self.high)}"
        return f"{self.instances} instances, {self.area_m2:.6g} m2, {extent}, {self.lights} lights"


def places(corner):
    return "(" + ", ".join(f"{value:.3f}" for value in corner) + ")"


class Extent:
    """Parts of a geometry that a linear map changes: vector areas of triangles, and the bounding box."""

    def __init__(self, corners):
        flat = corners.reshape(-1, 3)
        self.vectors = 0.5 * numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        self.area = float(numpy.linalg.norm(self.vectors, axis=1).sum())
        low, high = flat.min(axis=0), flat.max(axis=0)
        self.box = numpy.array(
            [[(low, high)[(at >> axis) & 1][axis] for axis in range(3)] for at in range(8)]
        )

    def areas(self, linear):
        """Areas under many maps, (maps, 3, 3)."""
        gram = numpy.swapaxes(linear, 1, 2) @ linear
        square = gram[:, 0, 0]
        off = numpy.abs(gram - square[:, None, None] * numpy.eye(3)).max(axis=(1, 2))
        found = self.area * square
        for row in numpy.flatnonzero(off > 1e-6 * numpy.maximum(square, 1e-12)):
            a, b, c = linear[row].T
            cofactors = numpy.stack([numpy.cross(b, c), numpy.cross(c, a), numpy.cross(a, b)], axis=1)
            found[row] = float(numpy.linalg.norm(self.vectors @ cofactors.T, axis=1).sum())
        return found

    def bounds(self, matrices):
        """Lowest and highest corners of the boxes under many maps."""
        corners = numpy.swapaxes(matrices[:, :3, :3] @ self.box.T, 1, 2) + matrices[:, None, :3, 3]
        return corners.min(axis=1), corners.max(axis=1)


class Counts:
    """Counts by frame."""

    def __init__(self, frames):
        self.numbers = {frame: number for number, frame in enumerate(frames)}
        self.instances, self.area_m2 = numpy.zeros(len(frames), int), numpy.zeros(len(frames))
        self.lows = numpy.full((len(frames), 3), numpy.inf)
        self.highs = -self.lows
        self.lights = numpy.zeros(len(frames), int)

    def add(self, at, extent, matrices):
        """Adds a geometry with placements at frames, one matrix each."""
        lows, highs = extent.bounds(matrices)
        numpy.add.at(self.instances, at, 1)
        numpy.add.at(self.area_m2, at, extent.areas(matrices[:, :3, :3]))
        numpy.minimum.at(self.lows, at, lows)
        numpy.maximum.at(self.highs, at, highs)

    @property
    def of(self):
        """Counts by frame."""
        for frame, at in self.numbers.items():
            bounds = (self.lows[at], self.highs[at]) if self.instances[at] else (None, None)
            yield (
                frame,
                Counted(int(self.instances[at]), float(self.area_m2[at]), *bounds, int(self.lights[at])),
            )


def of_record(record, frames):
    """Counts of a record."""
    from .meshes import turned
    from .places import in_gltf

    counts, extents = Counts(frames), {}
    for (frame, offset), first, (rows, numbers), lamps in zip(
        record.moments, record.first_rows, record.placed, record.lamps
    ):
        if offset != 0.0:
            continue
        at = counts.numbers[frame]
        counts.lights[at] = lamps
        matrices = in_gltf(record.all_matrices[first + rows].astype(float), looks=False)
        for number in numpy.unique(numbers):
            if number not in extents:
                geometry = record.geometries[number]
                extents[number] = Extent(
                    turned(geometry.positions.astype(float)[geometry.corner_vertices[geometry.triangles]])
                )
            here = matrices[numbers == number]
            counts.add(numpy.full(len(here), at), extents[number], here)
    return counts


def of_file(file, frames):
    """Counts of a file."""
    counts, extents = Counts(frames), {}
    seconds = file.seconds(frames)
    worlds, visible = file.worlds(seconds), file.visible(seconds)
    for index, node in enumerate(file.nodes):
        is_lamp = (
            "KHR_lights_punctual" in node.get("extensions", {})
            or fields(node.get("extras", {}).get("sunfleck_light")).get("type") == "area"
        )
        counts.lights += visible[index] & is_lamp
        if "mesh" not in node or not visible[index].any():
            continue
        mesh, weights = node["mesh"], file.weights(index, seconds)
        shapes, of_frame = numpy.unique(weights, axis=0, return_inverse=True)
        for number, shape in enumerate(shapes):
            key = (mesh, shape.tobytes())
            if key not in extents:
                extents[key] = Extent(file.triangles(mesh, shape))
            here = visible[index] & (of_frame.ravel() == number)
            if here.any():
                counts.add(numpy.flatnonzero(here), extents[key], worlds[index][here])
    return counts


def differences(expected, found):
    """Differences, by frame: id, frame, sentence."""
    for (frame, should), (_, there) in zip(expected.of, found.of):
        if should.instances != there.instances:
            yield "count-instances", frame, f"{there.instances} instances, not {should.instances}"
        if abs(should.area_m2 - there.area_m2) > AREA * max(should.area_m2, 1e-12):
            yield "count-area", frame, f"{there.area_m2:.6g} m2, not {should.area_m2:.6g} m2"
        if should.lights != there.lights:
            yield "count-lights", frame, f"{there.lights} lights, not {should.lights}"
        if should.low is None or there.low is None:
            continue
        bar = BOUNDS_M + BOUNDS * float(numpy.abs([should.low, should.high]).max())
        off = max(
            float(numpy.abs(should.low - there.low).max()), float(numpy.abs(should.high - there.high).max())
        )
        if off > bar:
            yield "count-bounds", frame, f"bounds differ by {off:.2e} m"


def different_materials(seen, file):
    """Names of materials that differ between objects and the file's meshes."""
    used = {
        primitive.get("material") for mesh in file.said.get("meshes", ()) for primitive in mesh["primitives"]
    }
    found = {file.said["materials"][number]["name"] for number in used if number is not None}
    if found != seen:
        yield "count-materials", None, f"{', '.join(sorted(found ^ seen))}"
