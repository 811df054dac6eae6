"""Small scenes to be rendered beside Cycles, each of one kind, by name; builders return the frame to render."""

import math

import bpy
import leaf_scenes
import numpy
import scenes
import stages
from test_materials import Tree

SIZE = (96, 54)


def stage():
    """A floor, a wall that leans, and a card above the floor to throw a shadow; all matte."""
    scene = scenes.empty(stages.FRAMES, SIZE)
    scenes.camera(scene)
    scenes.quad(scene, "floor", 8.0, scenes.material("floor", (0.6, 0.5, 0.4)))
    wall = scenes.quad(scene, "wall", 6.0, scenes.material("wall", (0.3, 0.5, 0.7)), (0.0, 3.0, 1.0))
    wall.rotation_euler = (math.radians(80.0), 0.0, 0.0)
    scenes.quad(scene, "card", 0.8, scenes.material("card", (0.7, 0.2, 0.1)), (0.3, 0.2, 0.9))
    return scene


def lamp(scene, kind, **values):
    data = bpy.data.lights.new(kind.lower(), kind)
    for name, value in values.items():
        setattr(data, name, value)
    made = scenes.add(scene, kind.lower(), data, (1.2, -0.8, 2.2), (0.0, 0.6, 0.2))
    made.visible_camera = False
    return made


def world(scene, color=(0.3, 0.5, 0.9), strength=0.8):
    made = scene.world = bpy.data.worlds.new("world")
    made.use_nodes = True
    shader = next(node for node in made.node_tree.nodes if node.type == "BACKGROUND")
    shader.inputs["Color"].default_value, shader.inputs["Strength"].default_value = (*color, 1.0), strength
    return made.node_tree, shader


def with_uv(thing):
    thing.data.uv_layers.new(name="UVMap").uv.foreach_set("vector", numpy.array([0, 0, 1, 0, 1, 1, 0, 1], "f4"))
    return thing


def shaded(name, tree):
    """The floor or the wall, with a material."""
    thing = with_uv(bpy.data.objects[name])
    thing.data.materials[0] = tree.material
    return thing


# Lights.


def sun_disc(scene):
    scenes.sun(scene, angle=math.radians(10.0))


def point(scene):
    lamp(scene, "POINT", energy=100.0, shadow_soft_size=0.0)


def sphere(scene):
    lamp(scene, "POINT", energy=100.0, shadow_soft_size=0.2, use_soft_falloff=False)


def spot(scene):
    lamp(scene, "SPOT", energy=300.0, shadow_soft_size=0.0, spot_size=math.radians(70.0), spot_blend=0.4)


def area(scene):
    lamp(scene, "AREA", energy=60.0, shape="RECTANGLE", size=0.8, size_y=0.4)


def warm_sun(scene):
    """Colour temperature and exposure."""
    data = scenes.sun(scene).data
    data.use_temperature, data.temperature, data.exposure = True, 3200.0, 1.0


def world_colour(scene):
    world(scene)


def world_image(scene):
    tree, shader = world(scene)
    image = bpy.data.images.new("sky", 32, 16, float_buffer=True)
    across, up = numpy.meshgrid(numpy.linspace(0.0, 1.0, 32), numpy.linspace(0.0, 1.0, 16))
    image.pixels.foreach_set(numpy.stack([across, up, 1.0 - 0.5 * across, numpy.ones_like(up)], -1).astype("f4").ravel())
    image.pack()
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = image
    tree.links.new(texture.outputs[0], shader.inputs["Color"])


def world_of_nodes(scene):
    tree, shader = world(scene)
    coordinates, ramp = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeTexGradient")
    tree.links.new(coordinates.outputs["Generated"], ramp.inputs[0])
    tree.links.new(ramp.outputs[0], shader.inputs["Color"])


# Materials.


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


def coloured_metal(scene):
    shader = bpy.data.materials["floor"].node_tree.nodes["Principled BSDF"]
    shader.inputs["Metallic"].default_value, shader.inputs["Roughness"].default_value = 1.0, 0.6
    scenes.sun(scene, towards=(0.0, 0.6, -1.0))


