"""Hair as ribbons that face the camera, and points as spheres: surfaces for what Cycles has
shapes of its own for.

In go strands (points with radii), out come geometries. Invariant: a ribbon is as wide as its strand
everywhere, and stays where the strand is; its flat side is towards `eye`, a place in the strand's own space.
Its texture coordinates are those of its root.
"""

from dataclasses import dataclass, field

import numpy

from .geometry import Geometry

# Cycles' own where curves have no radius.
DEFAULT_RADIUS = 0.005
# Where curves say at which texture coordinates of a surface they stand.
OF_SURFACE = "surface_uv_coordinate"
# Straight pieces from point to point of a curve, which Cycles takes for a Catmull-Rom spline.
PIECES = 4


@dataclass
class Strand:
    """One hair; `uvs` are texture coordinates of its root, by name."""

    points: numpy.ndarray
    radii: numpy.ndarray
    uvs: dict = field(default_factory=dict)


def of_curves(curves, eye):
    """Of hair curves; None without any."""
    count = len(curves.points)
    if count == 0:
        return None
    points = numpy.empty((count, 3), "f4")
    curves.position_data.foreach_get("vector", points.ravel())
    radii = numpy.full(count, DEFAULT_RADIUS, "f4")
    if "radius" in curves.attributes:
        curves.attributes["radius"].data.foreach_get("value", radii)
    starts = [curve.first_point_index for curve in curves.curves] + [count]
    roots = root_uvs(curves)
    strands = [
        Strand(*smooth(points[a:b], radii[a:b]), {name: uv[number] for name, uv in roots.items()})
        for number, (a, b) in enumerate(zip(starts, starts[1:])) if b - a > 1
    ]
    return ribbons(curves.name, strands, eye)


def root_uvs(curves):
    """Texture coordinates of each curve, by name."""
    attribute = curves.attributes.get(OF_SURFACE)
    if attribute is None or attribute.domain != "CURVE" or attribute.data_type != "FLOAT2":
        return {}
    found = numpy.empty((len(curves.curves), 2), "f4")
    attribute.data.foreach_get("vector", found.ravel())
    return {OF_SURFACE: found}


def smooth(points, radii):
    """A Catmull-Rom spline through points, in straight pieces."""
    if len(points) < 3:
        return points, radii
    rows = numpy.concatenate([points, radii[:, None]], axis=1).astype(float)
    padded = numpy.concatenate([2 * rows[:1] - rows[1:2], rows, 2 * rows[-1:] - rows[-2:-1]])
    a, b, c, d = padded[:-3], padded[1:-2], padded[2:-1], padded[3:]
    share = (numpy.arange(PIECES) / PIECES)[:, None, None]
    found = b + 0.5 * share * (c - a + share * (2 * a - 5 * b + 4 * c - d + share * (3 * (b - c) + d - a)))
    found = numpy.concatenate([found.swapaxes(0, 1).reshape(-1, 4), rows[-1:]])
    return found[:, :3], numpy.maximum(found[:, 3], 0.0)


def of_particles(thing, system, eye):
    """Of a particle system's hair, in the object's space; None without any."""
    settings, modifier = (
        system.settings,
        next(one for one in thing.modifiers if getattr(one, "particle_system", None) == system),
    )
    layers = sorted(enumerate(thing.data.uv_layers), key=lambda layer: not layer[1].active_render)
    steps = 1 << settings.render_step
    parents, children = len(system.particles), len(system.child_particles)
    shown = range(0 if children == 0 or settings.use_parent_particles else parents, parents + children)
    local = numpy.array(thing.matrix_world.inverted_safe(), float)
    radii = tapered(settings, steps + 1)
    strands = []
    for number in shown:
        points = numpy.array(
            [system.co_hair(thing, particle_no=number, step=step) for step in range(steps + 1)], float
        )
        kept = numpy.linalg.norm(numpy.diff(points, axis=0), axis=1) > 1e-9
        if kept.any():
            kept = numpy.concatenate([[True], kept])
            # Of children Blender looks at the number alone.
            parent = system.particles[min(number, parents - 1)]
            uvs = {
                layer.name: system.uv_on_emitter(modifier, particle=parent, particle_no=number, uv_no=at)
                for at, layer in layers
            }
            strands.append(Strand((points @ local[:3, :3].T + local[:3, 3])[kept], radii[kept], uvs))
    return ribbons(system.name, strands, eye)


