"""Of the scenes of `kinds` those of materials and fog."""

import math
from pathlib import Path

import bpy
import numpy
import scenes
from kinds_parts import GREEN, RED, between, group_of, keyed, leaves, matte, output
from leaf_scenes import Tree as Nodes
from test_materials import Tree


def thin_wall(scene):
    tree = matte()
    inputs = tree.shader.inputs
    inputs["Base Color"].default_value, inputs["Thin Wall"].default_value = GREEN, True
    inputs["Subsurface Weight"].default_value, inputs["Subsurface Anisotropy"].default_value = 0.8, 0.3
    leaves(scene, tree)


def thin_wall_of_a_texture(scene):
    """How much is scattered through differs from place to place."""
    thin_wall(scene)
    tree = bpy.data.materials["shade"].node_tree
    weight = tree.nodes["Principled BSDF"].inputs["Subsurface Weight"]
    tree.links.new(output(tree.nodes.new("ShaderNodeTexNoise"), "Factor", "Fac"), weight)


def thin_metal(scene):
    thin_wall(scene)
    shader = bpy.data.materials["shade"].node_tree.nodes["Principled BSDF"]
    shader.inputs["Metallic"].default_value = 0.5


def thin_metal_in_colours(scene):
    thin_metal(scene)
    tree = bpy.data.materials["shade"].node_tree
    base = tree.nodes["Principled BSDF"].inputs["Base Color"]
    tree.links.new(tree.nodes.new("ShaderNodeTexChecker").outputs["Color"], base)


def thin_metal_of_a_texture(scene):
    thin_wall_of_a_texture(scene)
    shader = bpy.data.materials["shade"].node_tree.nodes["Principled BSDF"]
    shader.inputs["Metallic"].default_value = 0.5


def frosted(scene, weight=0.6, roughness=0.5):
    """Light goes through a rough thin wall."""
    thin_wall(scene)
    inputs = bpy.data.materials["shade"].node_tree.nodes["Principled BSDF"].inputs
    inputs["Transmission Weight"].default_value, inputs["Roughness"].default_value = weight, roughness
    inputs["Specular IOR Level"].default_value = 0.5


def frosted_before_a_wall(scene):
    """What stands behind shows, blurred, and is lit by what comes through."""
    frosted(scene, 0.9, 0.6)
    wall = scenes.quad(scene, "wall", 6.0, scenes.material("wall", (0.7, 0.4, 0.2)), (0.0, 0.8, 1.0))
    wall.rotation_euler = (1.5, 0.0, 0.0)
    scenes.quad(scene, "floor", 6.0, scenes.material("floor", (0.2, 0.5, 0.7)), (0.0, 0.0, 0.3))


def frosted_metal(scene):
    frosted(scene, 1.0, 0.8)
    bpy.data.materials["shade"].node_tree.nodes["Principled BSDF"].inputs["Metallic"].default_value = 0.3


def sheen(scene):
    tree = matte()
    tree.shader.inputs["Sheen Weight"].default_value = 0.5
    leaves(scene, tree)


def rough_transmission(scene, roughness=0.5):
    """Sheets without a thickness: each is one face, which some show from within."""
    tree = matte()
    inputs = tree.shader.inputs
    inputs["Transmission Weight"].default_value, inputs["Roughness"].default_value = 0.6, roughness
    inputs["Base Color"].default_value, inputs["Specular IOR Level"].default_value = GREEN, 0.5
    for number, leaf in enumerate(leaves(scene, tree)):
        leaf.rotation_euler.x += math.pi * (number % 2)
        leaf.scale.x = -1.0 if number % 3 else 1.0


def textured_transmission(scene):
    rough_transmission(scene)
    tree = bpy.data.materials["shade"].node_tree
    tree.links.new(soft_picture(tree, 1.0).outputs["Color"], tree.nodes["Principled BSDF"].inputs["Base Color"])


def soft_picture(tree, alpha):
    """A picture without edges, whose alpha goes from `alpha` to 1."""
    image = bpy.data.images.new("soft", 64, 64, alpha=True)
    across = numpy.linspace(0.0, 1.0, 64)
    pixels = numpy.ones((64, 64, 4), "f4")
    pixels[..., 0] = 0.5 + 0.4 * numpy.sin(2.0 * math.pi * across)
    pixels[..., 3] = (1.0 - (1.0 - alpha) * numpy.sin(math.pi * across))[:, None]
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    return node


