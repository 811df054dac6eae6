"""Plane triangulation: a simple polygon and interior points in, Delaunay-like triangles out.

Ears are clipped first; interior points then split the triangle they fall in, and edges are flipped
until no vertex lies in a neighbour's circumcircle (Lawson 1977). Invariant: every triangle is
counter-clockwise with positive area, and every edge of the polygon is an edge of the result.
"""

import math

Point = tuple[float, float]
Triangle = tuple[int, int, int]


def doubled_area(a: Point, b: Point, c: Point) -> float:
    """Positive if a, b, c turn counter-clockwise."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def contains(polygon: list[Point], point: Point) -> bool:
    """Even-odd test."""
    inside = False
    for (x0, y0), (x1, y1) in zip(polygon, polygon[1:] + polygon[:1]):
        if (y0 > point[1]) != (y1 > point[1]) and point[0] < x0 + (point[1] - y0) / (y1 - y0) * (x1 - x0):
            inside = not inside
    return inside


def distance_to_segment(p: Point, a: Point, b: Point) -> float:
    """Distance of `p` from the segment `a`-`b`."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    length_squared = dx * dx + dy * dy
    t = 0.0 if length_squared == 0 else ((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / length_squared
    t = min(1.0, max(0.0, t))
    return math.hypot(p[0] - a[0] - t * dx, p[1] - a[1] - t * dy)


def distance_to_outline(p: Point, polygon: list[Point]) -> float:
    """Distance of `p` from the nearest edge of the polygon."""
    return min(distance_to_segment(p, a, b) for a, b in zip(polygon, polygon[1:] + polygon[:1]))


def simplify(points: list[Point], tolerance: float) -> list[Point]:
    """Douglas-Peucker on an open polyline; its ends stay."""
    if len(points) < 3:
        return points
    distances = [distance_to_segment(p, points[0], points[-1]) for p in points[1:-1]]
    farthest = max(range(len(distances)), key=distances.__getitem__)
    if distances[farthest] <= tolerance:
        return [points[0], points[-1]]
    middle = farthest + 1
    return simplify(points[: middle + 1], tolerance)[:-1] + simplify(points[middle:], tolerance)


def clip_ears(polygon: list[Point]) -> list[Triangle]:
    """Triangles between the vertices of a simple counter-clockwise polygon, fattest ears first."""
    remaining = list(range(len(polygon)))
    triangles = []
    while len(remaining) > 3:
        best, best_quality = None, 0.0
        for i, current in enumerate(remaining):
            before, after = remaining[i - 1], remaining[(i + 1) % len(remaining)]
            a, b, c = polygon[before], polygon[current], polygon[after]
            area = doubled_area(a, b, c)
            quality = area / (math.dist(a, b) + math.dist(b, c) + math.dist(c, a)) ** 2
            if quality <= best_quality or any(
                doubled_area(a, b, polygon[k]) >= 0
                and doubled_area(b, c, polygon[k]) >= 0
                and doubled_area(c, a, polygon[k]) >= 0
                for k in remaining
                if k not in (before, current, after)
            ):
                continue
            best, best_quality = i, quality
        if best is None:
            raise ValueError("the outline is not a simple counter-clockwise polygon")
        triangles.append((remaining[best - 1], remaining[best], remaining[(best + 1) % len(remaining)]))
        del remaining[best]
    return [*triangles, (remaining[0], remaining[1], remaining[2])]


def in_circumcircle(a: Point, b: Point, c: Point, d: Point) -> bool:
    """True if `d` lies inside the circle through the counter-clockwise a, b, c."""
    rows = [(p[0] - d[0], p[1] - d[1]) for p in (a, b, c)]
    (ax, ay), (bx, by), (cx, cy) = rows
    determinant = (
        (ax * ax + ay * ay) * (bx * cy - by * cx)
        - (bx * bx + by * by) * (ax * cy - ay * cx)
        + (cx * cx + cy * cy) * (ax * by - ay * bx)
    )
    return determinant > 1e-12


def flip_to_delaunay(points: list[Point], triangles: list[Triangle]) -> list[Triangle]:
    """Flips inner edges until the triangulation is constrained Delaunay."""
    flipped = True
    while flipped:
        flipped = False
        opposite = {}
        for index, (a, b, c) in enumerate(triangles):
            opposite[a, b], opposite[b, c], opposite[c, a] = (index, c), (index, a), (index, b)
        touched = set()
        for (a, b), (index, c) in list(opposite.items()):
            if (b, a) not in opposite:
                continue
            other, d = opposite[b, a]
            if index in touched or other in touched:
                continue
            if not in_circumcircle(points[a], points[b], points[c], points[d]):
                continue
            if (
                min(
                    doubled_area(points[a], points[d], points[c]),
                    doubled_area(points[d], points[b], points[c]),
                )
                <= 1e-9
            ):
                continue
            triangles[index], triangles[other] = (a, d, c), (d, b, c)
            touched |= {index, other}
            flipped = True
    return triangles


def triangulate(polygon: list[Point], interior: list[Point]) -> tuple[list[Point], list[Triangle]]:
    """The polygon's vertices followed by the interior points, and triangles between them."""
    points = list(polygon)
    triangles = flip_to_delaunay(points, clip_ears(polygon))
    for p in interior:
        scored = [
            (min(doubled_area(points[i], points[j], p) for i, j in ((a, b), (b, c), (c, a))), index)
            for index, (a, b, c) in enumerate(triangles)
        ]
        depth, home = max(scored)
        if depth <= 1e-7:
            p = (p[0] + 3e-4, p[1] + 2e-4)  # Off the edge that it would fall on.
        a, b, c = triangles[home]
        new = len(points)
        points.append(p)
        triangles[home : home + 1] = [(a, b, new), (b, c, new), (c, a, new)]
        triangles = flip_to_delaunay(points, triangles)
    return points, triangles
