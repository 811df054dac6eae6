"""Of the scenes of `kinds` those of what nodes make of numbers, colours and coordinates: a leaf for each."""

import math

import bpy
import numpy
import scenes
from kinds_parts import GREEN, RED, keyed, leaves, matte, output
from kinds_surfaces import soft_picture
from leaf_scenes import Tree as Nodes


def named(sockets, name):
    """Of a node whose kinds of data have sockets of the same name."""
    return next(socket for socket in sockets if socket.enabled and socket.name == name)


def picture(tree, **values):
    """Dark, with an alpha from .2 to 1 that nobody asks for."""
    node = soft_picture(tree.material.node_tree, 0.2)
    for name, value in values.items():
        setattr(node, name, value)
    return node


def each(scene, trees):
    for leaf, tree in zip(leaves(scene, trees[0], len(trees)), trees):
        leaf.data.materials[0] = tree.material


def math_of(tree, source, operation, value):
    node = tree.node("Math", operation=operation)
    node.inputs[1].default_value = value
    tree.link(source, node.inputs[0])
    return node.outputs["Value"]


def mix_of(tree, kind, source=None, **values):
    """Of two constants, or of a picture and one."""
    node = tree.node("Mix", data_type=kind, **values)
    is_color = kind == "RGBA"
    named(node.inputs, "Factor").default_value = 1.0
    named(node.inputs, "A").default_value = (0.5, 0.3, 0.2, 1.0) if is_color else 0.5
    if source is None:
        named(node.inputs, "Factor").default_value = 1.6
        named(node.inputs, "B").default_value = (0.7, 0.2, 0.1, 1.0) if is_color else 0.7
    else:
        tree.link(source, named(node.inputs, "B"))
    return named(node.outputs, "Result")


def numbers_of_colours(scene):
    """At a number's socket they are brightness; factors of mixtures go beyond 1, results end there."""
    trees = [matte() for _ in range(5)]
    made = (
        math_of(trees[0], picture(trees[0]).outputs["Color"], "MULTIPLY", 0.7),
        mix_of(trees[1], "FLOAT", picture(trees[1]).outputs["Color"]),
        mix_of(trees[2], "RGBA", clamp_factor=False),
        mix_of(trees[3], "RGBA", picture(trees[3]).outputs["Color"], blend_type="MULTIPLY", clamp_result=True),
        mix_of(trees[4], "FLOAT", clamp_factor=False),
    )
    for tree, color in zip(trees, made):
        tree.link(color, tree.shader.inputs["Base Color"])
    each(scene, trees)


def beyond_one(scene):
    """What pictures are multiplied by; one that its own panel moves, and that is smooth otherwise."""
    metal, cut, moved = matte(), matte(), matte()
    for tree, names in ((metal, ("Roughness", "Metallic")), (cut, ("Alpha",))):
        node = picture(tree)
        node.image.alpha_mode = "NONE"
        for name in names:
            tree.link(math_of(tree, node.outputs["Color"], "MULTIPLY", 1.7), tree.shader.inputs[name])
    coarse = moved.node("TexImage", interpolation="Smart")
    coarse.image = bpy.data.images.new("coarse", 6, 6)
    coarse.image.pixels.foreach_set(0.8 * numpy.repeat(numpy.indices((6, 6)).sum(0).ravel() % 2, 4).astype("f4"))
    coarse.texture_mapping.scale, coarse.texture_mapping.translation = (2.0, 0.5, 1.0), (0.2, 0.1, 0.0)
    moved.link(coarse.outputs["Color"], moved.shader.inputs["Base Color"])
    each(scene, [metal, metal, cut, moved, moved])


def chequered(name="Generated"):
    tree = matte()
    checks = tree.node("TexChecker")
    checks.inputs["Scale"].default_value = 4.0
    tree.link(tree.node("TexCoord").outputs[name], checks.inputs["Vector"])
    tree.link(checks.outputs["Color"], tree.shader.inputs["Base Color"])
    return tree


def generated(scene):
    """Coordinates of a mesh before it is bent and made finer, and in a texture space of its own."""
    tree = chequered()
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=10, y_subdivisions=10, size=1.6, location=(-0.8, 0.0, 1.0), rotation=(1.4, 0.0, 0.0))
    bent = bpy.context.object
    bent.data.materials.append(tree.material)
    bend = bent.modifiers.new("bend", "SIMPLE_DEFORM")
    bend.deform_method, bend.angle, bend.deform_axis = "BEND", 1.5, "Z"
    bent.modifiers.new("finer", "SUBSURF").render_levels = 1
    leaf = leaves(scene, tree, 1)[0]
    leaf.location.x, leaf.data.use_auto_texspace = 1.2, False
    leaf.data.texspace_size, leaf.data.texspace_location = (2.0, 2.0, 1.0), (0.4, 0.0, 0.0)