def picture_with_alpha(scene):
    """Nobody asks for its alpha, so Cycles multiplies colours by it."""
    tree = matte()
    tree.link(soft_picture(tree.material.node_tree, 0.2).outputs["Color"], tree.shader.inputs["Base Color"])
    leaves(scene, tree)


def pictures_apart(scene):
    """Colours lie otherwise than alpha, and how much it glows is of a colour."""
    tree = matte()
    colours, alpha = (soft_picture(tree.material.node_tree, low) for low in (1.0, 0.2))
    colours.texture_mapping.scale = (2.0, 2.0, 1.0)
    tree.link(colours.outputs["Color"], tree.shader.inputs["Base Color"])
    tree.link(alpha.outputs["Alpha"], tree.shader.inputs["Alpha"])
    tree.link(alpha.outputs["Color"], tree.shader.inputs["Emission Strength"])
    tree.shader.inputs["Emission Color"].default_value = RED
    leaves(scene, tree, count=1)


def bumps(scene):
    """Heights of a picture by both of their nodes, on leaves of half the size, lit from the side."""
    trees = matte(), matte()
    for tree, kind, length in zip(trees, ("Bump", "Displacement"), ("Distance", "Scale")):
        bent = tree.node(kind)
        bent.inputs[length].default_value = 0.1
        tree.link(soft_picture(tree.material.node_tree, 1.0).outputs["Color"], bent.inputs["Height"])
        end = tree.shader.inputs["Normal"] if kind == "Bump" else tree.output.inputs["Displacement"]
        tree.link(bent.outputs[0], end)
    for number, leaf in enumerate(leaves(scene, trees[0])):
        leaf.data.materials[0], leaf.scale = trees[number % 2].material, (0.5,) * 3
    scene.objects["sun"].rotation_euler = (0.3, 1.3, 0.0)


def coarse_picture(scene, interpolation="Linear", side=8):
    """Between texels of 8 bits Cycles mixes what they are stored as."""
    tree = matte()
    image = bpy.data.images.new("texels", side, side)
    image.pixels.foreach_set(numpy.repeat(numpy.indices((side, side)).sum(0).ravel() % 2, 4).astype("f4"))
    image.pack()
    node = tree.node("TexImage", image=image, interpolation=interpolation)
    tree.link(node.outputs["Color"], tree.shader.inputs["Base Color"])
    leaves(scene, tree)


def muted(scene):
    """Nodes that are switched off: what leads through them counts, else what stands behind."""
    trees = matte(), matte()
    for tree, kind, name in zip(trees, ("HueSaturation", "Gamma"), ("Color", "Gamma")):
        node = tree.node(kind, mute=True)
        node.inputs["Color"].default_value, node.inputs[name].default_value = RED, RED if name == "Color" else 3.0
        tree.link(node.outputs["Color"], tree.shader.inputs["Base Color"])
    through = trees[1].node("RGB")
    through.outputs["Color"].default_value = GREEN
    trees[1].link(through.outputs["Color"], next(node for node in trees[1].nodes if node.mute).inputs["Color"])
    for number, leaf in enumerate(leaves(scene, trees[0])):
        leaf.data.materials[0] = trees[number % 2].material


def decal(scene):
    """Nothing beyond the picture's edges."""
    tree = matte()
    node, place, asked = soft_picture(tree.material.node_tree, 1.0), tree.node("Mapping"), tree.node("TexCoord")
    node.extension = "CLIP"
    place.inputs["Scale"].default_value, place.inputs["Location"].default_value = (1.4, 1.4, 1.0), (-0.3, -0.2, 0.0)
    tree.link(asked.outputs["UV"], place.inputs["Vector"]).link(place.outputs["Vector"], node.inputs["Vector"])
    tree.link(node.outputs["Color"], tree.shader.inputs["Base Color"])
    leaves(scene, tree)


