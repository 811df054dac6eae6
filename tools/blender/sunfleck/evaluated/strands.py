"""Surfaces for Cycles' own primitives: hair as tubes, or with transmission as ribbons, and points as spheres.

In go strands (points with radii), out come geometries. Invariant: the mean projected width of a tube is
that of its strand, and normals are round, as on Cycles' ribbons. A ribbon faces `eye`, a point in the
strand's own space. Texture coordinates are those of the root.
"""

from dataclasses import dataclass, field
from itertools import combinations

import numpy

from .attributes import MISSING, numbers, values_of
from .geometry import Geometry

# Cycles' default for curves without a radius.
DEFAULT_RADIUS = 0.005
# Attribute of curves with the texture coordinates of their roots on a surface.
OF_SURFACE = "surface_uv_coordinate"
# Linear segments between two points of a curve, which Cycles treats as a Catmull-Rom spline.
PIECES = 4
# Sides of a tube by the number of points, and beyond. A row of tubes under light at 2 degrees has .973 with
# 24 sides, .996 with 48.
SIDES, FEWEST_SIDES = {20_000: 48, 40_000: 24}, 12
# Columns of a ribbon.
COLUMNS = 6


@dataclass
class Strand:
    """Hair; `uvs` are texture coordinates of its root, by name, and `values` attributes, a row a point."""

    points: numpy.ndarray
    radii: numpy.ndarray
    uvs: dict = field(default_factory=dict)
    values: dict = field(default_factory=dict)


def of_curves(curves, eye, names=(), is_flat=False):
    """Geometry of hair curves with these attributes; None without curves."""
    count = len(curves.points)
    if count == 0:
        return None
    points, radii = numbers(curves.position_data, "vector", (count, 3), "f4"), radii_of(curves, count, DEFAULT_RADIUS)
    starts = [curve.first_point_index for curve in curves.curves] + [count]
    roots = root_uvs(curves)
    columns = {name: values_of_curves(curves, name) for name in names}
    strands = []
    for number, (a, b) in enumerate(zip(starts, starts[1:])):
        if b - a < 2:
            continue
        rows = [column[a:b] for column in columns.values()]
        along, radii_along, *values = smooth(points[a:b], radii[a:b], rows)
        uvs = {name: uv[number] for name, uv in roots.items()}
        strands.append(Strand(along, radii_along, uvs, dict(zip(columns, values))))
    return surface_of(curves.name, strands, eye, is_flat)


def values_of_curves(curves, name):
    """Values of an attribute, a row a point; missing ones are black, as in Cycles."""
    attribute = curves.attributes.get(name)
    values = values_of(attribute)
    if values is None:
        return numpy.tile(numpy.array(MISSING, "f4"), (len(curves.points), 1))
    if attribute.domain == "CURVE":
        return numpy.repeat(values, [curve.points_length for curve in curves.curves], axis=0)
    return values


def root_uvs(curves):
    """Texture coordinates of each curve's root, by name."""
    attribute = curves.attributes.get(OF_SURFACE)
    if attribute is None or attribute.domain != "CURVE" or attribute.data_type != "FLOAT2":
        return {}
    return {OF_SURFACE: numbers(attribute.data, "vector", (len(curves.curves), 2), "f4")}


def radii_of(owner, count, default):
    radius = owner.attributes.get("radius")
    return numbers(radius.data, "value", count, "f4") if radius else numpy.full(count, default, "f4")


def smooth(points, radii, values=()):
    """Catmull-Rom spline in linear segments; `values` are interpolated linearly."""
    if len(points) < 3:
        return points, radii, *values
    rows = numpy.concatenate([points, radii[:, None]], axis=1).astype(float)
    padded = numpy.concatenate([2 * rows[:1] - rows[1:2], rows, 2 * rows[-1:] - rows[-2:-1]])
    a, b, c, d = padded[:-3], padded[1:-2], padded[2:-1], padded[3:]
    share = (numpy.arange(PIECES) / PIECES)[:, None, None]
    found = b + 0.5 * share * (c - a + share * (2 * a - 5 * b + 4 * c - d + share * (3 * (b - c) + d - a)))
    found = numpy.concatenate([found.swapaxes(0, 1).reshape(-1, 4), rows[-1:]])
    return found[:, :3], numpy.maximum(found[:, 3], 0.0), *(straight(one, share) for one in values)


