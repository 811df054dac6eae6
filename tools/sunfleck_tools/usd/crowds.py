"""Many places of few meshes as one PointInstancer. Invariant: instances are those nodes' places, in the nodes' order.

Places are those of `orientationsf`; `orientations`, in halves, are there for programs that know no others (Blender 5.0), and are
off by up to 5e-4.
"""

from __future__ import annotations

import numpy as np
from pxr import Sdf, Vt

from ..gltf.nodes import Node
from .prims import Names, Prim, Types, vectors
from .samples import Sampler, thinned


def crowds(nodes: list[Node], is_plain: set[int]) -> dict[int, list[Node]]:
    """Nodes that become instances, by their parent's index (-1: none): those that place a mesh that others place too."""
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


def write_crowd(prim: Prim, nodes: list[Node], prototypes: list[Sdf.Path], sampler: Sampler, names: Names) -> None:
    """An instancer of nodes with one parent; `prototypes` has one for each of them."""
    paths = list(dict.fromkeys(prototypes))
    targets = []
    for path in paths:
        # Below the instancer, where nobody draws them but it.
        copy = prim.child(names.new(path.name), "Xform")
        copy.refer_to(path)
        targets.append(copy.path)
    prim.relate("prototypes", *targets)
    number = {path: index for index, path in enumerate(paths)}
    prim.set("protoIndices", Types.IntArray, Vt.IntArray([number[path] for path in prototypes]))
    ids = [node.extras.member("leaf_id") for node in nodes]
    if all(each is not None for each in ids) and len({each.raw for each in ids}) == len(ids):
        prim.set("ids", Types.Int64Array, Vt.Int64Array([each.whole() for each in ids]))
    prim.set("userProperties:sunfleck_names", Types.StringArray, Vt.StringArray([node.key for node in nodes]), custom=True)
    _write_parts(prim, nodes, sampler)


def _write_parts(prim: Prim, nodes: list[Node], sampler: Sampler) -> None:
    def rows(path: str) -> tuple[np.ndarray, np.ndarray]:
        # At whole frames alone: the keys of all would be too many codes for each.
        codes = sampler.frames if any(path in node.curves for node in nodes) else sampler.frames[:1]
        times = sampler.seconds(codes)
        # time, instance
        return thinned(codes, np.stack([node.parts_at(path, times) for node in nodes], axis=1))

    codes, places = rows("translation")
    prim.animate("positions", Types.Point3fArray, codes, [vectors(Vt.Vec3fArray, each) for each in places])
    codes, scales = rows("scale")
    prim.animate("scales", Types.Float3Array, codes, [vectors(Vt.Vec3fArray, each) for each in scales])
    codes, turns = rows("rotation")
    exact = [Vt.QuatfArray.FromNumpy(np.ascontiguousarray(each, np.float32)) for each in turns]
    prim.animate("orientationsf", Types.QuatfArray, codes, exact)
    halves = [Vt.QuathArray.FromNumpy(np.ascontiguousarray(each, np.float16)) for each in turns]
    prim.animate("orientations", Types.QuathArray, codes, halves)
