"""Leaves: a flat blade in, a folded and curled mesh with its petiole out.

A leaf lies in the xz plane with its upper side towards +y, tip towards -z, petiole towards +z. It is one
unit long from end to end. Its origin is the middle of its blade, about which it tumbles; of one that
hangs it is the petiole's end. Invariant: the blade is an open manifold sheet, the petiole a closed prism
or a strip beside it.
"""

import math
from dataclasses import dataclass

from mesh import Mesh, Vector
from outlines import Blade, Point
from triangulate import contains, distance_to_outline, distance_to_segment, simplify, triangulate


@dataclass(frozen=True)
class Detail:
    """How finely a leaf is cut up."""

    suffix: str
    spacing: float | None
    """Distance of interior points; None for none but the midrib's."""
    spine_points: int
    petiole_sides: int
    smooth: bool
    vein_spacing: float | None = None
    """Distance of points along the side veins; None for a blade that is even between its
    midrib and its edge."""


@dataclass(frozen=True)
class Pose:
    """How a leaf is bent out of its plane."""

    fold_rad: float
    """Each half rises by this at the midrib."""
    curl_rad: float
    """Angle that the leaf's length turns through; positive bends the tip down."""
    cup: float
    """How much the edges droop, per square of the distance from the midrib."""
    ripple: float
    """Amplitude of the waves along the edge."""
    width: float = 1.0
    """How wide it is for its length, of what its species is."""


NEAR = Detail("near", 0.075, 13, 4, True, 0.06)
FAR = Detail("far", 0.24, 4, 0, True)
CANOPY = Detail("canopy", None, 0, 0, False)


# How far the blade rises between its veins, in blade lengths, and how far from a vein it has.
RELIEF, RELIEF_REACH = 0.012, 0.07


def distance_to_veins(p: Point, veins: list[list[Point]]) -> float:
    """Distance of `p` from the nearest of the veins."""
    return min(distance_to_segment(p, a, b) for vein in veins for a, b in zip(vein, vein[1:]))


def points_along(vein: list[Point], spacing: float) -> list[Point]:
    """Points of a vein about `spacing` apart, without its ends."""
    points = []
    for a, b in zip(vein, vein[1:]):
        steps = max(1, round(math.dist(a, b) / spacing))
        points += [
            (a[0] + (b[0] - a[0]) * i / steps, a[1] + (b[1] - a[1]) * i / steps) for i in range(1, steps + 1)
        ]
    return points[:-1]


def interior_points(blade: Blade, outline: list[Point], detail: Detail) -> list[Point]:
    """The midrib, side veins if there are any, and a hexagonal grid mirrored about the midrib, away from them
    and from the edge."""
    spine = [(0.0, (i + 1) / (detail.spine_points + 1)) for i in range(detail.spine_points)]
    spine = [p for p in spine if contains(outline, p) and distance_to_outline(p, outline) > 0.005]
    if detail.spacing is None:
        return spine
    grid = []
    row_height = detail.spacing * math.sqrt(0.75)
    for row in range(-4, math.ceil(1.2 / row_height)):
        for column in range(math.ceil(0.8 / detail.spacing)):
            x = detail.spacing * (column + (0.75 if row % 2 else 1.2))
            grid += [(x, row * row_height), (-x, row * row_height)]
    clearance = detail.spacing * 0.45
    grid = [p for p in grid if contains(outline, p) and distance_to_outline(p, outline) > clearance]
    if detail.vein_spacing is None:
        return spine + grid
    on_veins = list(spine)
    for p in (p for vein in blade.veins for p in points_along(vein, detail.vein_spacing)):
        clear = all(math.dist(p, q) > 0.4 * detail.vein_spacing for q in on_veins)
        if clear and contains(outline, p) and distance_to_outline(p, outline) > 0.4 * detail.vein_spacing:
            on_veins.append(p)
    return on_veins + [p for p in grid if distance_to_veins(p, blade.veins) > 0.4 * detail.vein_spacing]


