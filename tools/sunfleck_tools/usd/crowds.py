"""PointInstancers for nodes that share few meshes. Invariant: instances have the nodes' transforms, in the
nodes' order.

Rotations are in `orientationsf`; `orientations`, in halves, are for programs without support for these,
and have errors of up to 5e-4. Blender 5.0 is one of them: in a stage for it, prototypes are rotated in
place of instances.
"""

import numpy as np
from pxr import Sdf, Vt

from ..gltf.nodes import Node
from .places import write_turn_and_scale
from .prims import Names, Prim, Types, vectors
from .properties import say_leaf_id
from .samples import Sampler, thinned


ATTRIBUTES = {
    "translation": [("positions", Types.Point3fArray, lambda rows: vectors(Vt.Vec3fArray, rows))],
    "rotation": [
        ("orientationsf", Types.QuatfArray, lambda rows: Vt.QuatfArray.FromNumpy(np.ascontiguousarray(rows, np.float32))),
        ("orientations", Types.QuathArray, lambda rows: Vt.QuathArray.FromNumpy(np.ascontiguousarray(rows, np.float16))),
    ],
    "scale": [("scales", Types.Float3Array, lambda rows: vectors(Vt.Vec3fArray, rows))],
}


def crowds(nodes: list[Node], is_plain: set[int]) -> dict[int, list[Node]]:
    """Nodes that become instances, by their parent's index (-1: none): those whose mesh other nodes show
    too."""
    placed: dict[tuple[int, int], list[Node]] = {}
    for node in nodes:
        if node.index in is_plain and node.matrix is None:
            parent = -1 if node.parent is None else node.parent.index
            placed.setdefault((parent, int(node.source.raw["mesh"])), []).append(node)
    found: dict[int, list[Node]] = {}
    for (parent, _), same in placed.items():
        if len(same) > 1:
            found.setdefault(parent, []).extend(same)
    return {parent: sorted(each, key=lambda node: node.index) for parent, each in found.items()}


def write_crowd(
    prim: Prim, nodes: list[Node], shapes: list[Sdf.Path], sampler: Sampler, names: Names, for_blender: bool
) -> None:
    """Instancer of nodes with one parent; `shapes` has one for each of them."""
    if for_blender:
        numbers = _turned_prototypes(prim, nodes, shapes, sampler, names)
        _write_parts(prim, nodes, sampler, ["translation"])
    else:
        numbers = _shared_prototypes(prim, shapes, names)
        _say_names(prim, nodes)
        _write_parts(prim, nodes, sampler, ["translation", "scale", "rotation"])
    prim.set("protoIndices", Types.IntArray, Vt.IntArray(numbers))


def _shared_prototypes(prim: Prim, shapes: list[Sdf.Path], names: Names) -> list[int]:
    """Writes a prototype for each mesh, below the instancer, where only it draws them; returns the
    prototype of each instance."""
    paths = list(dict.fromkeys(shapes))
    targets = []
    for path in paths:
        copy = prim.child(names.new(path.name), "Xform")
        copy.refer_to(path)
        targets.append(copy.path)
    prim.relate("prototypes", *targets)
    number = {path: index for index, path in enumerate(paths)}
    return [number[path] for path in shapes]


def _turned_prototypes(
    prim: Prim, nodes: list[Node], shapes: list[Sdf.Path], sampler: Sampler, names: Names
) -> list[int]:
    """Writes a prototype for each node, with its rotation and scale: an instance of the mesh."""
    targets = []
    for node, path in zip(nodes, shapes):
        turned = prim.child(names.new(node.name), "Xform")
        write_turn_and_scale(turned, node, sampler)
        turned.say_name(node.key)
        say_leaf_id(turned, node)
        turned.refer_to(path)
        turned.spec.instanceable = True
        targets.append(turned.path)
    prim.relate("prototypes", *targets)
    return list(range(len(nodes)))


def _say_names(prim: Prim, nodes: list[Node]) -> None:
    ids = [found for node in nodes if (found := node.extras.member("leaf_id")) is not None]
    if len({each.raw for each in ids}) == len(nodes):
        prim.set("ids", Types.Int64Array, Vt.Int64Array([each.whole() for each in ids]))
    names = Vt.StringArray([node.key for node in nodes])
    prim.set("userProperties:sunfleck_names", Types.StringArray, names, custom=True)


def _write_parts(prim: Prim, nodes: list[Node], sampler: Sampler, paths: list[str]) -> None:
    for path in paths:
        # Only at whole frames, as the union of all keys would be too large.
        codes = sampler.frames if any(path in node.curves for node in nodes) else sampler.frames[:1]
        times = sampler.seconds(codes)
        # time, instance
        codes, rows = thinned(codes, np.stack([node.parts_at(path, times) for node in nodes], axis=1))
        for name, kind, make in ATTRIBUTES[path]:
            prim.animate(name, kind, codes, [make(each) for each in rows])