def straight(rows, share):
    between = (rows[:-1] + share * (rows[1:] - rows[:-1])).swapaxes(0, 1).reshape(-1, rows.shape[1])
    return numpy.concatenate([between, rows[-1:]])


def of_particles(thing, system, eye, is_flat=False):
    """Geometry of a particle system's hair, in the object's space; None without hair."""
    settings = system.settings
    modifier = next(one for one in thing.modifiers if getattr(one, "particle_system", None) == system)
    layers = sorted(enumerate(thing.data.uv_layers), key=lambda layer: not layer[1].active_render)
    steps = 1 << settings.render_step
    parents, children = len(system.particles), len(system.child_particles)
    shown = range(0 if children == 0 or settings.use_parent_particles else parents, parents + children)
    local = numpy.array(thing.matrix_world.inverted_safe(), float)
    strands = []
    for number in shown:
        points = numpy.array([system.co_hair(thing, particle_no=number, step=step) for step in range(steps + 1)], float)
        # Short children have fewer steps; Blender gives zeros for the rest.
        points = points[: 1 + int(numpy.flatnonzero(points.any(axis=1)).max(initial=0))]
        lengths = numpy.linalg.norm(numpy.diff(points, axis=0), axis=1)
        kept = numpy.concatenate([[True], lengths > 1e-9])
        if kept[1:].any():
            share = numpy.concatenate([[0.0], numpy.cumsum(lengths) / lengths.sum()])
            radii = tapered(settings, share)
            # For children Blender only uses the index.
            parent = system.particles[min(number, parents - 1)]
            uvs = {
                layer.name: system.uv_on_emitter(modifier, particle=parent, particle_no=number, uv_no=at)
                for at, layer in layers
            }
            strands.append(Strand((points @ local[:3, :3].T + local[:3, 3])[kept], radii[kept], uvs))
    return surface_of(system.name, strands, eye, is_flat)


def tapered(settings, share):
    """Radii at fractions of a hair's length, as in Cycles."""
    left = 1.0 - share
    shape = settings.shape
    left = left ** (1.0 + shape) if shape < 0.0 else left ** (1.0 / max(1e-6, 1.0 - shape))
    root, tip = (0.5 * settings.radius_scale * radius for radius in (settings.root_radius, settings.tip_radius))
    radii = left * (root - tip) + tip
    if settings.use_close_tip:
        radii[-1] = 0.0
    return radii


def surface_of(name, strands, eye, is_flat):
    """One geometry of all strands, as tubes or ribbons."""
    if not strands:
        return None
    counts = [len(strand.points) for strand in strands]
    sides = next((sides for most, sides in SIDES.items() if sum(counts) <= most), FEWEST_SIDES)
    around = COLUMNS + 1 if is_flat else sides
    vertices, normals, triangles, first = [], [], [], 0
    for strand in strands:
        places, outwards = ribbon(strand, eye) if is_flat else tube(strand, eye, sides)
        vertices.append(places.reshape(-1, 3))
        normals.append(outwards.reshape(-1, 3))
        triangles.append(first + walls(len(strand.points), around, is_closed=not is_flat))
        first += around * len(strand.points)
    triangles = numpy.concatenate(triangles)
    corners = triangles.ravel()
    strand_of = numpy.repeat(numpy.repeat(numpy.arange(len(strands)), counts), around)[corners]
    uvs = {
        layer: numpy.array([strand.uvs[layer] for strand in strands], "f4")[strand_of] for layer in strands[0].uvs
    }
    colors = {
        layer: numpy.concatenate([strand.values[layer] for strand in strands]).repeat(around, axis=0)[corners]
        for layer in strands[0].values
    }
    return made(name, numpy.concatenate(vertices), triangles, numpy.concatenate(normals), uvs=uvs, colors=colors)


def frames(strand, eye):
    """At each point a direction across the strand to the eye's left, and one towards the eye."""
    points = numpy.asarray(strand.points, float)
    along = numpy.gradient(points, axis=0)
    aside = numpy.cross(along, eye - points)
    lengths = numpy.linalg.norm(aside, axis=1, keepdims=True)
    aside = numpy.where(lengths > 1e-12, aside / numpy.maximum(lengths, 1e-12), [1.0, 0.0, 0.0])
    towards = numpy.cross(aside, along)
    return points, aside, towards / numpy.maximum(numpy.linalg.norm(towards, axis=1, keepdims=True), 1e-12)


