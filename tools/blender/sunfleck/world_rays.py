"""Worlds with *Is Camera Ray*, which are split into one for the camera and one for lighting.

In goes a world, out comes either of them, during a block. Invariant: other dependences on rays stay.
"""

from contextlib import contextmanager

import bpy

from .materials import links

CAMERA = "Is Camera Ray"


def tells_camera_apart(world):
    """Whether its nodes depend on camera rays and on no others."""
    asked = [node for node in world.node_tree.nodes if node.type == "LIGHT_PATH"]
    outputs = {output.name for node in asked for output in node.outputs if output.is_linked}
    return outputs == {CAMERA}


@contextmanager
def seen_by(world, is_camera):
    copy = world.copy()
    try:
        settle(copy.node_tree, is_camera)
        yield copy
    finally:
        bpy.data.worlds.remove(copy)


def settle(tree, is_camera):
    """Replaces the output by a constant, and a mix by it by one of its shaders."""
    answer = tree.nodes.new("ShaderNodeValue")
    answer.outputs[0].default_value = float(is_camera)
    for node in [one for one in tree.nodes if one.type == "LIGHT_PATH"]:
        for link in list(node.outputs[CAMERA].links):
            tree.links.new(answer.outputs[0], link.to_socket)
        tree.nodes.remove(node)
    surface = tree.get_output_node("CYCLES").inputs["Surface"]
    while (link := links.link_to(surface)) and link.from_node.type == "MIX_SHADER":
        mix = link.from_node
        share = links.link_to(mix.inputs[0])
        if share is None or share.from_node != answer:
            return
        link = links.link_to(mix.inputs[2 if is_camera else 1])
        # Links of a node that is removed are freed.
        chosen = link and link.from_socket
        tree.nodes.remove(mix)
        if chosen is None:
            return
        tree.links.new(chosen, surface)
    if link and link.from_node.type == "BACKGROUND":
        for node in [one for one in tree.nodes if one.type == "BACKGROUND" and one != link.from_node]:
            tree.nodes.remove(node)
