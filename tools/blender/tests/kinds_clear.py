"""Of the scenes of `kinds` those of what lets light straight through, in a colour or beside a light."""

import bpy
from kinds_parts import GREEN, leaves, matte


def tinting(tree, color=GREEN):
    node = tree.node("BsdfTransparent")
    node.inputs["Color"].default_value = color
    return node


def stained(scene):
    """Transparent in a colour, in part: leaves stand before others."""
    tree = matte()
    tree.mixed(0.4, tree.shader, tinting(tree))
    for leaf in leaves(scene, tree):
        before = leaf.copy()
        before.location.y, before.location.x = -0.4, leaf.location.x + 0.2
        scene.collection.objects.link(before)


def stained_gloss(scene):
    """No surface here has a shine and a tint."""
    tree = matte()
    tree.mixed(0.4, tree.node("BsdfGlossy"), tinting(tree))
    leaves(scene, tree)


def flame(scene):
    """Light alone before a sky, even and of a texture; what is lit by it is not there."""
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    for number, is_even in enumerate((True, False)):
        tree = matte()
        clear, light, both = tinting(tree, (1.0,) * 4), tree.node("Emission"), tree.node("AddShader")
        light.inputs["Color"].default_value = (1.0, 0.4, 0.1, 1.0)
        if not is_even:
            tree.link(tree.node("TexNoise").outputs[0], light.inputs["Strength"])
        tree.link(clear.outputs["BSDF"], both.inputs[0]).link(light.outputs["Emission"], both.inputs[1])
        tree.link(both.outputs["Shader"], tree.output.inputs["Surface"])
        leaves(scene, tree, 1)[0].location.x = 0.8 * number
