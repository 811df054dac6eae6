"""Faces that lie in one place: a ray of Cycles meets one of them by chance, and the other shades it.

In go a record, out come names of things with such faces at the first moment. Invariant: the work is bounded by
`MOST_TRIANGLES` and `MOST_PAIRS`; what is beyond is not looked at (`is_whole`, of triangles). What the faces of closed things hide from every
side, as the bottom of a box on the ground, is no such face.
"""

import numpy

from .heeding import heeding

MOST_TRIANGLES, MOST_PAIRS = 400_000, 500_000
# Of the largest coordinate: so near is one plane. And of the unit normal and that, by which planes are sorted.
NEAR, SORTED = 1e-6, 1e-4
# Odd numbers that make one of four.
HASHED = numpy.array([0x9E3779B1, 0x85EBCA77, 0xC2B2AE3D, 0x27D4EB2F])
# Of its extent a triangle must reach into another.
INTO = 1e-4


def names(record):
    placed = list(of_first_moment(record))
    made = [record.geometries[number] for _, number, _ in placed]
    return heeding(record.heed, sum(len(one.triangles) for one in made), lambda: found_in(placed, made))


def is_whole(record):
    """Whether all things are looked at."""
    return sum(len(record.geometries[number].triangles) for _, number, _ in there(record)) <= MOST_TRIANGLES


def of_first_moment(record):
    """What is there, as far as it is looked at."""
    count = 0
    for thing in there(record):
        count += len(record.geometries[thing[1]].triangles)
        if count > MOST_TRIANGLES:
            return
        yield thing


def there(record):
    """Name, number of a geometry and place of each thing at the first moment that was looked at."""
    for thing in record.things.values():
        # With an open shutter others are earlier.
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
        # A bent quad of a bevel is two triangles of which one may lie folded over the other.
        if is_opposed and abs(one - other) == 1 and (corners[one][:, None] == corners[other]).all(axis=2).sum() == 2:
            continue
        if not (is_opposed and any(not is_flat[at] and is_closed(placed[at][1], made[at], closed) for at in pair)):
            found |= {placed[at][0] for at in pair}
    return found


def is_closed(number, made, known):
    """Whether each edge of a geometry is of two faces."""
    if number not in known:
        vertices = made.corner_vertices[made.triangles]
        edges = numpy.sort(vertices[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        known[number] = bool((numpy.unique(edges, axis=0, return_counts=True)[1] == 2).all())
    return known[number]


def overlapping(corners):
    """Pairs of triangles in one plane of which one reaches into the other, and whether they look opposite ways."""
    normals = numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = numpy.linalg.norm(normals, axis=1)
    scale = max(float(numpy.abs(corners).max(initial=0.0)), 1e-30)
    # What is thinner than that is no face, as at the poles of a surface.
    longest = numpy.linalg.norm(numpy.roll(corners, -1, axis=1) - corners, axis=2).max(axis=1, initial=0.0)
    kept = numpy.flatnonzero(lengths > NEAR * scale * longest)
    corners, normals = corners[kept], normals[kept] / lengths[kept, None]
    # Of a plane both sides are one; along its longest axis one looks at it, of a slanted one along the same.
    axis = numpy.abs(numpy.rint(normals / SORTED)).argmax(axis=1)
    ways = numpy.sign(numpy.take_along_axis(normals, axis[:, None], 1))
    planes = numpy.column_stack([ways * normals, ways[:, 0] * numpy.einsum("ij,ij->i", normals, corners[:, 0]) / scale])
    planes = (numpy.rint(planes / SORTED).astype(int) * HASHED).sum(axis=1)
    flat = numpy.take_along_axis(corners, ((axis[:, None] + [1, 2]) % 3)[:, None, :], 2)
    low, high = flat.min(axis=1), flat.max(axis=1)
    # What is the same stands next to each other.
    order = numpy.lexsort((low[:, 1], numpy.rint(low[:, 0] / (NEAR * scale)), planes))
    for one, other in near_each_other(order, planes, low, high):
        apart = numpy.abs(numpy.einsum("ij,ikj->ik", normals[one], corners[other] - corners[one][:, :1])).max(axis=1)
        is_met = (apart < NEAR * scale) & reach_into(flat[one], flat[other]) & reach_into(flat[other], flat[one])
        opposed = ways[one[is_met], 0] != ways[other[is_met], 0]
        yield from zip(kept[one[is_met]], kept[other[is_met]], opposed)


def near_each_other(order, planes, low, high):
    """Pairs of the same plane whose bounds reach into each other: neighbours in order, then the next but one and on."""
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
    """Whether no edge of a flat triangle has all of another on its outer side (the separating axis theorem)."""
    edges = numpy.roll(flat, -1, axis=1) - flat
    cross = lambda a, b: a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    area = cross(edges[:, 0], edges[:, 1])
    within = cross(edges[:, :, None], others[:, None] - flat[:, :, None]) * numpy.sign(area)[:, None, None]
    return (within.max(axis=2) > INTO * numpy.abs(area)[:, None]).all(axis=1)
