"""Transforms and visibility of nodes, as transform operations."""

import numpy as np
from pxr import Gf, Vt

from ..gltf.nodes import RESTS, Node
from ..gltf.scene import Gltf
from .prims import Prim, Types, quaternions, vectors
from .samples import JUMP, Sampler
from .turns import steadied

HIDDEN_SCALE = 1e-4
"""Scale of hidden objects for Blender, which ignores animated visibility; a matrix of zeros has no
inverse."""
OPERATIONS = {
    "translation": ("xformOp:translate", Types.Double3, lambda rows: vectors(Vt.Vec3dArray, rows)),
    "rotation": ("xformOp:orient", Types.Quatd, quaternions),
    "scale": ("xformOp:scale", Types.Float3, lambda rows: vectors(Vt.Vec3fArray, rows)),
}


def write_place(prim: Prim, node: Node, gltf: Gltf, sampler: Sampler, for_blender: bool) -> None:
    """Writes transform and visibility of a node."""
    order = []
    if node.matrix is not None and not np.array_equal(node.matrix, np.eye(4)):
        # USD writes matrices for row vectors.
        prim.set("xformOp:transform", Types.Matrix4d, Gf.Matrix4d(*node.matrix.T.ravel().tolist()))
        order.append("xformOp:transform")
    elif node.matrix is None:
        for path in OPERATIONS:
            order += _write_part(prim, node, path, sampler)
    if _write_visibility(prim, node, gltf, sampler, for_blender):
        order.append("xformOp:scale:shown")
    if order:
        prim.set("xformOpOrder", Types.TokenArray, Vt.TokenArray(order), uniform=True)


def write_turn_and_scale(prim: Prim, node: Node, sampler: Sampler) -> None:
    """Writes the rest of a node's transform after its translation."""
    order = [name for path in ("rotation", "scale") for name in _write_part(prim, node, path, sampler)]
    if order:
        prim.set("xformOpOrder", Types.TokenArray, Vt.TokenArray(order), uniform=True)


def _write_part(prim: Prim, node: Node, path: str, sampler: Sampler) -> list[str]:
    name, kind, make = OPERATIONS[path]
    codes, rows = sampler.rows(node.curves.get(path), lambda times_s: node.parts_at(path, times_s))
    order, rest = [], None
    if path == "rotation":
        rows, rest = steadied(rows)
    if len(codes) > 1 or not np.allclose(rows[0], RESTS[path], rtol=0, atol=1e-12):
        prim.animate(name, kind, codes, make(rows))
        order.append(name)
    if rest is not None:
        prim.set("xformOp:orient:rest", Types.Quatd, quaternions(rest[None])[0])
        order.append("xformOp:orient:rest")
    return order


def _write_visibility(prim: Prim, node: Node, gltf: Gltf, sampler: Sampler, for_blender: bool) -> bool:
    """Writes the visibility; returns True if it needs an operation of its own."""
    if not node.is_shown:
        prim.set("visibility", Types.Token, "invisible")
    control = gltf.control(node.name, "sunfleck_node.visible")
    if control is not None:
        curve, at = control.curve, control.at
    elif node.shown is not None:
        curve, at = node.shown, node.shown.at
    else:
        return False
    codes, rows = sampler.rows(curve, lambda times_s: at(times_s)[:, :1] >= 0.5)
    shown = rows[:, 0].tolist()
    prim.animate("visibility", Types.Token, codes, ["inherited" if each else "invisible" for each in shown])
    if not for_blender or len(codes) == 1:
        return False
    # Scales are interpolated, so each is repeated just before the next.
    scales = [1.0 if each else HIDDEN_SCALE for each in shown]
    samples = dict(zip((codes[1:] - JUMP).tolist(), scales[:-1])) | dict(zip(codes.tolist(), scales))
    prim.animate(
        "xformOp:scale:shown", Types.Float3, samples.keys(), [Gf.Vec3f(each) for each in samples.values()]
    )
    return True
