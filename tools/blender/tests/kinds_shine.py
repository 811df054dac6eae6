"""Of the scenes of `kinds` those of what shines, in light and views that graze it."""

import math

import bpy
import numpy
from kinds_parts import GREEN, RED, leaves, matte
from kinds_surfaces import soft_picture


def polished(scene, distribution="MULTI_GGX"):
    """A Glossy BSDF reflects as much at grazing angles as along the normal, alone and mixed with what is matte."""
    trees = matte(), matte()
    for tree in trees:
        gloss = tree.node("BsdfAnisotropic")
        gloss.distribution = distribution
        gloss.inputs["Color"].default_value, gloss.inputs["Roughness"].default_value = (0.3, 0.1, 0.05, 1.0), 0.4
        if tree is trees[0]:
            tree.link(gloss.outputs["BSDF"], tree.output.inputs["Surface"])
        else:
            tree.mixed(0.3, tree.shader, gloss)
    for number, leaf in enumerate(leaves(scene, trees[0])):
        leaf.data.materials[0], leaf.rotation_euler = trees[number % 2].material, (0.5 * math.pi, 0.0, 0.0)
    scene.camera.location, scene.camera.rotation_euler = (3.9, -1.0, 1.0), (0.5 * math.pi, 0.0, 1.32)
    scene.objects["sun"].rotation_euler = (0.5 * math.pi, 0.0, -1.2)


def lacquered(scene):
    """A clear coat in light that grazes it."""
    tree = matte()
    tree.shader.inputs["Coat Weight"].default_value, tree.shader.inputs["Coat Roughness"].default_value = 0.9, 0.2
    for leaf in leaves(scene, tree):
        leaf.rotation_euler = (0.5 * math.pi, 0.0, 0.0)
    scene.objects["sun"].rotation_euler = (0.5 * math.pi, 0.0, 1.4)


def hammered(scene, strength=1.0, space="TANGENT"):
    """Metal and varnish whose normal map is so steep that some of it faces away from the camera, or inwards."""
    image = bpy.data.images.new("normals", 64, 64, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    angles = 2.0 * numpy.sin(numpy.arange(64) * math.tau / 64)
    pixels = numpy.full((64, 64, 4), 0.5, "f4")
    pixels[..., 0], pixels[..., 2] = 0.5 + 0.5 * numpy.sin(angles), 0.5 + 0.5 * numpy.cos(angles)
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    trees = matte(), matte()
    for tree, metallic in zip(trees, (1.0, 0.0)):
        inputs = tree.shader.inputs
        inputs["Metallic"].default_value, inputs["Roughness"].default_value = metallic, 0.4
        inputs["Specular IOR Level"].default_value = 0.5
        bends = tree.node("NormalMap")
        bends.inputs["Strength"].default_value, bends.space = strength, space
        tree.link(tree.node("TexImage", image=image).outputs["Color"], bends.inputs["Color"])
        tree.link(bends.outputs["Normal"], inputs["Normal"])
    for number, leaf in enumerate(leaves(scene, trees[0])):
        leaf.data.materials[0] = trees[number % 2].material
    scene.objects["sun"].rotation_euler = (0.3, 1.3, 0.0)


def grazed_leaves(scene, beside="BsdfTranslucent", is_baked=False):
    """A leaf's glaze is on what it reflects, and not on what lies beside: seen nearly along them, from both sides."""
    tree, sun = matte(), bpy.data.objects["sun"]
    through = tree.node(beside)
    tree.shader.inputs["Specular IOR Level"].default_value, tree.shader.inputs["Roughness"].default_value = 0.5, 0.4
    colours = {tree.shader.inputs["Base Color"]: GREEN, through.inputs["Color"]: RED}
    picture = soft_picture(tree.material.node_tree, 1.0)
    for socket, colour in colours.items():
        socket.default_value = colour
        if is_baked:
            hue = tree.node("HueSaturation")
            hue.inputs["Value"].default_value = max(colour)
            tree.link(picture.outputs["Color"], hue.inputs["Color"]).link(hue.outputs["Color"], socket)
    tree.mixed(0.4, tree.shader, through)
    for number, leaf in enumerate(leaves(scene, tree)):
        leaf.rotation_euler, leaf.location.z = (0.0, 0.0, 0.3 * number), 0.4 + 0.3 * number
    sun.rotation_euler = (0.3, 0.2, 0.0)
