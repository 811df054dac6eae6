"""Small scenes of materials, each of one kind, to be rendered beside Cycles; on the stage
of `beside_stage`."""

import math

import bpy
import numpy
import scenes
from beside_stage import shaded
from test_materials import Tree


def default_principled(scene):
    """As the add menu has it, rough by a half and shiny by 4 %."""
    for name in ("floor", "wall", "card"):
        shader = bpy.data.materials[name].node_tree.nodes["Principled BSDF"]
        shader.inputs["Specular IOR Level"].default_value = shader.inputs["Roughness"].default_value = 0.5
    scenes.sun(scene)


def rough_principled(scene):
    default_principled(scene)
    bpy.data.materials["floor"].node_tree.nodes["Principled BSDF"].inputs["Roughness"].default_value = 1.0


def smooth_principled(scene):
    default_principled(scene)
    bpy.data.materials["floor"].node_tree.nodes["Principled BSDF"].inputs["Roughness"].default_value = 0.15


def refracting(scene, index, roughness=0.5, level=0.5):
    """Floor, wall and card of a refractive index."""
    default_principled(scene)
    for name in ("floor", "wall", "card"):
        inputs = bpy.data.materials[name].node_tree.nodes["Principled BSDF"].inputs
        inputs["IOR"].default_value, inputs["Specular IOR Level"].default_value = index, level
        inputs["Roughness"].default_value = roughness


def like_water(scene):
    refracting(scene, 1.33)


def like_smooth_water(scene):
    refracting(scene, 1.33, roughness=0.1)


def like_old_files(scene):
    """With the default of Blender 3."""
    refracting(scene, 1.45)


def like_diamond(scene):
    refracting(scene, 2.1, roughness=0.3)


def shinier(scene):
    refracting(scene, 1.5, level=1.0)


def coloured_metal(scene):
    shader = bpy.data.materials["floor"].node_tree.nodes["Principled BSDF"]
    shader.inputs["Metallic"].default_value, shader.inputs["Roughness"].default_value = 1.0, 0.6
    scenes.sun(scene, towards=(0.0, 0.6, -1.0))


def waves(name, size=64):
    """A picture without edges: between texels Cycles mixes what sRGB encodes, and glTF what it stands for."""
    image = bpy.data.images.new(name, size, size)
    across, up = numpy.meshgrid(*2 * [0.5 + 0.4 * numpy.sin(numpy.arange(size) * math.tau / size)])
    image.pixels.foreach_set(
        numpy.stack([across, up, 1.0 - across, numpy.ones_like(up)], -1).astype("f4").ravel()
    )
    image.pack()
    return image


def textures(scene):
    """Colour, roughness and a normal map, through a mapping."""
    tree = Tree()
    mapping, uv = tree.node("Mapping"), tree.node("UVMap", uv_map="UVMap")
    mapping.inputs["Scale"].default_value, mapping.inputs["Rotation"].default_value[2] = (2.0, 3.0, 1.0), 0.5
    tree.link(uv.outputs[0], mapping.inputs["Vector"])
    for name, socket in (("colour", "Base Color"), ("rough", "Roughness")):
        picture = tree.node("TexImage", image=waves(name))
        tree.link(mapping.outputs[0], picture.inputs["Vector"]).link(
            picture.outputs["Color"], tree.shader.inputs[socket]
        )
    picture.image.colorspace_settings.name = "Non-Color"
    bumps = bpy.data.images.new("bumps", 16, 16)
    bumps.colorspace_settings.name = "Non-Color"
    slopes = 0.5 + 0.2 * numpy.sin(numpy.arange(16) * math.tau / 16)
    pixels = numpy.ones((16, 16, 4), "f4")
    pixels[..., 0], pixels[..., 1] = slopes[None], slopes[:, None]
    bumps.pixels.foreach_set(pixels.ravel())
    bumps.pack()
    bent, bends = tree.node("TexImage", image=bumps), tree.node("NormalMap", uv_map="UVMap")
    tree.link(bent.outputs["Color"], bends.inputs["Color"]).link(
        bends.outputs[0], tree.shader.inputs["Normal"]
    )
    tree.shader.inputs["Specular IOR Level"].default_value = 0.0
    shaded("floor", tree)
    scenes.sun(scene)


def colour_attributes(scene):
    tree = Tree()
    tree.link(tree.node("VertexColor", layer_name="tint").outputs["Color"], tree.shader.inputs["Base Color"])
    tree.shader.inputs["Specular IOR Level"].default_value = 0.0
    floor = shaded("floor", tree)
    colors = [0.9, 0.1, 0.1, 1, 0.1, 0.9, 0.1, 1, 0.1, 0.1, 0.9, 1, 0.9, 0.9, 0.1, 1]
    floor.data.color_attributes.new("tint", "FLOAT_COLOR", "POINT").data.foreach_set("color", colors)
    scenes.sun(scene)