def broadcast(scene):
    """Colours of 8 bits in another curve than sRGB's."""
    tree = matte()
    picture = soft_picture(tree.material.node_tree, 1.0)
    picture.image.colorspace_settings.name = "Rec.1886"
    tree.link(picture.outputs["Color"], tree.shader.inputs["Base Color"])
    leaves(scene, tree)


def film_scan(scene):
    """A Cineon file, whose logarithms Cycles shows as they are."""
    tree = matte()
    picture = soft_picture(tree.material.node_tree, 1.0)
    path = str(Path(bpy.app.tempdir) / "scan.cin")
    settings = scene.render.image_settings
    before, settings.file_format = settings.file_format, "CINEON"
    picture.image.save_render(path, scene=scene)
    settings.file_format, picture.image = before, bpy.data.images.load(path)
    tree.link(picture.outputs["Color"], tree.shader.inputs["Base Color"])
    leaves(scene, tree)


def flattened(scene):
    """Scaled to nothing along what has no thickness."""
    for number, leaf in enumerate(leaves(scene, matte())):
        leaf.scale.z = number % 2


def leaning_normals(scene):
    """As those of cards that are shaded as the crown about them."""
    for leaf in leaves(scene, matte()):
        leaf.data.normals_split_custom_set([(0.8, 0.0, 0.6)] * 4)


def few_faces(scene):
    """A smooth stem of eight sides."""
    bpy.ops.mesh.primitive_cylinder_add(vertices=8, radius=0.3, location=(0.0, 0.0, 1.0))
    bpy.context.active_object.data.shade_smooth()


def emptied(scene):
    """Every other leaf's slot is its own, and nothing is in it: Cycles of 5.0 takes the mesh's there."""
    tree = matte()
    tree.shader.inputs["Base Color"].default_value = RED
    for leaf in leaves(scene, tree)[::2]:
        leaf.material_slots[0].link, leaf.material_slots[0].material = "OBJECT", None


def clay(scene):
    """A view layer's own material on leaves with and without one."""
    tree = matte()
    tree.shader.inputs["Base Color"].default_value = RED
    first, *_ = leaves(scene, tree)
    first.data.materials.clear()
    made = matte()
    made.shader.inputs["Base Color"].default_value = GREEN
    scene.view_layers[0].material_override = made.material


def free_normals(scene):
    """Of points; faces that are flat stay so."""
    leaf = scenes.quad(scene, "leaf", 1.6, matte().material, (0.0, 0.0, 1.0))
    leaf.rotation_euler.x = 1.4
    tree = Nodes(leaf)
    parts, flat, normals, place = (
        tree.node(f"GeometryNode{kind}") for kind in ("SubdivideMesh", "SetShadeSmooth", "SetMeshNormal", "InputPosition")
    )
    parts.inputs["Level"].default_value, normals.mode = 2, "FREE"
    flat.inputs["Shade Smooth"].default_value = False
    tree.link(tree.source.outputs[0], parts.inputs[0])
    tree.link(parts.outputs[0], flat.inputs[0])
    tree.link(tree.random(-1.0, 1.0), flat.inputs["Selection"])
    tree.link(flat.outputs[0], normals.inputs["Mesh"])
    tree.link(place.outputs[0], next(one for one in normals.inputs if one.name == "Custom Normal" and one.enabled))
    tree.link(normals.outputs[0], tree.target.inputs["Geometry"])


def glossy_leaf(scene):
    """As leaves were made before: a picture on what is matte and lets light through, under a little gloss."""
    tree = matte()
    picture = soft_picture(tree.material.node_tree, 1.0)
    diffuse, through, gloss = (tree.node(kind) for kind in ("BsdfDiffuse", "BsdfTranslucent", "BsdfAnisotropic"))
    for shader in (diffuse, through):
        tree.link(picture.outputs["Color"], shader.inputs["Color"])
    gloss.inputs["Roughness"].default_value = 0.3
    tree.mixed(0.4, diffuse, through)
    tree.mixed(0.1, tree.output.inputs["Surface"].links[0].from_node, gloss)
    leaves(scene, tree)


