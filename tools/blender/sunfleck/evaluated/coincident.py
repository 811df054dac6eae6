"""Coincident faces, of which a ray of Cycles hits one at random, while the other shades it.

In go a record, out come names of objects with such faces at the first moment. Invariant: the work is
bounded by `MOST_TRIANGLES` and `MOST_PAIRS`; triangles beyond are ignored (`is_whole`). Faces that closed
objects hide from every side, such as the bottom of a box on the ground, do not count.
"""

import numpy

from .heeding import heeding

MOST_TRIANGLES, MOST_PAIRS = 400_000, 500_000
# Tolerance of a plane, relative to the largest coordinate; and steps of its unit normal and offset for
# sorting.
NEAR, SORTED = 1e-6, 1e-4
# Odd multipliers that hash four integers into one.
HASHED = numpy.array([0x9E3779B1, 0x85EBCA77, 0xC2B2AE3D, 0x27D4EB2F])
# Minimum overlap of triangles, relative to their extent.
INTO = 1e-4


def names(record):
    placed = list(of_first_moment(record))
    made = [record.geometries[number] for _, number, _ in placed]
    return heeding(record.heed, sum(len(one.triangles) for one in made), lambda: found_in(placed, made))


def is_whole(record):
    """Whether all triangles are checked."""
    return sum(len(record.geometries[number].triangles) for _, number, _ in there(record)) <= MOST_TRIANGLES


def of_first_moment(record):
    """Names of objects with coincident faces, among those that are checked."""
    count = 0
    for thing in there(record):
        count += len(record.geometries[thing[1]].triangles)
        if count > MOST_TRIANGLES:
            return
        yield thing


def there(record):
    """Name, geometry and placement of each object at the first recorded moment."""
    for thing in record.things.values():
        # With an open shutter other moments come earlier.
        at = thing.moments.index(0) if thing.kind == "SURFACE" and 0 in thing.moments else None
        if at is not None and thing.shown[at] is not None:
            yield thing.object.name, thing.shown[at][0], record.all_matrices[thing.rows[at]].astype(float)


def found_in(placed, made):
    if not placed:
        return set()
    corners = [
        (one.positions @ matrix[:3, :3].T + matrix[:3, 3])[one.corner_vertices[one.triangles]]
        for one, (*_, matrix) in zip(made, placed)
    ]
    owners = numpy.repeat(numpy.arange(len(placed)), [len(one) for one in corners])
    closed, found, corners = {}, set(), numpy.concatenate(corners)
    # What has no inside hides nothing.
    is_flat = numpy.linalg.matrix_rank(numpy.array([matrix[:3, :3] for *_, matrix in placed])) < 3
    for one, other, is_opposed in overlapping(corners):
        pair = {owners[one], owners[other]}
        # A bent quad of a bevel has two triangles, one of which may be folded over the other.
        if is_opposed and abs(one - other) == 1 and (corners[one][:, None] == corners[other]).all(axis=2).sum() == 2:
            continue
        if not (is_opposed and any(not is_flat[at] and is_closed(placed[at][1], made[at], closed) for at in pair)):
            found |= {placed[at][0] for at in pair}
    return found


def is_closed(number, made, known):
    """Whether each edge of a geometry has two faces."""
    if number not in known:
        vertices = made.corner_vertices[made.triangles]
        edges = numpy.sort(vertices[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        known[number] = bool((numpy.unique(edges, axis=0, return_counts=True)[1] == 2).all())
    return known[number]


def overlapping(corners):
    """Pairs of overlapping triangles in one plane, and whether they face opposite ways."""
    normals = numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = numpy.linalg.norm(normals, axis=1)
    scale = max(float(numpy.abs(corners).max(initial=0.0)), 1e-30)
    # Thinner triangles are degenerate, as at the poles of a surface.
    longest = numpy.linalg.norm(numpy.roll(corners, -1, axis=1) - corners, axis=2).max(axis=1, initial=0.0)
    kept = numpy.flatnonzero(lengths > NEAR * scale * longest)
    corners, normals = corners[kept], normals[kept] / lengths[kept, None]
    # Opposite normals are one plane; its longest axis decides the direction.
    axis = numpy.abs(numpy.rint(normals / SORTED)).argmax(axis=1)
    ways = numpy.sign(numpy.take_along_axis(normals, axis[:, None], 1))
    planes = numpy.column_stack([ways * normals, ways[:, 0] * numpy.einsum("ij,ij->i", normals, corners[:, 0]) / scale])
    planes = (numpy.rint(planes / SORTED).astype(int) * HASHED).sum(axis=1)
    flat = numpy.take_along_axis(corners, ((axis[:, None] + [1, 2]) % 3)[:, None, :], 2)
    low, high = flat.min(axis=1), flat.max(axis=1)
    # Sorted, so that equal planes are adjacent.
    order = numpy.lexsort((low[:, 1], numpy.rint(low[:, 0] / (NEAR * scale)), planes))
    for one, other in near_each_other(order, planes, low, high):
        apart = numpy.abs(numpy.einsum("ij,ikj->ik", normals[one], corners[other] - corners[one][:, :1])).max(axis=1)
        is_met = (apart < NEAR * scale) & reach_into(flat[one], flat[other]) & reach_into(flat[other], flat[one])
        opposed = ways[one[is_met], 0] != ways[other[is_met], 0]
        yield from zip(kept[one[is_met]], kept[other[is_met]], opposed)


def near_each_other(order, planes, low, high):
    """Pairs in one plane with overlapping bounds: adjacent ones in the order, then those two apart and so
    on."""
    asked, still = 0, numpy.arange(len(order))
    for step in range(1, len(order)):
        still = still[still + step < len(order)]
        one, other = order[still], order[still + step]
        into = INTO * (high[one] - low[one])
        is_near = (planes[one] == planes[other]) & (low[other, 0] < high[one, 0] - into[:, 0])
        still, one, other, into = still[is_near], one[is_near], other[is_near], into[is_near]
        asked += len(still)
        if not len(still) or asked > MOST_PAIRS:
            return
        is_beside = (low[other, 1] < high[one, 1] - into[:, 1]) & (low[one, 1] < high[other, 1] - into[:, 1])
        yield one[is_beside], other[is_beside]


def reach_into(flat, others):
    """Whether flat triangles overlap (the separating axis theorem)."""
    edges = numpy.roll(flat, -1, axis=1) - flat
    cross = lambda a, b: a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    area = cross(edges[:, 0], edges[:, 1])
    within = cross(edges[:, :, None], others[:, None] - flat[:, :, None]) * numpy.sign(area)[:, None, None]
    return (within.max(axis=2) > INTO * numpy.abs(area)[:, None]).all(axis=1)
