"""Small scenes to be rendered beside Cycles, each of one kind, by name; builders return
the frame to render."""

import math

import beside_materials as materials
import bpy
import leaf_scenes
import numpy
import scenes
import stages
from beside_materials import waves
from beside_stage import SIZE, lamp, shaded, stage
from test_materials import Tree


def world(scene, color=(0.3, 0.5, 0.9), strength=0.8):
    made = scene.world = bpy.data.worlds.new("world")
    made.use_nodes = True
    shader = next(node for node in made.node_tree.nodes if node.type == "BACKGROUND")
    shader.inputs["Color"].default_value, shader.inputs["Strength"].default_value = (*color, 1.0), strength
    return made.node_tree, shader


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
    image.pixels.foreach_set(
        numpy.stack([across, up, 1.0 - 0.5 * across, numpy.ones_like(up)], -1).astype("f4").ravel()
    )
    image.pack()
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = image
    tree.links.new(texture.outputs[0], shader.inputs["Color"])


def world_of_nodes(scene):
    tree, shader = world(scene)
    coordinates, ramp = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeTexGradient")
    tree.links.new(coordinates.outputs["Generated"], ramp.inputs[0])
    tree.links.new(ramp.outputs[0], shader.inputs["Color"])


# Things.


def above_the_floor(scene, build):
    """What stands at the height of 0 would lie within the floor."""
    bpy.data.objects["floor"].location.z = -0.6
    build(scene)


def hidden_things(scene):
    """Excluded, hidden, nested and instanced collections, and things that are hidden in
    the viewport alone."""
    stages.collections(scene)
    scenes.quad(scene, "not seen", 2.0, None, (0.0, -1.0, 1.0)).hide_render = True
    bpy.data.objects["card"].hide_viewport = True
    scenes.sun(scene)


def unseen_things(scene):
    """A card that the camera does not see, whose shadow it sees, and another in a collection that is
    indirect only."""
    bpy.data.objects["card"].visible_camera = False
    collection = bpy.data.collections.new("indirect")
    scene.collection.children.link(collection)
    other = scenes.quad(scene, "other", 1.0, bpy.data.materials["card"], (-1.2, 0.0, 0.7))
    scene.collection.objects.unlink(other)
    collection.objects.link(other)
    bpy.context.view_layer.layer_collection.children["indirect"].indirect_only = True
    scenes.sun(scene)


def shadowless_things(scene):
    """Before the sun and a lamp, in fog."""
    bpy.data.objects["card"].visible_shadow = False
    point(scene)
    fog_box(scene)


def holdout(scene):
    bpy.data.objects["card"].is_holdout = True
    fog_box(scene)


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
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = (
        0.31,
        0.77,
        0.13,
        0.61,
    )


def pixel_aspect(scene):
    scenes.sun(scene)
    scene.render.pixel_aspect_x = 2.0


def film_exposure(scene):
    """Of a lamp, a sun and a world, which is seen too."""
    scenes.sun(scene)
    point(scene)
    world(scene)
    scene.cycles.film_exposure = 2.0


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


def fog(scene):
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


def fog_box(scene):
    fog(scene)
    scenes.sun(scene)


def leaves(name):
    def build():
        scene = leaf_scenes.build(name)
        scene.render.resolution_x, scene.render.resolution_y = SIZE
        return scene, 12

    return build


def on_stage(build, size=SIZE):
    def built():
        scene = stage(size)
        frame = build(scene)
        return scene, frame if isinstance(frame, int) else 1

    return built


EXACT = (
    scenes.sun, sun_disc, point, sphere, spot, area, warm_sun, world_colour, world_image, materials.default_principled,
    materials.rough_principled, materials.smooth_principled, materials.like_water, materials.like_smooth_water,
    materials.like_old_files, materials.like_diamond, materials.shinier, materials.coloured_metal, materials.textures, materials.colour_attributes,
    materials.random_colours, materials.translucent_leaf, materials.alpha_mask, materials.alpha_blend, materials.glowing, hidden_things,
    unseen_things, shadowless_things, holdout, hair, words_curves_and_balls, shape_keys, armature, instances_on_faces, smooth_normals, camera_markers, border, pixel_aspect,
    film_exposure, orthographic, shifted_lens, depth_of_field, motion_blur, fog_box,
)
BAKED = (world_of_nodes, materials.baked_nodes, materials.baked_group, materials.bumps)
EXACT_BAR, BAKED_BAR = 0.005, 0.02
# What builds a scene, and how far its mean may be from that of Cycles.
SCENES = {
    **{f"leaves, {name}": (leaves(name), EXACT_BAR) for name in leaf_scenes.SCENES},
    **{build.__name__.replace("_", " "): (on_stage(build), EXACT_BAR) for build in EXACT},
    **{build.__name__.replace("_", " "): (on_stage(build), BAKED_BAR) for build in BAKED},
}
