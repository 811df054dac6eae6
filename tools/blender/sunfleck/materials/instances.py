"""Materials that vary by instance, or by frame: by Cycles' random number, by data of objects, particles and
instancers, or by attributes.

In go a material and facts of an instance, out comes a copy of the material with these as constants.
Invariants: numbers are Cycles' own. The number of copies is limited, by rounding facts. A question is a
type of node, an output and, for attributes, a name; facts are answers by question, four numbers each.
"""

import bpy
import numpy

from ..keys import trees_of
from . import dependence, particles, properties

# Maximum copies of simple and of baked materials.
MOST, MOST_BAKED = 256, 16
# Maximum number of changes over all objects and frames, beyond which facts are rounded as for baked
# materials.
MOST_CHANGES = 20000
WORD = 0xFFFFFFFF
# Terminator of `persistent_id`.
NO_NUMBER = 0x7FFFFFFF
# Question of a mesh's copy for one side: 0 is the front, 1 the back.
SIDE = ("NEW_GEOMETRY", "Backfacing", "")
UNKNOWN = (0.5, 0.5, 0.5, 1.0)
# Constant answers; others are queried in every frame.
STILL = {
    ("OBJECT_INFO", "Random", ""), ("OBJECT_INFO", "Material Index", ""), ("PARTICLE_INFO", "Random", ""),
    ("PARTICLE_INFO", "Index", ""), ("PARTICLE_INFO", "Lifetime", ""),
}


def facts(instance, thing, questions, here):
    """Facts of an instance in the graph; `here` has its attributes and the moment."""
    return tuple((question, answer(question, instance, thing, here)) for question in questions)


def answer(question, instance, thing, here):
    kind, output, name = question
    if kind == "ATTRIBUTE":
        return of_attribute(output, name, instance, thing, here)
    if kind == "PARTICLE_INFO":
        return particles.answer(output, instance, here.frame)
    if kind in {"TEX_COORD", "UVMAP"}:
        if not instance.is_instance:
            return (0.0, 0.0, 0.0, 1.0)
        if output == "UV":
            return (*instance.uv, 0.0, 1.0)
        return (*(0.5 * axis - 0.5 for axis in instance.orco), 1.0)
    if output == "Random":
        number = instance.random_id & WORD if instance.is_instance else hashed(thing.name)
        return (number / WORD,) * 3 + (1.0,)
    # Cycles uses those of the instancer, if there is one.
    owner = instance.parent if instance.is_instance and instance.parent else thing
    return {
        "Color": lambda: tuple(owner.color), "Alpha": lambda: (owner.color[3],) * 3 + (1.0,),
        "Object Index": lambda: (float(owner.pass_index),) * 3 + (1.0,), "Material Index": lambda: UNKNOWN,
        "Location": lambda: (*instance.matrix_world.translation, 1.0),
    }[output]()


def of_attribute(kind, name, instance, thing, here):
    """Blender's lookup: in the instance, its instancer, and the object itself."""
    if kind == "VIEW_LAYER":
        return properties.first((here.layer, here.scene, here.scene.world), name)
    owners = (thing, thing.data)
    if kind == "INSTANCER" and instance.is_instance:
        own = here.attributes(instance).get(name)
        if own is not None:
            return own
        system, parent = instance.particle_system, instance.parent
        owners = (system and system.settings, parent, parent and parent.data, *owners)
    return properties.first(owners, name)


def hashed(name):
    """Cycles' number of an object from its name: `hash_uint2(hash_string(name), 0)`."""
    text = 0
    for letter in name.encode():
        text = (37 * text + letter) & WORD
    return particles.hash_of(text)


class Attributed:
    """Attributes of instancers (objects, collections, geometries), nested ones included, by
    `persistent_id`."""

    def __init__(self, source, names):
        self.source, self.names, self.inner, self.values = source, names, {}, {}
        self.rows, self.made = {}, []
        geometry = source if isinstance(source, bpy.types.GeometrySet) else geometry_of(source)
        cloud = geometry.instances_pointcloud() if geometry else None
        if cloud is not None:
            own, made = cloud.attributes, geometry.instance_references()
            numbers = [one.value for one in own["id"].data] if "id" in own else range(len(cloud.points))
            self.rows = {number: row for row, number in enumerate(numbers)}
            self.made = [made[one.value] for one in own[".reference_index"].data]
            self.values = {name: values_of(own[name]) for name in names & set(own.keys())}
        elif collection := source if isinstance(source, bpy.types.Collection) else collection_of(source):
            self.made = list(collection.all_objects)
            self.rows = dict(enumerate(range(len(self.made))))

    def of(self, path, shown):
        """Outermost number first; the innermost attribute counts. `shown` is the instanced object."""
        # The last number is that of a part of a geometry.
        path = path[:-1] if shown == self.source else path
        row = self.rows.get(path[0]) if path else None
        if row is None:
            return {}
        if row not in self.inner:
            self.inner[row] = Attributed(self.made[row], self.names)
        return {name: values[row] for name, values in self.values.items()} | self.inner[row].of(path[1:], shown)


