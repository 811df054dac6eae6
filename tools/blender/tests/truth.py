"""What Blender's dependency graph holds at every frame, for tests to compare files with: independent of
how files are made."""

import math

import bpy
import numpy

# glTF's axes from Blender's.
TURN = numpy.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]], float)


def of(scene, frames, subframe=0.0):
    """By frame: the triangles, (triangles, 3, 3) in glTF's axes, of every instance that has any. The viewport
    shows what renders."""
    found = {}
    for frame in frames:
        scene.frame_set(frame, subframe=subframe)
        graph = bpy.context.evaluated_depsgraph_get()
        found[frame] = [
            corners for instance in graph.object_instances if (corners := triangles(instance)) is not None
        ]
    return found


def at(scene, moment):
    """The same at one moment, after the frame before it: simulations go on from there."""
    whole = math.floor(moment)
    scene.frame_set(whole)
    return of(scene, [whole], subframe=moment - whole)[whole]


def triangles(instance):
    """Curves, texts and metaballs are there a second time as meshes; what is a child of faces or vertices
    renders there alone."""
    thing, parent = instance.object, instance.object.parent
    is_pattern = (
        not instance.is_instance and parent is not None and parent.instance_type in {"FACES", "VERTS"}
    )
    if thing.type != "MESH" or not instance.show_self or is_pattern or not thing.data.polygons:
        return None
    mesh = thing.data
    mesh.calc_loop_triangles()
    vertices, count = mesh.vertices, len(mesh.loop_triangles)
    places, corners = numpy.empty(len(vertices) * 3, "f4"), numpy.empty(count * 3, "i4")
    vertices.foreach_get("co", places)
    mesh.loop_triangles.foreach_get("vertices", corners)
    matrix = numpy.array(instance.matrix_world, float)
    world = places.reshape(-1, 3).astype(float) @ matrix[:3, :3].T + matrix[:3, 3]
    return (world @ TURN.T)[corners].reshape(count, 3, 3)


def of_file(file, frames):
    """The same of a file."""
    seconds = file.seconds(frames)
    worlds, visible = file.worlds(seconds), file.visible(seconds)
    found = {frame: [] for frame in frames}
    for index, node in enumerate(file.nodes):
        if "mesh" not in node:
            continue
        weights = file.weights(index, seconds)
        still = file.triangles(node["mesh"], weights[0])
        for at, frame in enumerate(frames):
            if not visible[index][at]:
                continue
            bent = (
                still
                if numpy.array_equal(weights[at], weights[0])
                else file.triangles(node["mesh"], weights[at])
            )
            matrix = worlds[index][at]
            found[frame].append(bent @ matrix[:3, :3].T + matrix[:3, 3])
    return found


def farthest(found, expected):
    """The largest distance between corners of the same number of instances, each compared with
    the nearest like it."""
    assert len(found) == len(expected), f"{len(found)} instances, not {len(expected)}"
    worst, left = 0.0, list(range(len(found)))
    middles = numpy.array([corners.mean(axis=(0, 1)) for corners in found]).reshape(-1, 3)
    for corners in expected:
        order = numpy.argsort(((middles[left] - corners.mean(axis=(0, 1))) ** 2).sum(axis=1))
        candidates = [left[index] for index in order[:8] if found[left[index]].shape == corners.shape]
        assert candidates, f"nothing of {len(corners)} triangles is near"
        off, best = min((apart(found[index], corners), index) for index in candidates)
        worst = max(worst, off)
        left.remove(best)
    return worst


def apart(found, expected):
    """Of two sets of triangles, in whatever order."""
    straight = float(numpy.abs(found - expected).max())
    if straight < 1e-3:
        return straight
    key = lambda corners: numpy.lexsort(numpy.round(corners.mean(axis=1), 4).T)
    return float(numpy.abs(found[key(found)] - expected[key(expected)]).max())