def waves(name, size=64):
    """A picture without edges: between texels Cycles mixes what sRGB encodes, and glTF what it stands for."""
    image = bpy.data.images.new(name, size, size)
    across, up = numpy.meshgrid(*2 * [0.5 + 0.4 * numpy.sin(numpy.arange(size) * math.tau / size)])
    image.pixels.foreach_set(numpy.stack([across, up, 1.0 - across, numpy.ones_like(up)], -1).astype("f4").ravel())
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
        tree.link(mapping.outputs[0], picture.inputs["Vector"]).link(picture.outputs["Color"], tree.shader.inputs[socket])
    picture.image.colorspace_settings.name = "Non-Color"
    bumps = bpy.data.images.new("bumps", 16, 16)
    bumps.colorspace_settings.name = "Non-Color"
    slopes = 0.5 + 0.2 * numpy.sin(numpy.arange(16) * math.tau / 16)
    pixels = numpy.ones((16, 16, 4), "f4")
    pixels[..., 0], pixels[..., 1] = slopes[None], slopes[:, None]
    bumps.pixels.foreach_set(pixels.ravel())
    bumps.pack()
    bent, bends = tree.node("TexImage", image=bumps), tree.node("NormalMap", uv_map="UVMap")
    tree.link(bent.outputs["Color"], bends.inputs["Color"]).link(bends.outputs[0], tree.shader.inputs["Normal"])
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
    ramp.color_ramp.elements[0].color, ramp.color_ramp.elements[1].color = (0.8, 0.1, 0.0, 1.0), (0.1, 0.6, 0.1, 1.0)
    tree.link(info.outputs["Random"], ramp.inputs[0]).link(ramp.outputs[0], tree.shader.inputs["Base Color"])
    tree.shader.inputs["Specular IOR Level"].default_value = 0.0