def mixed_by_chance(scene):
    """Each leaf takes its own share of two shaders."""
    tree = matte()
    tree.shader.inputs["Base Color"].default_value = RED
    other = tree.node("BsdfDiffuse")
    other.inputs["Color"].default_value = GREEN
    tree.mixed(tree.node("ObjectInfo").outputs["Random"], tree.shader, other)
    leaves(scene, tree)


def cut_leaf(scene):
    """Clipped by a picture's alpha; a part of it shines, lit and seen at grazing angles."""
    tree = matte()
    image = bpy.data.images.new("cut", 8, 8, alpha=True)
    pixels = numpy.ones((8, 8, 4), "f4")
    pixels[:3, :5, 3] = 0.0
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    picture, above = tree.node("TexImage", image=image), tree.node("Math", operation="GREATER_THAN")
    through, clear, inner, outer = (
        tree.node(kind) for kind in ("BsdfTranslucent", "BsdfTransparent", "MixShader", "MixShader")
    )
    tree.shader.inputs["Specular IOR Level"].default_value, tree.shader.inputs["Roughness"].default_value = 0.2, 0.5
    tree.shader.inputs["Base Color"].default_value = through.inputs["Color"].default_value = GREEN
    inner.inputs[0].default_value = 0.6
    tree.link(picture.outputs["Alpha"], above.inputs[0]).link(above.outputs["Value"], outer.inputs[0])
    for mix, (first, second) in ((inner, (tree.shader, through)), (outer, (clear, inner))):
        tree.link(first.outputs[0], mix.inputs[1]).link(second.outputs[0], mix.inputs[2])
    tree.link(outer.outputs["Shader"], tree.output.inputs["Surface"])
    for leaf in leaves(scene, tree):
        leaf.rotation_euler.x = 0.3
    scene.objects["sun"].rotation_euler = (-1.2, 0.0, 0.0)


def keyed_coat(scene):
    tree = matte()
    keyed(tree.shader.inputs["Coat Weight"], "default_value", (0.0, 1.0))
    leaves(scene, tree)


def scrolled(scene):
    """A picture that moves over the leaves."""
    tree = matte()
    image, place = tree.node("TexImage"), tree.node("Mapping")
    image.image = bpy.data.images.new("picture", 8, 8)
    tree.link(tree.node("TexCoord").outputs["UV"], place.inputs["Vector"]).link(place.outputs["Vector"], image.inputs["Vector"])
    tree.link(image.outputs["Color"], tree.shader.inputs["Base Color"])
    keyed(place.inputs["Location"], "default_value", ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)))
    leaves(scene, tree)


def two_sided(scene):
    """Every other leaf shows its back."""
    tree = matte()
    for leaf in leaves(scene, between(tree, tree.node("NewGeometry").outputs["Backfacing"]))[::2]:
        leaf.rotation_euler.x += math.pi


def two_sided_by_shaders(scene):
    """The front of each leaf has a colour of its own."""
    tree = matte()
    other = tree.node("BsdfDiffuse")
    other.inputs["Color"].default_value = GREEN
    between(tree, tree.node("ObjectInfo").outputs["Random"])
    tree.mixed(tree.node("NewGeometry").outputs["Backfacing"], tree.shader, other)
    for leaf in leaves(scene, tree)[::2]:
        leaf.rotation_euler.x += math.pi


def two_sided_and_transparent(scene):
    tree = between(tree := matte(), tree.node("NewGeometry").outputs["Backfacing"])
    tree.shader.inputs["Alpha"].default_value = 0.6
    leaves(scene, tree)


def two_sided_and_translucent(scene):
    tree = matte()
    glow = tree.node("BsdfTranslucent")
    between(tree, tree.node("NewGeometry").outputs["Backfacing"])
    tree.mixed(0.4, tree.shader, glow)
    leaves(scene, tree)


def window(scene):
    tree = matte()
    tree.link(tree.node("TexCoord").outputs["Window"], tree.shader.inputs["Base Color"])
    leaves(scene, tree)


