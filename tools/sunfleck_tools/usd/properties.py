"""Custom properties as attributes, which programs show and keep.

`sunfleck_fog_volume: {density: 0.1}` of a node becomes `userProperties:sunfleck_fog_volume:density = 0.1`.
"""

import json

from pxr import Gf, Sdf

from ..gltf.nodes import Node
from ..gltf.scene import Control, Gltf
from .prims import Prim, Types
from .samples import Sampler

SPACE = "userProperties:"


def write_properties(prim: Prim, name: str, fields: dict, owner: str, gltf: Gltf, sampler: Sampler) -> None:
    """Writes the fields of a property of `owner`, animated ones included."""
    for field, value in fields.items():
        attribute = f"{SPACE}{name}:{field}"
        control = gltf.control(owner, f"{name}.{field}")
        if control is None:
            _write(prim, attribute, value)
        else:
            _animate(prim, attribute, control, sampler)


def say_leaf_id(prim: Prim, node: Node) -> None:
    """Writes the leaf id of a node, if it has one."""
    leaf_id = node.extras.member("leaf_id")
    if leaf_id is not None:
        prim.set(f"{SPACE}leaf_id", Types.Int, leaf_id.whole(0, 2**31 - 1), custom=True)


def _write(prim: Prim, attribute: str, value: object) -> None:
    kinds = {2: (Types.Double2, Gf.Vec2d), 3: (Types.Double3, Gf.Vec3d)}
    if isinstance(value, bool):
        prim.set(attribute, Types.Bool, value, custom=True)
    elif isinstance(value, (int, float)):
        prim.set(attribute, Types.Double, float(value), custom=True)
    elif isinstance(value, Sdf.AssetPath):
        prim.set(attribute, Types.Asset, value, custom=True)
    elif isinstance(value, str):
        prim.set(attribute, Types.String, value, custom=True)
    elif isinstance(value, list) and len(value) in kinds and all(_is_number(each) for each in value):
        kind, make = kinds[len(value)]
        prim.set(attribute, kind, make(*value), custom=True)
    else:
        prim.set(attribute, Types.String, json.dumps(value), custom=True)


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _animate(prim: Prim, attribute: str, control: Control, sampler: Sampler) -> None:
    codes, rows = sampler.rows(control.curve, control.at)
    if rows.shape[1] == 1:
        prim.animate(attribute, Types.Double, codes, rows[:, 0].tolist(), custom=True)
    else:
        prim.animate(attribute, Types.Double3, codes, [Gf.Vec3d(*row) for row in rows.tolist()], custom=True)
