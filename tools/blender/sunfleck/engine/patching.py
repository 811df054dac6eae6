"""Updates of an exported document: lights, fog, and placements.

In go a graph and its earlier export, whose document is changed in place. Invariant: the result equals a
new export. Where that is not certain, nothing is changed.
"""

import copy
from types import SimpleNamespace

import bpy
import numpy

from .. import check, extras, film
from ..evaluated import lights, places, scenes
from ..evaluated.assemble import turned
from ..evaluated.attributes import numbers
from ..evaluated.moments import Clock
from ..evaluated.record import holds_fog
from ..materials import dependence

REST = {"translation": [0.0, 0.0, 0.0], "rotation": [0.0, 0.0, 0.0, 1.0], "scale": [1.0, 1.0, 1.0]}
# Types whose number of keys does not matter.
OF_OTHERS = (bpy.types.Camera, bpy.types.Action)


def put(graph, kept):
    """Applies all changes; returns False, without a change, if that is not possible."""
    record, assembly = kept.exported.record, kept.exported.assembly
    changed = changed_objects(graph, record)
    if changed is None or not is_the_same(graph, record, changed):
        return False
    if record.changes and (graph.scene.frame_current != kept.frame or any(one.type != "LIGHT" for one in changed)):
        return False
    if graph.scene.frame_current != kept.frame and any(map(dependence.is_of_film, bpy.data.materials)):
        return False
    matrices = matrices_of(graph)
    if matrices.shape != record.all_matrices.shape:
        return False
    nodes, apart = assembly.nodes, (matrices != record.all_matrices).any(axis=(1, 2))
    moved = [(key, thing) for key, thing in record.things.items() if key in nodes and apart[thing.rows[0]]]
    if not all(has_place(thing, matrices[thing.rows[0]]) for _, thing in moved):
        return False
    told = [(key, thing) for key, thing in record.things.items() if key in nodes and is_told(thing, changed)]
    if any(is_of_its_size(thing) for _, thing in (*moved, *told)):
        return False
    there = places.each(turned(matrices[[thing.rows[0] for _, thing in moved]].astype(float), [one for _, one in moved]))
    if any(key in assembly.sheared or one.inner is not None for (key, _), one in zip(moved, there)):
        return False
    record.all_matrices = matrices
    for (key, _), place in zip(moved, there):
        move(assembly.document.lists["nodes"][nodes[key]], place)
    for key, thing in told:
        tell(graph, assembly, key, thing, kept.path)
    put_frame(graph, kept)
    kept.findings = findings(graph.scene, kept.findings, changed)
    return True


def changed_objects(graph, record):
    """Objects that may have moved, and lights that may have changed; None if anything else has."""
    of_light = {light.node_tree: light for light in bpy.data.lights if light.node_tree}
    objects, data = set(), set()
    for update in graph.updates:
        one = update.id.original
        if isinstance(one, bpy.types.Object):
            if update.is_updated_geometry and one.type not in {"LIGHT", "CAMERA"}:
                return None
            objects.add(one)
        elif isinstance(one, bpy.types.Light):
            data.add(one)
        elif one in of_light:
            data.add(of_light[one])
        elif not isinstance(one, OF_OTHERS):
            return None
    return objects | {thing.object for thing in record.things.values() if thing.object.data in data}


def is_the_same(graph, record, changed):
    """Whether objects and their ray visibility are unchanged, and nothing depends on placements."""
    if len(record.moments) > 1 or record.capture.eyes or any(thing.kind == "VOLUME" for thing in record.things.values()):
        return False
    kinds = {thing.object: thing.kind for thing in record.things.values()}
    hides = "hide_render" if graph.mode == "RENDER" else "hide_viewport"
    now = {one: one.evaluated_get(graph) for one in changed}
    return all(getattr(one, hides) == (original not in kinds) for original, one in now.items()) and all(
        original not in kinds or holds_fog(one) == (kinds[original] == "FOG") for original, one in now.items()
    )


def matrices_of(graph):
    seen = graph.object_instances
    return numbers(seen, "matrix_world", (len(seen), 4, 4), "f4").swapaxes(1, 2)


def has_place(thing, matrix):
    """Whether a new export would have it there, as `Record.visit` decides."""
    return bool(numpy.isfinite(matrix).all()) and (thing.kind != "FOG" or bool(matrix[:3, :3].any()))


def move(node, place):
    for part, rest in REST.items():
        value = getattr(place, part)[0].tolist()
        node.pop(part, None)
        if value != rest:
            node[part] = value


def is_told(thing, changed):
    """Whether an object has parameters besides its placement."""
    return thing.object in changed and thing.kind in {"LIGHT", "EMPTY", "FOG"}


def is_of_its_size(thing):
    """Whether it is an instance of an area light with the power of its area, which its instancer scales."""
    return thing.kind == "LIGHT" and thing.instancer is not None and thing.object.data.type == "AREA" and not thing.object.data.normalize


def tell(graph, assembly, key, thing, path):
    """Updates the parameters of a light or fog."""
    node, evaluated = assembly.document.lists["nodes"][assembly.nodes[key]], thing.object.evaluated_get(graph)
    written = scenes.properties(thing, graph.scene, path, extras.of_object(evaluated, graph.scene))
    node.pop("extras", None)
    if written:
        node["extras"] = written
    if thing.kind == "LIGHT":
        node.pop("extensions", None)
        assembly.shine(node, thing, SimpleNamespace(punctual=lights.punctual(evaluated.data, film.exposure(graph.scene))))


def put_frame(graph, kept):
    """Updates the current frame in the scene's custom properties."""
    assembly, frame, said = kept.exported.assembly, graph.scene.frame_current, copy.deepcopy(kept.said)
    camera = assembly.document.scene_extras.get("sunfleck", {}).get("camera")
    assembly.clock = Clock.of(graph.scene, [frame])
    assembly.document.scene_extras = said
    scenes.settle_frames(assembly, frame)
    if camera is not None:
        said["sunfleck"]["camera"] = camera
    kept.frame = frame


def findings(scene, before, changed):
    """Findings of lights that have changed."""
    names = {f"`{one.name}`" for one in changed if one.type == "LIGHT"}
    found = [one for light in changed if light.type == "LIGHT" for one in check.of_object(light, scene)]
    return [one for one in before if one.of not in names] + found
