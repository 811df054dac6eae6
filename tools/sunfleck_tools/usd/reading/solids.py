"""Spheres, cubes, cylinders, cones, capsules and planes as faces.

In goes a prim of one of `SOLIDS`, out come points, faces and normals. Invariant: a solid has the same
faces at every time.
"""

import math
from dataclasses import dataclass

import numpy as np
from pxr import Usd

from ...errors import SceneError
from .faces import Faces, value_of

SOLIDS = ("Capsule", "Capsule_1", "Cone", "Cube", "Cylinder", "Cylinder_1", "Plane", "Sphere")
AROUND = 48
"""Faces about an axis: chords stray from a circle by 0.2 % of its radius."""
ALONG = 24
"""Faces from pole to pole."""
TURNS = {"X": [2, 0, 1], "Y": [1, 2, 0], "Z": [0, 1, 2]}
"""Permutation of x, y and z that moves the axis to z; it is cyclic, so orientation is kept."""


@dataclass(frozen=True)
class Solid:
    """Points, faces, and a normal for each corner."""

    points: np.ndarray
    faces: Faces
    normals: np.ndarray


@dataclass(frozen=True)
class _Profile:
    """Profile of a solid of revolution about z: radius and height of its points from below, their normals,
    and which ends are on the axis."""

    places: np.ndarray
    normals: np.ndarray
    starts_at_pole: bool = False
    ends_at_pole: bool = False


def sizes_of(prim: Usd.Prim) -> list[Usd.Attribute]:
    """Attributes that a solid's points depend on."""
    names = ("size", "radius", "radiusTop", "radiusBottom", "height", "width", "length")
    return [prim.GetAttribute(name) for name in names if prim.GetAttribute(name)]


def read_solid(prim: Usd.Prim, code: float) -> Solid:
    """A solid at a time code. Raises `SceneError`."""
    sizes = {each.GetName(): float(value_of(each, code, 0.0)) for each in sizes_of(prim)}
    if not all(math.isfinite(size) for size in sizes.values()):
        raise SceneError(f"{prim.GetPath()}: its sizes are not all finite")
    kind = prim.GetTypeName()
    axis = str(value_of(prim.GetAttribute("axis"), code, "Z"))
    if axis not in TURNS:
        raise SceneError(f"{prim.GetPath()}: its axis is `{axis}`, not X, Y or Z")
    if kind == "Cube":
        return _cube(sizes["size"])
    if kind == "Plane":
        return _plane(sizes["width"], sizes["length"], axis)
    top, bottom = (sizes.get(name, sizes.get("radius", 0.0)) for name in ("radiusTop", "radiusBottom"))
    half = 0.5 * sizes.get("height", 0.0)
    if kind == "Sphere":
        profiles = [_arc(top, 0.0, -90, 90)]
    elif kind.startswith("Capsule"):
        profiles = _capsule(bottom, top, half)
    elif kind == "Cone":
        profiles = [_cap(bottom, -half), _slope(bottom, 0.0, half)]
    else:
        profiles = [_cap(bottom, -half), _slope(bottom, top, half), _cap(top, half)]
    solid = _joined([_turned(profile) for profile in profiles])
    return Solid(solid.points[:, TURNS[axis]], solid.faces, solid.normals[:, TURNS[axis]])


def _capsule(bottom: float, top: float, half: float) -> list[_Profile]:
    """Caps continue the slope smoothly, as in USD: they are less or more than half spheres if radii
    differ."""
    rise = (bottom - top) / (2 * half) if half > 0 else 0.0
    larger, angle = math.hypot(1.0, rise), math.degrees(math.atan(rise))
    return [
        _arc(bottom * larger, -half - bottom * rise, -90, angle),
        _slope(bottom, top, half),
        _arc(top * larger, half - top * rise, angle, 90),
    ]


def _arc(radius: float, height: float, first_deg: float, last_deg: float) -> _Profile:
    steps = max(round(ALONG * (last_deg - first_deg) / 180), 1)
    angles = np.radians(np.linspace(first_deg, last_deg, steps + 1))
    normals = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return _Profile(radius * normals + [0, height], normals, first_deg == -90, last_deg == 90)