def of_what_bends(scene):
    """Coordinates of the object on a shape that changes."""
    leaf = leaves(scene, chequered("Object"), 1)[0]
    leaf.shape_key_add(name="rest")
    key = leaf.shape_key_add(name="narrow")
    for point in key.data:
        point.co.x *= 0.6
    keyed(key, "value", (0.0, 1.0))


def shining_colour(scene):
    """In a shader's place."""
    tree = matte()
    tree.link(picture(tree).outputs["Color"], tree.output.inputs["Surface"])
    leaves(scene, tree, 1)


def half_mixed(scene):
    """With nothing, which is black; gloss added to what is matte; a leaf that shines and lets light through."""
    trees = matte(), matte(), matte()
    mix, add, gloss = trees[0].node("MixShader"), trees[1].node("AddShader"), trees[1].node("BsdfAnisotropic")
    trees[0].link(trees[0].shader.outputs["BSDF"], mix.inputs[2]).link(mix.outputs[0], trees[0].output.inputs["Surface"])
    gloss.inputs["Color"].default_value, gloss.inputs["Roughness"].default_value = (0.2, 0.2, 0.2, 1.0), 0.25
    trees[1].link(trees[1].shader.outputs["BSDF"], add.inputs[0]).link(gloss.outputs["BSDF"], add.inputs[1])
    trees[1].link(add.outputs[0], trees[1].output.inputs["Surface"])
    through = trees[2].node("BsdfTranslucent")
    trees[2].shader.inputs["Specular IOR Level"].default_value, trees[2].shader.inputs["Roughness"].default_value = 0.5, 0.4
    trees[2].shader.inputs["Base Color"].default_value = through.inputs["Color"].default_value = GREEN
    trees[2].mixed(0.4, trees[2].shader, through)
    each(scene, trees)
    scene.objects["sun"].rotation_euler = (0.9, 0.1, 0.0)


def two_shines(scene):
    """A mask of noise tells two surfaces apart."""
    tree = matte()
    other = tree.node("BsdfPrincipled")
    other.inputs["Base Color"].default_value, other.inputs["Roughness"].default_value = GREEN, 0.3
    tree.mixed(output(tree.node("TexNoise"), "Factor", "Fac"), tree.shader, other)
    leaves(scene, tree)


def one_scattering(scene):
    tree = matte()
    tree.shader.distribution, tree.shader.inputs["Metallic"].default_value = "GGX", 1.0
    leaves(scene, tree)


def bent_elsewhere(scene):
    """A normal map in one set of coordinates, along the axes of another."""
    tree = matte()
    bends, place = tree.node("NormalMap"), tree.node("UVMap", uv_map="turned")
    image = picture(tree)
    tree.link(place.outputs["UV"], image.inputs["Vector"]).link(image.outputs["Color"], bends.inputs["Color"])
    tree.link(bends.outputs["Normal"], tree.shader.inputs["Normal"])
    for leaf in leaves(scene, tree):
        turned = leaf.data.uv_layers.new(name="turned")
        turned.uv.foreach_set("vector", numpy.array([1, 0, 1, 1, 0, 1, 0, 0], "f4"))


# What is open, and for how long.


def open_while_it_changes(scene):
    """Cycles has colours and glow as they are at the frame."""
    tree = matte()
    keyed(tree.shader.inputs["Base Color"], "default_value", (RED, GREEN))
    keyed(tree.shader.inputs["Emission Strength"], "default_value", (0.1, 3.0))
    leaves(scene, tree, 1)
    render = scene.render
    render.use_motion_blur, render.motion_blur_shutter, render.motion_blur_position = True, 1.0, "START"


def open_while_light_changes(scene):
    """Cycles has it as it is in the middle."""
    leaves(scene, matte())
    keyed(scene.objects["sun"].data, "energy", (1.0, 90.0))
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0


def moving_lamp(scene):
    leaves(scene, matte())
    keyed(scene.objects["sun"], "rotation_euler", ((0.3, 0.0, 0.0), (1.5, 1.0, 0.0)))
    scene.render.use_motion_blur = True


def swung(scene):
    """Leaves on an arm that turns, while the sun does: straight in Cycles, or in so many steps, or not blurred."""
    moving_lamp(scene)
    arm = scenes.add(scene, "arm", None)
    keyed(arm, "rotation_euler", ((0.0, -2.0, 0.0), (0.0, 2.0, 0.0)))
    for number in range(5):
        leaf = scene.objects[f"leaf {number}"]
        leaf.parent, leaf.cycles.motion_steps = arm, 1 + number // 3
        leaf.cycles.use_motion_blur, leaf.cycles.use_deform_motion = number != 1, number != 2
        taper = leaf.modifiers.new("taper", "SIMPLE_DEFORM")
        taper.deform_method = "TAPER"
        keyed(taper, "factor", (-1.0, 2.0))
    scene.render.motion_blur_shutter = 0.9


def swung_late(scene):
    """The shutter opens at the frame."""
    swung(scene)
    scene.render.motion_blur_position = "START"