def bend(x: float, z: float, lift: float, pose: Pose) -> Vector:
    """From the blade's plane to space: fold, droop and ripple as height, then the length rolled onto an arc.

    Space is turned by half a turn about y, since a blade's tip lies at +z in its outline.
    """
    distance = abs(x)
    height = lift + math.sin(pose.fold_rad) * distance - pose.cup * distance * distance
    edge = min(1.0, distance / 0.3)
    height += pose.ripple * edge * math.sin(9.0 * z + 5.0 * x + 1.0)
    across = pose.width * x * math.cos(pose.fold_rad)
    # The arc's centre lies below the blade's middle.
    angle = pose.curl_rad * (z - 0.5)
    if abs(pose.curl_rad) < 1e-6:
        return (-across, height, 0.5 - z)
    radius = 1.0 / pose.curl_rad
    return (-across, (radius + height) * math.cos(angle) - radius, -(radius + height) * math.sin(angle))


def petiole(blade: Blade, detail: Detail) -> tuple[list[tuple[float, float, float]], list[tuple[int, ...]]]:
    """Points as (x, z, lift) and faces: a tapered prism, a strip if it has no sides,
    nothing for the canopy."""
    if detail.spacing is None:
        return [], []
    sides = detail.petiole_sides
    rings = (
        [0.03, -blade.petiole_length * 0.5, -blade.petiole_length] if sides else [0.02, -blade.petiole_length]
    )
    points, faces = [], []
    for z in rings:
        radius = 0.010 + 0.006 * max(0.0, -z) / blade.petiole_length
        if not sides:
            points += [(-radius * 1.4, z, -0.004), (radius * 1.4, z, -0.004)]
            continue
        for k in range(sides):
            angle = math.tau * k / sides
            points.append((radius * math.cos(angle), z, radius * math.sin(angle) - 0.012))
    width = sides or 2
    for ring in range(len(rings) - 1):
        for k in range(sides or 1):
            a, b = ring * width + k, ring * width + (k + 1) % width
            faces.append((a, a + width, b + width, b))
    if sides:
        last = (len(rings) - 1) * width
        faces += [tuple(range(width)), tuple(last + k for k in reversed(range(width)))]
    return points, faces


def flat_frame(blade: Blade) -> tuple[float, float]:
    """Scale and offset of texture space: u = 0.5 + s x, v = s (z - z0) + margin."""
    lowest = min(-blade.petiole_length, min(z for _, z in blade.outline))
    widest = max(abs(x) for x, _ in blade.outline)
    scale = 0.96 / max(1.0 - lowest, 2 * widest)
    return scale, lowest


def texture_position(blade: Blade, x: float, z: float) -> tuple[float, float]:
    """Where a point of the plane lies in the picture; v points up, as in OBJ."""
    scale, lowest = flat_frame(blade)
    return (0.5 + scale * x, 0.02 + scale * (z - lowest))


def make_leaf(
    blade: Blade, detail: Detail, outline_tolerance: float, pose: Pose, hangs: bool = False
) -> Mesh:
    """The mesh of one leaf, whose outline may err by `outline_tolerance` blade lengths."""
    tip = max(range(len(blade.outline)), key=lambda i: blade.outline[i][1])
    right = simplify(blade.outline[: tip + 1], outline_tolerance)
    left = simplify(blade.outline[tip:] + blade.outline[:1], outline_tolerance)
    outline = right + left[1:-1]
    points, triangles = triangulate(outline, interior_points(blade, outline, detail))

    def lift(p: Point) -> float:
        # Where the veins of a maple meet there is no room for ridges between them.
        spread = min(1.0, math.hypot(*p) / 0.25)
        return (
            RELIEF * spread * min(1.0, distance_to_veins(p, blade.veins) / RELIEF_REACH)
            if detail.vein_spacing
            else 0.0
        )

    flat = [(x, z, lift((x, z))) for x, z in points]
    stem, stem_faces = petiole(blade, detail)
    size = 1.0 / (1.0 + blade.petiole_length)
    # (x, z) as a right-handed plane has its normal towards -y; the upper side shall look towards +y.
    faces = [tuple(reversed(t)) for t in triangles]
    faces += [tuple(i + len(flat) for i in face) for face in stem_faces]
    # What has no petiole would float beside its twig: half of the gap is taken out.
    reach = blade.petiole_length * (1.0 if stem else 0.5)
    origin = bend(0.0, -reach, 0.0, pose) if hangs else (0.0, 0.0, 0.0)
    corners = flat + stem
    positions = [tuple(size * (c - o) for c, o in zip(bend(x, z, y, pose), origin)) for x, z, y in corners]
    return Mesh(positions, [texture_position(blade, x, z) for x, z, _ in corners], faces)
