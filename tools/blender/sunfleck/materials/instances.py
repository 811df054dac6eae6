"""Materials that differ from instance to instance: by Cycles' random number, the object's colour and
index, or attributes.

In go a material and facts of an instance, out comes a copy of the material in which those are
constants. Invariants: the random number is Cycles'. No more copies are made than there are levels;
beyond that facts are rounded.
"""

from dataclasses import dataclass, field

import bpy

from . import dependence
from .sockets import Source

# Of simple materials and of those that are baked.
MOST, MOST_BAKED = 256, 16
WORD = 0xFFFFFFFF


@dataclass(frozen=True)
class Facts:
    """Of one instance."""

    random: float = 0.5
    color: tuple = (1.0, 1.0, 1.0)
    alpha: float = 1.0
    index: int = 0
    location: tuple = (0.0, 0.0, 0.0)
    # Names and values.
    attributes: tuple = field(default=())


def facts(instance, thing, attributes):
    """Of an instance in the graph."""
    number = instance.random_id & WORD if instance.is_instance else hashed(thing.name)
    # Cycles' own are those of the instancer where there is one.
    owner = instance.parent if instance.is_instance and instance.parent else thing
    return Facts(
        number / WORD,
        tuple(owner.color[:3]),
        owner.color[3],
        owner.pass_index,
        tuple(instance.matrix_world.translation),
        tuple(attributes),
    )


def hashed(name):
    """Cycles' number of an object by its name: `hash_uint2(hash_string(name), 0)`, by Jenkins (lookup3)."""
    text = 0
    for letter in name.encode():
        text = (37 * text + letter) & WORD
    a = b = c = (0xDEADBEEF + (2 << 2) + 13) & WORD
    a = (a + text) & WORD

    def turned(value, bits):
        return ((value << bits) | (value >> (32 - bits))) & WORD

    for bits in ((14, 11, 25), (16, 4, 14), (24, 0, 0)):
        c = ((c ^ b) - turned(b, bits[0])) & WORD
        if bits[1]:
            a = ((a ^ c) - turned(c, bits[1])) & WORD
            b = ((b ^ a) - turned(a, bits[2])) & WORD
    return c


def attributes_of(parent, names):
    """By instance of a parent, in the graph's order: names and values of its instances' attributes; None
    if there are none."""
    geometry = parent.evaluated_geometry() if hasattr(parent, "evaluated_geometry") else None
    cloud = geometry.instances_pointcloud() if geometry else None
    if cloud is None:
        return None
    found = {}
    for name in names & set(cloud.attributes.keys()):
        data = cloud.attributes[name].data
        fields = {"FLOAT_COLOR": "color", "BYTE_COLOR": "color", "FLOAT_VECTOR": "vector"}
        read = fields.get(cloud.attributes[name].data_type, "value")
        found[name] = [value(getattr(one, read)) for one in data]
    return [tuple((name, values[row]) for name, values in found.items()) for row in range(len(cloud.points))]


def value(found):
    return tuple(float(part) for part in found[:3]) if hasattr(found, "__len__") else (float(found),) * 3


def used(facts, material):
    """What of the facts a material looks at."""
    kinds, names = set(), set()
    for node in dependence.nodes_of(material):
        if node.type == "OBJECT_INFO":
            kinds |= {output.name for output in node.outputs if output.is_linked}
        if node.type == "ATTRIBUTE" and node.attribute_type in {"INSTANCER", "OBJECT"}:
            names.add(node.attribute_name)
    return Facts(
        facts.random if "Random" in kinds else 0.5,
        facts.color if "Color" in kinds else (1.0, 1.0, 1.0),
        facts.alpha if "Alpha" in kinds else 1.0,
        facts.index if "Object Index" in kinds else 0,
        facts.location if "Location" in kinds else (0.0, 0.0, 0.0),
        tuple((name, found) for name, found in facts.attributes if name in names),
    )


def rounded(facts, levels):
    """To the middle of a level."""
    near = lambda number: (int(min(max(number, 0.0), 1.0 - 1e-9) * levels) + 0.5) / levels
    return Facts(
        near(facts.random), tuple(map(near, facts.color)), near(facts.alpha), facts.index,
        tuple(round(axis) * 1.0 for axis in facts.location),
        tuple((name, tuple(near(part) for part in found)) for name, found in facts.attributes),
    )


def copy(material, facts, name):
    """The material as it is on an instance of these facts."""
    made = material.copy()
    made.name = name
    fixed(made.node_tree, facts, material.pass_index)
    return made


def fixed(tree, facts, index):
    """Puts constants in the place of what asks for facts."""
    said = {
        "Random": (facts.random,) * 3, "Color": facts.color, "Alpha": (facts.alpha,) * 3, "Object Index": (float(facts.index),) * 3,
        "Material Index": (float(index),) * 3, "Location": facts.location,
    }
    for node in list(tree.nodes):
        if node.type == "GROUP" and node.node_tree:
            node.node_tree = node.node_tree.copy()
            fixed(node.node_tree, facts, index)
        elif node.type == "OBJECT_INFO":
            for output in node.outputs:
                replaced(tree, output, said[output.name])
        elif node.type == "ATTRIBUTE" and node.attribute_type in {"INSTANCER", "OBJECT"}:
            found = dict(facts.attributes).get(node.attribute_name, (0.0, 0.0, 0.0))
            for output in node.outputs:
                replaced(tree, output, (1.0,) * 3 if output.name == "Alpha" else found)


def replaced(tree, output, value):
    for link in list(output.links):
        is_color = hasattr(getattr(link.to_socket, "default_value", 0.0), "__len__")
        node = tree.nodes.new("ShaderNodeRGB" if is_color else "ShaderNodeValue")
        node.outputs[0].default_value = (*value, 1.0) if is_color else Source(value).number()
        tree.links.new(node.outputs[0], link.to_socket)


def remove(material):
    """With the groups that were copied for it."""
    from .bake import inner_trees

    trees = inner_trees(material.node_tree)
    bpy.data.materials.remove(material)
    for tree in trees:
        if tree.users == 0:
            bpy.data.node_groups.remove(tree)