def tapered(settings, count):
    """Radii from root to tip, as Cycles has them."""
    left = 1.0 - numpy.linspace(0.0, 1.0, count)
    shape = settings.shape
    left = left ** (1.0 + shape) if shape < 0.0 else left ** (1.0 / max(1e-6, 1.0 - shape))
    root, tip = (
        0.5 * settings.radius_scale * radius for radius in (settings.root_radius, settings.tip_radius)
    )
    radii = left * (root - tip) + tip
    if settings.use_close_tip:
        radii[-1] = 0.0
    return radii


def ribbons(name, strands, eye):
    """One geometry of all strands."""
    if not strands:
        return None
    vertices, triangles, first = [], [], 0
    for strand in strands:
        points = numpy.asarray(strand.points, float)
        along = numpy.gradient(points, axis=0)
        aside = numpy.cross(along, eye - points)
        lengths = numpy.linalg.norm(aside, axis=1, keepdims=True)
        aside = (
            numpy.where(lengths > 1e-12, aside / numpy.maximum(lengths, 1e-12), [1.0, 0.0, 0.0])
            * strand.radii[:, None]
        )
        vertices.append(numpy.stack([points - aside, points + aside], axis=1).reshape(-1, 3))
        at = first + 2 * numpy.arange(len(points) - 1)[:, None]
        triangles.append(numpy.concatenate([at + [0, 1, 3], at + [0, 3, 2]], axis=0))
        first += 2 * len(points)
    corners = [6 * (len(strand.points) - 1) for strand in strands]
    uvs = {
        layer: numpy.repeat(numpy.array([strand.uvs[layer] for strand in strands], "f4"), corners, axis=0)
        for layer in strands[0].uvs
    }
    return made(name, numpy.concatenate(vertices), numpy.concatenate(triangles), uvs)


def of_points(cloud):
    """An icosahedron for each point, that shows as much as its sphere; None without any."""
    count = len(cloud.points)
    if count == 0:
        return None
    points, radii = numpy.empty((count, 3), "f4"), numpy.full(count, 0.05, "f4")
    cloud.attributes["position"].data.foreach_get("vector", points.ravel())
    if "radius" in cloud.attributes:
        cloud.attributes["radius"].data.foreach_get("value", radii)
    corners, faces = icosahedron()
    vertices = points[:, None, :] + corners * radii[:, None, None]
    return made(
        cloud.name,
        vertices.reshape(-1, 3),
        (faces + len(corners) * numpy.arange(count)[:, None, None]).reshape(-1, 3),
    )


def icosahedron():
    """Corners so far out that the mean of its shadows, a quarter of its surface, is that of a
    sphere of radius 1."""
    golden = 0.5 * (1.0 + 5.0**0.5)
    corners = numpy.array([(0, a, b * golden) for a in (-1, 1) for b in (-1, 1)], float)
    corners = numpy.concatenate([corners, corners[:, [2, 0, 1]], corners[:, [1, 2, 0]]])
    apart = numpy.linalg.norm(corners[:, None] - corners[None], axis=2)
    near = numpy.abs(apart - 2.0) < 1e-6
    faces = [
        (a, b, c)
        for a in range(12)
        for b in range(a + 1, 12)
        for c in range(b + 1, 12)
        if near[a, b] and near[b, c] and near[a, c]
    ]
    outwards = [(a, b, c) if numpy.linalg.det(corners[[a, b, c]]) > 0 else (a, c, b) for a, b, c in faces]
    surface = 20.0 * 3.0**0.5 / 4.0 * 2.0**2
    return corners * (4.0 * numpy.pi / surface) ** 0.5, numpy.array(outwards)


def made(name, vertices, triangles, uvs=None):
    corners = triangles.ravel()
    return Geometry(
        name=name, positions=numpy.asarray(vertices, "f4"), corner_vertices=corners.astype("i4"),
        triangles=numpy.arange(len(corners), dtype="i4").reshape(-1, 3), slots=numpy.zeros(len(triangles), "i4"), normals_of="FACE",
        normals=numpy.empty((0, 3), "f4"), uvs=uvs or {},
    ).fingerprint()