def geometry_of(thing):
    """Geometry of an object from nodes; other objects have no instances."""
    has_nodes = any(one.type == "NODES" for one in getattr(thing, "modifiers", ()))
    return thing.evaluated_geometry() if has_nodes else None


def collection_of(thing):
    return getattr(thing, "instance_collection", None)


def values_of(attribute):
    fields = {"FLOAT_COLOR": "color", "BYTE_COLOR": "color", "FLOAT_VECTOR": "vector", "FLOAT2": "vector"}
    read = fields.get(attribute.data_type, "value")
    return [properties.four(getattr(one, read)) for one in attribute.data]


def used(facts, questions):
    """Facts that a material uses, reduced to the components that it uses."""
    return tuple(
        (question, tuple(part if counts else 0.0 for part, counts in zip(value, questions[question])))
        for question, value in facts if question in questions
    )


class Levels:
    """Rounds facts to the middle of equal levels between the minimum and the maximum."""

    def __init__(self, all_facts, most):
        rows = self.rows(all_facts)
        self.low, self.size = rows.min(axis=0), numpy.ptp(rows, axis=0)
        self.count, fewer = most, 1
        while fewer < self.count:
            middle = (fewer + self.count + 1) // 2 if self.count - fewer > 1 else self.count
            if len(numpy.unique(self.levels(rows, middle), axis=0)) <= most:
                fewer = middle
            elif middle == self.count:
                self.count = fewer if middle - fewer <= 1 else middle - 1
            else:
                self.count = middle - 1

    @staticmethod
    def rows(all_facts):
        return numpy.array([[part for _, value in facts for part in value] for facts in all_facts], float)

    def levels(self, rows, count):
        share = (rows - self.low) / numpy.where(self.size > 0.0, self.size, 1.0)
        return numpy.minimum((share * count).astype(int), count - 1)

    def rounded(self, facts):
        level = self.levels(self.rows([facts]), self.count)[0]
        middles = numpy.where(self.size > 0.0, self.low + (level + 0.5) / self.count * self.size, self.low)
        parts = iter(middles.tolist())
        return tuple((question, tuple(next(parts) for _ in value)) for question, value in facts)


def copy(material, facts, name):
    """Copy of a material for an instance with these facts."""
    made = material.copy()
    made.name = name
    fixed(made.node_tree, dict(facts), float(material.pass_index))
    return made


def fixed(tree, facts, index):
    """Replaces the nodes of questions by constants."""
    for node in list(tree.nodes):
        if node.type == "GROUP" and node.node_tree:
            node.node_tree = node.node_tree.copy()
            fixed(node.node_tree, facts, index)
        # In a copy for one side, questions to instances remain.
        for output, question in dependence.questions_of_node(node) if SIDE not in facts else ():
            value = (index,) * 4 if output.name == "Material Index" else facts.get(question, UNKNOWN)
            replaced(tree, output, value)
        for output in dependence.backfacing(node) if SIDE in facts else ():
            replaced(tree, output, facts[SIDE])


def replaced(tree, output, value):
    """A number from a colour is its luminance, from a vector or attribute its mean."""
    three = (value[3],) * 3 if output.name == "Alpha" and output.node.type == "ATTRIBUTE" else value[:3]
    weights = (0.2126, 0.7152, 0.0722) if output.type == "RGBA" else (1.0 / 3.0,) * 3
    for link in list(output.links):
        if hasattr(getattr(link.to_socket, "default_value", 0.0), "__len__"):
            node = tree.nodes.new("ShaderNodeCombineXYZ")
            for socket, part in zip(node.inputs, three):
                socket.default_value = part
        else:
            node = tree.nodes.new("ShaderNodeValue")
            is_grey = three[0] == three[1] == three[2]
            node.outputs[0].default_value = three[0] if is_grey else sum(a * b for a, b in zip(three, weights))
        tree.links.new(node.outputs[0], link.to_socket)


def remove(material):
    """Removes a copy with its groups."""
    trees = trees_of(material.node_tree)[1:]
    bpy.data.materials.remove(material)
    for tree in trees:
        if tree.users == 0:
            bpy.data.node_groups.remove(tree)