def lights_for_their_size(scene):
    """A wide sun, a lamp without a size, and an area that has none, which gives no light."""
    leaves(scene, matte())
    sun = scene.objects["sun"].data
    sun.angle, sun.normalize, sun.energy = math.radians(60.0), False, 2.0
    lamp = bpy.data.lights.new("lamp", "POINT")
    lamp.energy, lamp.normalize, lamp.shadow_soft_size, lamp.use_soft_falloff = 10.0, False, 0.0, False
    area = bpy.data.lights.new("area", "AREA")
    area.energy, area.size = 1000.0, 0.0
    for data in (lamp, area):
        scenes.add(scene, data.name, data, (1.0, -2.0, 2.0), (0.0, 0.0, 1.0)).visible_camera = False


def light_of_one_bounce(scene):
    leaves(scene, matte())
    scene.objects["sun"].data.cycles.max_bounces = 1
    scene.sunfleck_settings.bounces = 2


def world_switched_off(scene):
    leaves(scene, matte())
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    background = next(node for node in scene.world.node_tree.nodes if node.type == "BACKGROUND")
    background.inputs["Color"].default_value, background.mute = (1.0,) * 4, True
    scene.sunfleck_settings.use_world = True


def associated(scene):
    """A file of 8 bits whose alpha is in its colours: versions of Cycles differ in what they make of it."""
    tree = matte()
    node = picture(tree)
    node.image.alpha_mode = "PREMUL"
    tree.link(node.outputs["Color"], tree.shader.inputs["Base Color"])
    leaves(scene, tree)


def alpha_asked_for(scene):
    """Whoever asks for alpha changes colours: of 8 bits, and of floats in which alpha is said not to be."""
    trees = [matte() for _ in range(3)]
    for tree, name in zip(trees, ("Roughness", "Alpha", "Roughness")):
        node = picture(tree)
        if tree is trees[2]:
            node.image = bpy.data.images.new("floats", 32, 32, alpha=True, float_buffer=True)
            node.image.pixels.foreach_set(numpy.tile(numpy.linspace(0.1, 0.6, 32, dtype="f4"), 32).repeat(4))
            node.image.alpha_mode = "STRAIGHT"
        tree.link(node.outputs["Color"], tree.shader.inputs["Base Color"])
        tree.link(node.outputs["Alpha"], tree.shader.inputs[name])
    each(scene, trees)


def paths(scene):
    """Several numbers of an object by their path."""
    trees = matte(), matte()
    for tree, path in zip(trees, ("color", "scale")):
        asked = tree.node("Attribute", attribute_type="OBJECT", attribute_name=path)
        tree.link(asked.outputs["Color"], tree.shader.inputs["Base Color"])
    for number, leaf in enumerate(leaves(scene, trees[0])):
        leaf.data.materials[0] = trees[number % 2].material
        leaf.color, leaf.scale = (0.2 * number, 0.5, 0.1, 1.0), (0.8, 0.4, 0.2)


def normals_as_colours(scene):
    """Those are the world's."""
    tree = matte()
    bends = tree.node("Bump")
    tree.link(picture(tree).outputs["Color"], bends.inputs["Height"]).link(bends.outputs["Normal"], tree.shader.inputs["Base Color"])
    leaves(scene, tree)


def uv_of_nodes(scene):
    """A grid whose texture coordinates nodes stored: in Blender 5.0 none of them renders."""
    tree = matte()
    tree.link(picture(tree).outputs["Color"], tree.shader.inputs["Base Color"])
    made = Nodes(leaves(scene, tree, 1)[0])
    grid, store, put = (made.node(f"GeometryNode{kind}") for kind in ("MeshGrid", "StoreNamedAttribute", "SetMaterial"))
    store.data_type, store.domain, put.inputs["Material"].default_value = "FLOAT2", "CORNER", tree.material
    store.inputs["Name"].default_value = "UVMap"
    made.link(grid.outputs["Mesh"], store.inputs["Geometry"])
    made.link(grid.outputs["UV Map"], named(store.inputs, "Value"))
    made.link(store.outputs["Geometry"], put.inputs["Geometry"])
    made.link(put.outputs["Geometry"], made.target.inputs["Geometry"])


def rounded(scene):
    """Rays that look at the thing itself and at nothing about it: edges, and how dark corners are."""
    tree = matte()
    shade = tree.node("AmbientOcclusion", only_local=True)
    shade.inputs["Color"].default_value, shade.inputs["Distance"].default_value = RED, 0.5
    tree.link(tree.node("Bevel").outputs["Normal"], tree.shader.inputs["Normal"])
    tree.link(shade.outputs["Color"], tree.shader.inputs["Base Color"])
    scenes.quad(scene, "ground", 6.0, matte().material)
    bpy.ops.mesh.primitive_torus_add(major_segments=6, minor_segments=4, location=(0.0, 0.0, 0.2))
    bpy.context.active_object.data.materials.append(tree.material)


def lines_of_pixels(scene):
    tree = matte()
    tree.link(tree.node("Wireframe", use_pixel_size=True).outputs[0], tree.shader.inputs["Base Color"])
    leaves(scene, tree, 1)