def added_translucence(scene):
    tree = matte()
    image, glow, sum_of = tree.node("TexVoronoi"), tree.node("BsdfTranslucent"), tree.node("AddShader")
    for socket in (tree.shader.inputs["Base Color"], glow.inputs["Color"]):
        tree.link(image.outputs["Color"], socket)
    first, second = sum_of.inputs
    tree.link(tree.shader.outputs["BSDF"], first).link(glow.outputs["BSDF"], second)
    tree.link(sum_of.outputs["Shader"], tree.output.inputs["Surface"])
    leaves(scene, tree)


def light_info(scene):
    tree = matte()
    tree.link(tree.node("LightInfo").outputs["Color"], tree.shader.inputs["Base Color"])
    leaves(scene, tree)


def hues(scene):
    tree = matte()
    hue = tree.node("HueSaturation")
    tree.link(tree.node("ObjectInfo").outputs["Random"], hue.inputs["Hue"])
    tree.link(tree.node("TexChecker").outputs["Color"], hue.inputs["Color"])
    tree.link(hue.outputs["Color"], tree.shader.inputs["Base Color"])
    leaves(scene, tree, 20)


# Fog.


def fog_box(scene, **rays):
    """Of its own material; the panel says something else."""
    scenes.quad(scene, "ground", 12.0, scenes.material("ground", (0.5,) * 3))
    bpy.ops.mesh.primitive_cube_add(size=2.0, location=(0.0, 1.0, 1.05))
    box = bpy.context.active_object
    box.scale = (2.0, 2.0, 1.0)
    tree = Tree("fog")
    tree.nodes.remove(tree.shader)
    scatter = tree.node("VolumeScatter")
    scatter.inputs["Color"].default_value, scatter.inputs["Anisotropy"].default_value = (1.0, 0.6, 0.3, 1.0), 0.7
    keyed(scatter.inputs["Density"], "default_value", (0.1, 0.6))
    tree.link(scatter.outputs["Volume"], tree.output.inputs["Volume"])
    box.data.materials.append(tree.material)
    box.sunfleck_settings.is_fog = True
    for name, value in rays.items():
        setattr(box, name, value)
    return tree, scatter


def world_of_fog(scene):
    """A world that is full of it swallows its own light; lamps are seen."""
    leaves(scene, matte())
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    tree = scene.world.node_tree
    scatter = tree.nodes.new("ShaderNodeVolumeScatter")
    scatter.inputs["Color"].default_value, scatter.inputs["Anisotropy"].default_value = (1.0, 0.6, 0.3, 1.0), 0.2
    scatter.inputs["Density"].default_value = 0.03
    tree.links.new(scatter.outputs[0], tree.nodes["World Output"].inputs["Volume"])
    light = bpy.data.lights.new("lamp", "POINT")
    light.energy, light.shadow_soft_size = 200.0, 0.1
    scenes.add(scene, "lamp", light, (0.5, -3.0, 3.0))


def fog_in_a_group(scene):
    tree, scatter = fog_box(scene)
    node = group_of(tree.material.node_tree, "ShaderNodeVolumeScatter", Density=0.3)
    tree.link(node.outputs["out"], tree.output.inputs["Volume"])


def fog_about_the_camera(scene):
    fog_box(scene)
    scene.camera.location.y, scene.camera.data.clip_start = 0.0, 0.1


def fog_on_the_ground(scene):
    """Its lower side lies in it."""
    fog_box(scene)
    bpy.context.active_object.location.z = 1.0


def two_fogs(scene, offset=(1.0, 0.1, 0.1)):
    """The other one scatters backwards, and in blue."""
    fog_box(scene)
    one = bpy.context.active_object
    other = scenes.add(scene, "other", one.data.copy(), [sum(axis) for axis in zip(one.location, offset)])
    other.scale, other.sunfleck_settings.is_fog = one.scale, True
    other.data.materials[0] = one.data.materials[0].copy()
    scatter = next(node for node in other.data.materials[0].node_tree.nodes if node.type == "VOLUME_SCATTER")
    scatter.inputs["Color"].default_value, scatter.inputs["Anisotropy"].default_value = (0.1, 0.3, 1.0, 1.0), -0.3


def fog_of_noise(scene):
    tree, scatter = fog_box(scene)
    tree.link(output(tree.node("TexNoise"), "Factor", "Fac"), scatter.inputs["Density"])