def _slope(bottom: float, top: float, half: float) -> _Profile:
    normal = np.array([2 * half, bottom - top])
    normal = normal / (np.linalg.norm(normal) or 1.0)
    return _Profile(np.array([[bottom, -half], [top, half]]), np.stack([normal, normal]), False, top == 0)


def _cap(radius: float, height: float) -> _Profile:
    """Disc that faces outwards."""
    if height < 0:
        return _Profile(np.array([[0, height], [radius, height]]), np.array([[0.0, -1.0]] * 2), True)
    return _Profile(np.array([[radius, height], [0, height]]), np.array([[0.0, 1.0]] * 2), False, True)


def _turned(profile: _Profile) -> Solid:
    angles = 2 * np.pi * np.arange(AROUND) / AROUND
    rings = len(profile.places)
    # Points at a pole belong to the adjacent faces, and have the normals of their centres.
    turns = np.tile(angles, (rings, 1))
    turns[0] += np.pi / AROUND * profile.starts_at_pole
    turns[-1] += np.pi / AROUND * profile.ends_at_pole

    def spun(values: np.ndarray) -> np.ndarray:
        outward, up = values[:, :1], values[:, 1:]
        return np.stack([outward * np.cos(turns), outward * np.sin(turns), up + 0 * turns], axis=2).reshape(
            -1, 3
        )

    at = np.arange(rings * AROUND).reshape(rings, AROUND)
    beside = np.roll(at, -1, axis=1)
    counts, corners = [], []
    for ring in range(rings - 1):
        quad = [at[ring], beside[ring], beside[ring + 1], at[ring + 1]]
        if profile.starts_at_pole and ring == 0:
            quad = [at[ring], beside[ring + 1], at[ring + 1]]
        elif profile.ends_at_pole and ring == rings - 2:
            quad = [at[ring], beside[ring], at[ring + 1]]
        counts.append(np.full(AROUND, len(quad)))
        corners.append(np.stack(quad, axis=1).ravel())
    corners = np.concatenate(corners)
    faces = Faces(np.concatenate(counts), corners, np.zeros(0, np.int64))
    return Solid(spun(profile.places), faces, spun(profile.normals)[corners])


def _joined(solids: list[Solid]) -> Solid:
    starts = np.cumsum([0] + [len(each.points) for each in solids])
    corners = np.concatenate([each.faces.corners + start for each, start in zip(solids, starts)])
    faces = Faces(np.concatenate([each.faces.counts for each in solids]), corners, np.zeros(0, np.int64))
    points = np.concatenate([each.points for each in solids])
    return Solid(points, faces, np.concatenate([each.normals for each in solids]))


def _cube(size: float) -> Solid:
    square = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], float)
    front = np.column_stack([square, np.ones(4)])
    back = np.column_stack([square[::-1], -np.ones(4)])
    sides = [side[:, turn] for turn in TURNS.values() for side in (front, back)]
    normals = [np.sign(each.mean(axis=0)) for each in sides]
    faces = Faces(np.full(6, 4), np.arange(24), np.zeros(0, np.int64))
    return Solid(0.5 * size * np.concatenate(sides), faces, np.repeat(normals, 4, axis=0))


def _plane(width: float, length: float, axis: str) -> Solid:
    """Plane: its width is along x, or along z if it faces x; its length along y, or along z if it faces y."""
    across, along = {"X": (2, 1), "Y": (0, 2), "Z": (0, 1)}[axis]
    points = np.zeros((4, 3))
    points[:, across] = 0.5 * width * np.array([-1, 1, 1, -1])
    points[:, along] = 0.5 * length * np.array([-1, -1, 1, 1])
    order = [0, 1, 2, 3] if axis == "Z" else [3, 2, 1, 0]
    normal = np.eye(3)["XYZ".index(axis)]
    return Solid(
        points, Faces(np.array([4]), np.array(order), np.zeros(0, np.int64)), np.tile(normal, (4, 1))
    )
