"""What the scenes of `kinds` are made of.

Sockets are addressed by name: their numbers differ from version to version.
"""

import bpy
import numpy
import scenes
from test_materials import Tree

FRAMES = (1, 10)
RED, GREEN = (0.8, 0.1, 0.05, 1.0), (0.05, 0.6, 0.1, 1.0)


def stage(towards=(0.3, 1.0, -0.6)):
    scene = scenes.empty(FRAMES)
    scenes.camera(scene, (0.0, -5.0, 1.0), (0.0, 0.0, 1.0))
    scenes.sun(scene, towards=towards)
    return scene


def leaves(scene, tree, count=5):
    """They stand upright and face the camera, turned a little."""
    found = []
    for number in range(count):
        leaf = scenes.quad(scene, f"leaf {number}", 0.7, tree.material, (0.8 * number - 1.6, 0.0, 1.0))
        leaf.data.uv_layers.new(name="UVMap").uv.foreach_set("vector", numpy.array([0, 0, 1, 0, 1, 1, 0, 1], "f4"))
        leaf.rotation_euler = (1.4, 0.2 * number, 0.0)
        found.append(leaf)
    return found


def matte():
    tree = Tree()
    tree.shader.inputs["Specular IOR Level"].default_value, tree.shader.inputs["Roughness"].default_value = 0.0, 1.0
    return tree


def between(tree, output):
    """The base colour goes from red to green as a number goes from 0 to 1."""
    ramp = tree.node("ValToRGB")
    ramp.color_ramp.elements[0].color, ramp.color_ramp.elements[1].color = RED, GREEN
    tree.link(output, next(iter(ramp.inputs))).link(ramp.outputs["Color"], tree.shader.inputs["Base Color"])
    return tree


def output(node, *names):
    """By whichever name a version has."""
    return next(node.outputs[name] for name in names if name in node.outputs)


def keyed(owner, path, values):
    for frame, value in zip(FRAMES, values):
        if path.startswith("["):
            owner[path[2:-2]] = value
        else:
            setattr(owner, path, value)
        owner.keyframe_insert(path, frame=frame)


def group_of(tree, kind, **sockets):
    """A node of a group with one node in it, whose named inputs are the group's."""
    group = bpy.data.node_groups.new("group", "ShaderNodeTree")
    start, inner, end = (group.nodes.new(name) for name in ("NodeGroupInput", kind, "NodeGroupOutput"))
    group.interface.new_socket("out", in_out="OUTPUT", socket_type=inner.outputs[0].bl_idname)
    group.links.new(inner.outputs[0], end.inputs["out"])
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group
    for name, value in sockets.items():
        group.interface.new_socket(name, in_out="INPUT", socket_type=inner.inputs[name].bl_idname)
        group.links.new(start.outputs[name], inner.inputs[name])
        node.inputs[name].default_value = value
    return node