def coloured_by_chance(tree):
    info, ramp = tree.node("ObjectInfo"), tree.node("ValToRGB")
    ramp.color_ramp.elements[0].color, ramp.color_ramp.elements[1].color = (
        (0.8, 0.1, 0.0, 1.0),
        (0.1, 0.6, 0.1, 1.0),
    )
    tree.link(info.outputs["Random"], ramp.inputs[0]).link(ramp.outputs[0], tree.shader.inputs["Base Color"])
    tree.shader.inputs["Specular IOR Level"].default_value = 0.0


def random_colours(scene):
    tree = Tree()
    coloured_by_chance(tree)
    for number in range(24):
        scenes.quad(
            scene,
            f"leaf {number}",
            0.4,
            tree.material,
            (0.5 * (number % 8) - 1.7, 0.5 * (number // 8), 0.3 + 0.1 * number % 1.0),
        )
    scenes.sun(scene)


def baked_nodes(scene):
    tree = Tree()
    noise, ramp = tree.node("TexNoise"), tree.node("ValToRGB")
    noise.inputs["Scale"].default_value = 3.0
    ramp.color_ramp.elements[0].color, ramp.color_ramp.elements[1].color = (
        (0.8, 0.3, 0.05, 1.0),
        (0.1, 0.4, 0.1, 1.0),
    )
    tree.link(noise.outputs["Fac"], ramp.inputs[0]).link(ramp.outputs[0], tree.shader.inputs["Base Color"])
    tree.shader.inputs["Specular IOR Level"].default_value = 0.0
    shaded("floor", tree)
    scenes.sun(scene)


def baked_group(scene):
    """A Principled BSDF within a group keeps its shine."""
    tree = Tree()
    group = bpy.data.node_groups.new("leaf", "ShaderNodeTree")
    group.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    inner = {name: group.nodes.new(f"ShaderNode{name}") for name in ("BsdfPrincipled", "TexNoise")}
    end = group.nodes.new("NodeGroupOutput")
    group.links.new(inner["TexNoise"].outputs["Color"], inner["BsdfPrincipled"].inputs["Base Color"])
    group.links.new(inner["BsdfPrincipled"].outputs[0], end.inputs[0])
    node = tree.node("Group")
    node.node_tree = group
    tree.link(node.outputs[0], tree.output.inputs["Surface"])
    shaded("floor", tree)
    scenes.sun(scene)


def bumps(scene):
    tree = Tree()
    noise, bump = tree.node("TexNoise"), tree.node("Bump")
    noise.inputs["Scale"].default_value, bump.inputs["Distance"].default_value = 3.0, 0.3
    tree.link(noise.outputs["Fac"], bump.inputs["Height"]).link(bump.outputs[0], tree.shader.inputs["Normal"])
    tree.shader.inputs["Specular IOR Level"].default_value = 0.0
    shaded("floor", tree)
    scenes.sun(scene)


def translucent_leaf(scene):
    tree = Tree()
    front, back = tree.node("BsdfDiffuse"), tree.node("BsdfTranslucent")
    front.inputs["Color"].default_value, back.inputs["Color"].default_value = (
        (0.2, 0.5, 0.1, 1.0),
        (0.6, 0.8, 0.2, 1.0),
    )
    tree.mixed(0.4, front, back)
    shaded("wall", tree)
    scenes.sun(scene, towards=(0.2, -0.8, -0.6))


def alpha_mask(scene):
    tree = masked(scene)
    cut = tree.node("Math", operation="GREATER_THAN")
    cut.inputs[1].default_value = 0.5
    tree.link(tree.picture.outputs["Alpha"], cut.inputs[0]).link(cut.outputs[0], tree.shader.inputs["Alpha"])


def alpha_blend(scene):
    tree = masked(scene)
    tree.link(tree.picture.outputs["Alpha"], tree.shader.inputs["Alpha"])


def masked(scene):
    """A larger card with a picture of a disc in its alpha."""
    size = 64
    image = bpy.data.images.new("disc", size, size, alpha=True)
    pixels = numpy.ones((size, size, 4), "f4")
    across, up = numpy.meshgrid(*2 * [numpy.linspace(-1.0, 1.0, size)])
    pixels[..., :3] = 0.5
    pixels[..., 3] = numpy.clip(1.5 - 1.3 * numpy.hypot(across, up), 0.0, 1.0)
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    tree = Tree()
    tree.picture = tree.node("TexImage", image=image)
    tree.link(tree.picture.outputs["Color"], tree.shader.inputs["Base Color"])
    tree.shader.inputs["Specular IOR Level"].default_value = 0.0
    shaded("card", tree).scale = (2.5, 2.5, 1.0)
    scenes.sun(scene)
    return tree


def glowing(scene):
    """Alone, as without bounces what glows lights nothing here; in Cycles it does."""
    for name in ("floor", "wall"):
        bpy.data.objects[name].hide_render = True
    bpy.data.objects["card"].rotation_euler.x = math.radians(60.0)
    shader = bpy.data.materials["card"].node_tree.nodes["Principled BSDF"]
    shader.inputs["Emission Color"].default_value, shader.inputs["Emission Strength"].default_value = (
        (1.0, 0.4, 0.1, 1.0),
        3.0,
    )
    scenes.sun(scene)