def random_colours(scene):
    tree = Tree()
    coloured_by_chance(tree)
    for number in range(24):
        scenes.quad(scene, f"leaf {number}", 0.4, tree.material, (0.5 * (number % 8) - 1.7, 0.5 * (number // 8), 0.3 + 0.1 * number % 1.0))
    scenes.sun(scene)


def baked_nodes(scene):
    tree = Tree()
    noise, ramp = tree.node("TexNoise"), tree.node("ValToRGB")
    noise.inputs["Scale"].default_value = 3.0
    ramp.color_ramp.elements[0].color, ramp.color_ramp.elements[1].color = (0.8, 0.3, 0.05, 1.0), (0.1, 0.4, 0.1, 1.0)
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
    front.inputs["Color"].default_value, back.inputs["Color"].default_value = (0.2, 0.5, 0.1, 1.0), (0.6, 0.8, 0.2, 1.0)
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
    shader.inputs["Emission Color"].default_value, shader.inputs["Emission Strength"].default_value = (1.0, 0.4, 0.1, 1.0), 3.0
    scenes.sun(scene)


# Things.


def above_the_floor(scene, build):
    """What stands at the height of 0 would lie within the floor."""
    bpy.data.objects["floor"].location.z = -0.6
    build(scene)


def hidden_things(scene):
    """Excluded, hidden, nested and instanced collections, and things that are hidden in the viewport alone."""
    stages.collections(scene)
    scenes.quad(scene, "not seen", 2.0, None, (0.0, -1.0, 1.0)).hide_render = True
    bpy.data.objects["card"].hide_viewport = True
    scenes.sun(scene)


def hair(scene):
    """In the colours of a picture, by the texture coordinates of its roots."""
    tree = Tree()
    tree.link(tree.node("TexImage", image=waves("colour")).outputs["Color"], tree.shader.inputs["Base Color"])
    tree.shader.inputs["Specular IOR Level"].default_value = 0.0
    emitter = shaded("card", tree)
    settings = emitter.modifiers.new("hair", "PARTICLE_SYSTEM").particle_system.settings
    settings.type, settings.count, settings.hair_length, settings.hair_step = "HAIR", 200, 0.8, 4
    settings.child_type, settings.rendered_child_count = "INTERPOLATED", 3
    settings.root_radius, settings.tip_radius, settings.radius_scale = 1.0, 0.5, 0.05
    scenes.sun(scene)


def words_curves_and_balls(scene):
    above_the_floor(scene, stages.words_curves_and_balls)
    scenes.sun(scene)
    return 4


def shape_keys(scene):
    above_the_floor(scene, stages.shape_keys_and_modifiers)
    scenes.sun(scene)
    return 5


def armature(scene):
    above_the_floor(scene, stages.skeleton)
    scenes.sun(scene)
    return 5


def instances_on_faces(scene):
    above_the_floor(scene, stages.on_faces_and_vertices)
    scenes.sun(scene)
    return 3


def smooth_normals(scene):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=12, ring_count=6, radius=0.7, location=(-0.8, 0.0, 0.9))
    bpy.ops.object.shade_smooth()
    bpy.context.object.data.materials.append(bpy.data.materials["card"])
    scenes.sun(scene)


# Pictures.


def camera_markers(scene):
    scenes.sun(scene)
    first = scene.camera
    second = scenes.camera(scene, (3.0, -4.0, 3.0))
    scene.camera = first
    for frame, camera in ((1, first), (4, second)):
        scene.timeline_markers.new(str(frame), frame=frame).camera = camera
    return 5


def border(scene):
    """Of a size and with edges that are not whole pixels."""
    scenes.sun(scene)
    render = scene.render
    render.resolution_x, render.resolution_y = SIZE[0] + 1, SIZE[1] + 1
    render.use_border = render.use_crop_to_border = True
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.31, 0.77, 0.13, 0.61


def pixel_aspect(scene):
    scenes.sun(scene)
    scene.render.pixel_aspect_x = 2.0


def orthographic(scene):
    scenes.sun(scene)
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 5.0


def shifted_lens(scene):
    scenes.sun(scene)
    scene.camera.data.shift_x, scene.camera.data.shift_y = 0.12, -0.08


def depth_of_field(scene):
    scenes.sun(scene)
    focus = scene.camera.data.dof
    focus.use_dof, focus.focus_distance, focus.aperture_fstop = True, 4.0, 0.2


def motion_blur(scene):
    scenes.sun(scene)
    card = bpy.data.objects["card"]
    stages.key(card, "rotation_euler", ((0.0, 0.0, 0.0), (1.0, 2.0, 4.0)), (1, 5))
    stages.key(card, "location", ((-1.0, 0.0, 0.9), (2.0, 0.0, 0.9)), (1, 5))
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0
    return 3


def fog_box(scene):
    """A cube that is fog to Cycles by its material and to sunfleck by its setting."""
    bpy.ops.mesh.primitive_cube_add(location=(0.0, 0.5, 1.3))
    box = bpy.context.object
    box.scale = (3.0, 2.2, 1.25)
    shade = bpy.data.materials.new("fog")
    shade.use_nodes = True
    nodes = shade.node_tree.nodes
    nodes.clear()
    scatter, out = nodes.new("ShaderNodeVolumeScatter"), nodes.new("ShaderNodeOutputMaterial")
    scatter.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    scatter.inputs["Density"].default_value, scatter.inputs["Anisotropy"].default_value = 0.15, 0.4
    shade.node_tree.links.new(scatter.outputs[0], out.inputs["Volume"])
    box.data.materials.append(shade)
    own = box.sunfleck_settings
    own.is_fog, own.density, own.anisotropy = True, 0.15, 0.4
    scenes.sun(scene)


def leaves(name):
    def build():
        scene = leaf_scenes.build(name)
        scene.render.resolution_x, scene.render.resolution_y = SIZE
        return scene, 12

    return build


def on_stage(build):
    def built():
        scene = stage()
        frame = build(scene)
        return scene, frame if isinstance(frame, int) else 1

    return built


EXACT = (
    scenes.sun, sun_disc, point, sphere, spot, area, warm_sun, world_colour, world_image, default_principled, rough_principled, smooth_principled,
    coloured_metal, textures, colour_attributes, random_colours, translucent_leaf, alpha_mask, alpha_blend, glowing, hidden_things, hair,
    words_curves_and_balls, shape_keys, armature, instances_on_faces, smooth_normals, camera_markers, border, pixel_aspect, orthographic,
    shifted_lens, depth_of_field, motion_blur, fog_box,
)
BAKED = (world_of_nodes, baked_nodes, baked_group, bumps)
EXACT_BAR, BAKED_BAR = 0.005, 0.02
# What builds a scene, and how far its mean may be from that of Cycles.
SCENES = {
    **{f"leaves, {name}": (leaves(name), EXACT_BAR) for name in leaf_scenes.SCENES},
    **{build.__name__.replace("_", " "): (on_stage(build), EXACT_BAR) for build in EXACT},
    **{build.__name__.replace("_", " "): (on_stage(build), BAKED_BAR) for build in BAKED},
}
