"""Meshes: polygons with texture coordinates in, OBJ text out.

Invariant: faces are counter-clockwise seen from the front, indices start at 0 here and at 1 in the file.
"""

import math
from dataclasses import dataclass, field
from pathlib import Path

Vector = tuple[float, float, float]


@dataclass
class Mesh:
    """Vertices with one texture coordinate each, and polygons between them."""

    positions: list[Vector] = field(default_factory=list)
    uvs: list[tuple[float, float]] = field(default_factory=list)
    faces: list[tuple[int, ...]] = field(default_factory=list)

    def add(self, other: "Mesh") -> None:
        """Appends another mesh."""
        offset = len(self.positions)
        self.positions += other.positions
        self.uvs += other.uvs
        self.faces += [tuple(i + offset for i in face) for face in other.faces]

    def without_strays(self) -> "Mesh":
        """The same without vertices that no polygon has."""
        kept = sorted({i for face in self.faces for i in face})
        place = {i: k for k, i in enumerate(kept)}
        faces = [tuple(place[i] for i in face) for face in self.faces]
        return Mesh([self.positions[i] for i in kept], [self.uvs[i] for i in kept], faces)

    def triangle_count(self) -> int:
        """Triangles once the polygons are cut up."""
        return sum(len(face) - 2 for face in self.faces)

    def normals(self) -> list[Vector]:
        """Unit vertex normals: face normals weighted with area."""
        sums = [[0.0, 0.0, 0.0] for _ in self.positions]
        for face in self.faces:
            corners = [self.positions[i] for i in face]
            for b, c in zip(corners[1:], corners[2:]):
                normal = cross(subtract(b, corners[0]), subtract(c, corners[0]))
                for i in face:
                    sums[i] = [s + n for s, n in zip(sums[i], normal)]
        return [tuple(s / math.hypot(*total) for s in total) for total in sums]


def subtract(a: Vector, b: Vector) -> Vector:
    """a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def cross(a: Vector, b: Vector) -> Vector:
    """a x b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def number(value: float) -> str:
    """Four decimals, without the zeros that carry nothing."""
    text = f"{value:.4f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def write_obj(path: Path, name: str, mesh: Mesh, smooth: bool) -> None:
    """Writes an OBJ file; `smooth` adds vertex normals. A mesh without texture coordinates has
    none in the file."""
    lines = [f"# {name}: {mesh.triangle_count()} triangles, made by tools/leaves/make_leaves.py", f"o {name}"]
    lines += ["v " + " ".join(map(number, p)) for p in mesh.positions]
    lines += ["vt " + " ".join(map(number, uv)) for uv in mesh.uvs]
    if smooth:
        lines += ["vn " + " ".join(map(number, n)) for n in mesh.normals()]
    corner = ("{0}/{0}" if mesh.uvs else "{0}") if not smooth else ("{0}/{0}/{0}" if mesh.uvs else "{0}//{0}")
    lines += ["f " + " ".join(corner.format(i + 1) for i in face) for face in mesh.faces]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")
