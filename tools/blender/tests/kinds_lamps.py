"""Of the scenes of `kinds` those of lamps."""

import bpy
import kinds_surfaces as surfaces
import scenes
from kinds_parts import keyed, leaves, matte


def lamp(scene, kind):
    data = bpy.data.lights.new("lamp", kind)
    data.energy = 200.0
    if kind != "AREA":
        data.use_soft_falloff = False
    thing = scenes.add(scene, "lamp", data, (1.0, -2.0, 2.0))
    thing.visible_camera = False
    bpy.data.objects.remove(scene.objects["sun"])
    return thing


def lamp_for_its_size(scene, is_soft=False):
    """A sphere that is the brighter the larger it is."""
    leaves(scene, matte())
    data = lamp(scene, "POINT").data
    data.normalize, data.shadow_soft_size, data.use_soft_falloff = False, 0.2, is_soft


def softbox(scene):
    """An area light behind a grid that opens."""
    leaves(scene, matte())
    thing = lamp(scene, "AREA")
    thing.rotation_euler, thing.data.size = (0.6, 0.2, 0.0), 0.5
    keyed(thing.data, "spread", (0.5, 2.0))


def mesh_lamp(scene):
    """A glowing face above the picture lights a corner of two walls."""
    bpy.data.objects.remove(scene.objects["sun"])
    scenes.quad(scene, "floor", 6.0, scenes.material("floor", (0.7,) * 3))
    wall = scenes.quad(scene, "wall", 6.0, scenes.material("wall", (0.8, 0.5, 0.3)), (0.0, 1.5, 1.0))
    wall.rotation_euler.x = 1.5
    glow = scenes.material("glow", (0.0,) * 3)
    inputs = glow.node_tree.nodes["Principled BSDF"].inputs
    inputs["Emission Color"].default_value, inputs["Emission Strength"].default_value = (1.0,) * 4, 8.0
    scenes.quad(scene, "lamp", 0.8, glow, (0.3, -0.6, 3.2)).rotation_euler.x = 2.6


def uneven_spot(scene):
    leaves(scene, matte())
    lamp(scene, "SPOT").scale = (2.0, 0.5, 1.0)


def fading(scene):
    """By a node that is told how far its light goes."""
    leaves(scene, matte())
    data = lamp(scene, "POINT").data
    data.use_nodes = True
    falloff = data.node_tree.nodes.new("ShaderNodeLightFalloff")
    shader = next(node for node in data.node_tree.nodes if node.type == "EMISSION")
    data.node_tree.links.new(falloff.outputs["Linear"], shader.inputs["Strength"])


def mirror_alone(scene):
    tree = matte()
    tree.shader.inputs["Metallic"].default_value, tree.shader.inputs["Roughness"].default_value = 1.0, 0.0
    leaves(scene, tree)
    scene.sunfleck_settings.all_bounces = False


def in_mirrors(scene):
    """The camera sees them in smooth leaves alone, of metal and of glaze."""
    trees = matte(), matte()
    for tree, metallic in zip(trees, (1.0, 0.0)):
        inputs = tree.shader.inputs
        inputs["Metallic"].default_value, inputs["Roughness"].default_value = metallic, 0.03
        inputs["Specular IOR Level"].default_value = 0.5
    for number, leaf in enumerate(leaves(scene, trees[0])):
        leaf.data.materials[0] = trees[number % 2].material
    for kind, x in (("AREA", -1.2), ("POINT", 1.0)):
        data = bpy.data.lights.new("lamp", kind)
        data.energy = 100.0
        setattr(data, *(("size", 2.0) if kind == "AREA" else ("shadow_soft_size", 1.0)))
        thing = scenes.add(scene, "lamp", data, (x, -3.0, 2.0), (x, 0.0, 1.0))
        thing.visible_camera = False


def seen(scene):
    """Of every kind, before leaves and behind fog."""
    leaves(scene, matte())
    scene.objects["sun"].data.energy = 0.5
    for number, (kind, soft) in enumerate((("POINT", False), ("POINT", True), ("SPOT", False), ("AREA", False), ("AREA", False))):
        data = bpy.data.lights.new("lamp", kind)
        data.energy = 3.0
        x = 0.8 * number - 1.6
        if kind == "AREA":
            data.shape, data.size, data.size_y, data.spread = "RECTANGLE" if number == 3 else "ELLIPSE", 0.5, 0.3, 3.0 - 0.5 * number
        else:
            data.use_soft_falloff, data.shadow_soft_size = soft, 0.2
        thing = scenes.add(scene, "lamp", data, (x, 0.3 * number - 1.6, 0.4 + 0.2 * number), (0.8 * x, -5.0, 0.8))
        thing.visible_camera = True


def soft_by_a_leaf(scene):
    """Soft falloff, as near as its radius."""
    leaves(scene, matte())
    data = lamp(scene, "POINT").data
    scene.objects["lamp"].location, data.energy = (0.2, -0.6, 1.3), 20.0
    data.use_soft_falloff, data.shadow_soft_size = True, 0.2


def in_fog(scene, is_soft, anisotropy):
    """With fog right about it; new lamps have soft falloff."""
    _, scatter = surfaces.fog_box(scene)
    scatter.inputs["Anisotropy"].default_value = anisotropy
    thing = lamp(scene, "POINT")
    thing.location, thing.data.energy = (0.0, 2.0, 1.0), 8.0
    thing.data.use_soft_falloff, thing.data.shadow_soft_size = is_soft, 0.3


def about_a_leaf(scene):
    leaves(scene, matte())
    thing = lamp(scene, "POINT")
    thing.location, thing.data.shadow_soft_size = (0.0, 0.1, 1.0), 0.3