def tube(strand, eye, sides):
    """Positions and normals (points, sides, 3); the prism has the circumference of its strand."""
    points, aside, towards = frames(strand, eye)
    angles = 2.0 * numpy.pi * numpy.arange(sides) / sides
    cosine, sine = (turn(angles)[None, :, None] for turn in (numpy.cos, numpy.sin))
    outwards = cosine * aside[:, None] + sine * towards[:, None]
    radius = numpy.pi / (sides * numpy.sin(numpy.pi / sides)) * numpy.asarray(strand.radii, float)
    return points[:, None] + radius[:, None, None] * outwards, outwards


def ribbon(strand, eye):
    """Flat ribbon with the normals of a tube."""
    points, aside, towards = frames(strand, eye)
    across = numpy.linspace(-1.0, 1.0, COLUMNS + 1)[None, :, None]
    # Just inside the edge, where a normal would lie in the ribbon.
    lean = 0.98 * across
    outwards = lean * aside[:, None] + numpy.sqrt(1.0 - lean**2) * towards[:, None]
    return points[:, None] + across * numpy.asarray(strand.radii, float)[:, None, None] * aside[:, None], outwards


def walls(rings, around, is_closed):
    """Triangles between consecutive rings."""
    sides = numpy.arange(around if is_closed else around - 1)
    ring, side = numpy.meshgrid(numpy.arange(rings - 1), sides, indexing="ij")
    a, b = ring * around + side, ring * around + (side + 1) % around
    quads = numpy.stack([a, b + around, b, a, a + around, b + around], axis=-1)
    return quads.reshape(-1, 3)


def of_points(cloud, names=()):
    """Icosahedron for each point with the sphere's mean projected area, and attributes; None without
    points."""
    count = len(cloud.points)
    if count == 0:
        return None
    points, radii = numbers(cloud.attributes["position"].data, "vector", (count, 3), "f4"), radii_of(cloud, count, 0.05)
    corners, faces = icosahedron()
    vertices = points[:, None, :] + corners * radii[:, None, None]
    missing = numpy.tile(numpy.array(MISSING, "f4"), (count, 1))
    values = {name: values_of(cloud.attributes.get(name)) for name in names}
    return made(
        cloud.name,
        vertices.reshape(-1, 3),
        (faces + len(corners) * numpy.arange(count)[:, None, None]).reshape(-1, 3),
        colors={
            name: (missing if found is None else found).repeat(faces.size, axis=0) for name, found in values.items()
        },
    )


def icosahedron():
    """Corners of an icosahedron whose mean projected area, a quarter of its surface, is that of the unit
    sphere."""
    golden = 0.5 * (1.0 + 5.0**0.5)
    corners = numpy.array([(0, a, b * golden) for a in (-1, 1) for b in (-1, 1)], float)
    corners = numpy.concatenate([corners, corners[:, [2, 0, 1]], corners[:, [1, 2, 0]]])
    apart = numpy.linalg.norm(corners[:, None] - corners[None], axis=2)
    near = numpy.abs(apart - 2.0) < 1e-6
    faces = [face for face in combinations(range(12), 3) if all(near[pair] for pair in combinations(face, 2))]
    outwards = [(a, b, c) if numpy.linalg.det(corners[[a, b, c]]) > 0 else (a, c, b) for a, b, c in faces]
    surface = 20.0 * 3.0**0.5 / 4.0 * 2.0**2
    return corners * (4.0 * numpy.pi / surface) ** 0.5, numpy.array(outwards)


def made(name, vertices, triangles, normals=None, **of_corners):
    """Geometry; normals are by vertex, or without any by face. Other values are by corner."""
    corners = triangles.ravel()
    is_smooth = normals is not None
    return Geometry(
        name=name, positions=numpy.asarray(vertices, "f4"), corner_vertices=corners.astype("i4"),
        triangles=numpy.arange(len(corners), dtype="i4").reshape(-1, 3), slots=numpy.zeros(len(triangles), "i4"),
        normals_of="POINT" if is_smooth else "FACE",
        normals=numpy.asarray(normals, "f4") if is_smooth else numpy.empty((0, 3), "f4"),
        **of_corners,
    ).fingerprint()
