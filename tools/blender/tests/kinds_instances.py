"""Of the scenes of `kinds` those of instances that instances are made of, and of what stands in one place."""

import bpy
import scenes
from kinds_parts import leaves, matte
from leaf_scenes import Tree as Nodes


def tints(scene):
    """Nodes give tints to leaves and to sprays of three of these; a collection with all of it stands in two places."""
    tree = matte()
    asked = tree.node("Attribute", attribute_type="INSTANCER", attribute_name="tint")
    tree.link(asked.outputs["Color"], tree.shader.inputs["Base Color"])
    leaf, place = leaves(scene, tree, 1)[0], scenes.quad(scene, "place", 2.0, tree.material)
    leaf.location.z = -9.0
    nodes = Nodes(place)
    three = nodes.node("GeometryNodePoints")
    three.inputs["Count"].default_value = 3
    spray = nodes.instances(three.outputs[0], leaf)
    nodes.link(vectors(nodes, 0.0, 1.0), three.inputs["Position"])
    nodes.link(vectors(nodes, -0.5, 0.5, 1), spray.inputs["Rotation"])
    crown = nodes.instances(nodes.scatter(2.0).outputs["Points"], leaf)
    nodes.link(vectors(nodes, 0.9, 2.1, 2), crown.inputs["Rotation"])
    nodes.link(tinted(nodes, spray.outputs[0], 3), crown.inputs["Instance"])
    nodes.link(tinted(nodes, crown.outputs[0], 4), nodes.target.inputs[0])
    crown.inputs["Scale"].default_value = (0.5,) * 3
    group = bpy.data.collections.new("group")
    scene.collection.objects.unlink(place)
    group.objects.link(place)
    for number in range(2):
        copy = scenes.add(scene, f"copy {number}", None, (number - 0.5, 0.0, 0.8))
        copy.instance_type, copy.instance_collection = "COLLECTION", group


def tinted(nodes, geometry, seed):
    """Of each instance a colour by chance."""
    store = nodes.node("GeometryNodeStoreNamedAttribute", data_type="FLOAT_COLOR", domain="INSTANCE")
    store.inputs["Name"].default_value = "tint"
    nodes.link(geometry, store.inputs["Geometry"])
    nodes.link(vectors(nodes, 0.0, 1.0, seed), next(one for one in store.inputs if one.name == "Value" and one.enabled))
    return store.outputs[0]


def vectors(nodes, low, high, seed=0):
    """Of each instance three numbers by chance."""
    made = nodes.node("FunctionNodeRandomValue", data_type="FLOAT_VECTOR")
    for name, value in (("Min", (low,) * 3), ("Max", (high,) * 3), ("Seed", seed)):
        next(socket for socket in made.inputs if socket.enabled and socket.name == name).default_value = value
    return next(output for output in made.outputs if output.enabled)


def doubled(scene, is_open=False):
    """Leaves with another, turned over, in their place."""
    scene.render.use_motion_blur = is_open
    for leaf in leaves(scene, matte()):
        back = leaf.copy()
        back.data = leaf.data.copy()
        back.data.flip_normals()
        scene.collection.objects.link(back)


def box_on_the_ground(scene):
    """Nobody sees where they touch."""
    scenes.quad(scene, "ground", 6.0, matte().material)
    bpy.ops.mesh.primitive_cube_add(size=1.0, location=(0.0, 0.0, 0.5))


def flat_box(scene):
    """Its top and its bottom are one."""
    box_on_the_ground(scene)
    bpy.context.active_object.scale.z = 0.0
