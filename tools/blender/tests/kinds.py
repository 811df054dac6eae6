"""What artists of today build, a small scene of each kind: to be rendered beside Cycles, or to be said."""

import math

import bpy
import kinds_clear as clear
import kinds_hair as hairs
import kinds_instances as instances
import kinds_lamps as lamps
import kinds_nodes as made
import kinds_shine as shine
import kinds_surfaces as surfaces
import numpy
import scenes
from kinds_parts import GREEN, RED, between, group_of, keyed, leaves, matte, output, stage
from leaf_scenes import Tree as Nodes

# Lights and the sky.


def light_nodes(scene):
    leaves(scene, matte())
    sun = scene.objects["sun"].data
    sun.use_nodes = True
    shader = next(node for node in sun.node_tree.nodes if node.type == "EMISSION")
    shader.inputs["Color"].default_value = (0.2, 0.6, 1.0, 1.0)
    keyed(shader.inputs["Strength"], "default_value", (1.0, 5.0))


def sky_with_a_disc(scene):
    leaves(scene, matte())
    bpy.data.objects.remove(scene.objects["sun"])
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    nodes = scene.world.node_tree.nodes
    background, sky = next(node for node in nodes if node.type == "BACKGROUND"), nodes.new("ShaderNodeTexSky")
    sky.sky_type, sky.sun_disc = "SINGLE_SCATTERING", True
    sky.sun_elevation, sky.sun_rotation = math.radians(35.0), math.radians(200.0)
    scene.world.node_tree.links.new(sky.outputs["Color"], background.inputs["Color"])
    background.inputs["Strength"].default_value = 0.1


# What differs from leaf to leaf, and changes.


def object_colors(scene):
    tree = matte()
    tree.link(tree.node("ObjectInfo").outputs["Color"], tree.shader.inputs["Base Color"])
    for leaf in leaves(scene, tree):
        keyed(leaf, "color", (GREEN, RED))


def properties(scene):
    tree = matte()
    asked = tree.node("Attribute", attribute_type="OBJECT", attribute_name="autumn")
    for leaf in leaves(scene, between(tree, output(asked, "Factor", "Fac"))):
        keyed(leaf, '["autumn"]', (0.0, 1.0))


def seasons(scene):
    tree = matte()
    asked = tree.node("Attribute", attribute_type="VIEW_LAYER", attribute_name="season")
    leaves(scene, between(tree, output(asked, "Factor", "Fac")))
    scene["season"] = 0.9


def path_of_a_property(scene):
    """Of a part of one Cycles knows nothing."""
    tree = matte()
    asked = tree.node("Attribute", attribute_type="OBJECT", attribute_name="location.z")
    leaves(scene, between(tree, output(asked, "Factor", "Fac")))


def places(scene):
    tree = matte()
    apart, span = tree.node("SeparateXYZ"), tree.node("Math", operation="MULTIPLY")
    tree.link(tree.node("ObjectInfo").outputs["Location"], apart.inputs["Vector"])
    tree.link(apart.outputs["Z"], span.inputs[0])
    span.inputs[1].default_value = 0.4
    for leaf in leaves(scene, between(tree, span.outputs["Value"])):
        leaf.location.z = 2.0
        leaf.keyframe_insert("location", frame=1)
        leaf.location.z = 0.5
        leaf.keyframe_insert("location", frame=10)


def shown_by_particles(scene, tree, kind):
    leaf = leaves(scene, tree, 1)[0]
    leaf.location = (0.0, 0.0, -9.0)
    emitter = scenes.quad(scene, "emitter", 3.0, scenes.material("emitter", (0.5,) * 3), (0.0, 0.0, 1.0))
    emitter.data.uv_layers.new(name="UVMap").uv.foreach_set("vector", numpy.array([0, 0, 1, 0, 1, 1, 0, 1], "f4"))
    emitter.rotation_euler = (1.4, 0.0, 0.0)
    settings = emitter.modifiers.new("leaves", "PARTICLE_SYSTEM").particle_system.settings
    settings.type, settings.count = kind, 30
    settings.render_type, settings.instance_object, settings.particle_size = "OBJECT", leaf, 0.8
    if kind == "HAIR":
        settings.use_advanced_hair, settings.hair_length = True, 4.0
        settings.use_rotations, settings.rotation_mode = True, "GLOB_Z"
    else:
        settings.use_rotation_instance = True
        settings.frame_start, settings.frame_end, settings.lifetime = -20, 1, 200
        settings.normal_factor, settings.effector_weights.gravity = 0.1, 0.0
    emitter.show_instancer_for_render = emitter.show_instancer_for_viewport = False


def particles_random(scene):
    tree = matte()
    shown_by_particles(scene, between(tree, tree.node("ParticleInfo").outputs["Random"]), "EMITTER")


def particles_age(scene):
    tree = matte()
    share = tree.node("Math", operation="DIVIDE")
    share.inputs[1].default_value = 30.0
    tree.link(tree.node("ParticleInfo").outputs["Age"], share.inputs[0])
    shown_by_particles(scene, between(tree, share.outputs["Value"]), "EMITTER")


def from_instancer(scene):
    tree = matte()
    asked, apart = tree.node("TexCoord", from_instancer=True), tree.node("SeparateXYZ")
    tree.link(asked.outputs["UV"], apart.inputs["Vector"])
    shown_by_particles(scene, between(tree, apart.outputs["X"]), "HAIR")


# Attributes.


def many_faces(scene, tree, kind, domain):
    """One mesh of five leaves, an attribute of each."""
    corners = numpy.array([(-0.3, 0, -0.3), (0.3, 0, -0.3), (0.3, 0, 0.3), (-0.3, 0, 0.3)])
    places = numpy.concatenate([corners + (0.8 * number - 1.6, 0.0, 1.0) for number in range(5)])
    mesh = bpy.data.meshes.new("leaves")
    mesh.from_pydata(places.tolist(), [], numpy.arange(20).reshape(5, 4).tolist())
    mesh.materials.append(tree.material)
    values = mesh.attributes.new("tone", kind, domain).data
    for index, one in enumerate(values):
        share = index * 5 // len(values) / 4.0
        if kind == "FLOAT":
            one.value = share
        else:
            one.color = [a + share * (b - a) for a, b in zip(RED, GREEN)]
    scenes.add(scene, "leaves", mesh)


def colors_of_faces(scene):
    tree = matte()
    tree.link(tree.node("Attribute", attribute_name="tone").outputs["Color"], tree.shader.inputs["Base Color"])
    many_faces(scene, tree, "FLOAT_COLOR", "FACE")


def numbers_of(domain):
    def build(scene):
        tree = matte()
        asked = tree.node("Attribute", attribute_name="tone")
        many_faces(scene, between(tree, output(asked, "Factor", "Fac")), "FLOAT", domain)

    return build


def vertex_group(scene):
    tree = matte()
    for leaf in leaves(scene, between(tree, output(tree.node("Attribute", attribute_name="tips"), "Factor", "Fac"))):
        group = leaf.vertex_groups.new(name="tips")
        group.add([1, 2], 1.0, "REPLACE")
        group.add([3], 0.3, "REPLACE")


def missing_attribute(scene):
    tree = matte()
    tree.shader.inputs["Emission Strength"].default_value = 0.2
    tree.link(tree.node("Attribute", attribute_name="nothing").outputs["Color"], tree.shader.inputs["Base Color"])
    leaves(scene, tree)


# Keys elsewhere than in actions.


def strips(scene):
    tree = matte()
    tree.shader.inputs["Emission Color"].default_value = RED
    keyed(tree.shader.inputs["Emission Strength"], "default_value", (0.1, 3.0))
    data = tree.material.node_tree.animation_data
    action, slot = data.action, data.action_slot
    strip = data.nla_tracks.new().strips.new("glow", 1, action)
    strip.action_slot = slot
    data.action = None
    # What glows lights others in Cycles, so it is alone.
    leaves(scene, tree, 1)


def grouped(scene):
    """Keys within a group, in another as an input of its own."""
    tree = matte()
    color = group_of(tree.material.node_tree, "ShaderNodeRGB")
    keyed(color.node_tree.nodes["Color"].outputs["Color"], "default_value", (RED, GREEN))
    shader = group_of(tree.material.node_tree, "ShaderNodeBsdfDiffuse", Color=RED)
    tree.link(color.outputs["out"], shader.inputs["Color"])
    tree.link(shader.outputs["out"], tree.output.inputs["Surface"])
    leaves(scene, tree)


def light_in_a_group(scene):
    leaves(scene, matte())
    sun = scene.objects["sun"].data
    sun.use_nodes = True
    node = group_of(sun.node_tree, "ShaderNodeEmission", Strength=1.0)
    keyed(node.inputs["Strength"], "default_value", (1.0, 5.0))
    inner = node.node_tree.nodes
    warm = inner.new("ShaderNodeBlackbody")
    warm.inputs["Temperature"].default_value = 3000.0
    shader = next(one for one in inner if one.type == "EMISSION")
    node.node_tree.links.new(warm.outputs["Color"], shader.inputs["Color"])
    output = next(one for one in sun.node_tree.nodes if one.type == "OUTPUT_LIGHT")
    sun.node_tree.links.new(node.outputs["out"], output.inputs["Surface"])


def world_by_rays(scene, rays="Is Camera Ray"):
    leaves(scene, matte())
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    nodes, links = scene.world.node_tree.nodes, scene.world.node_tree.links
    background = next(node for node in nodes if node.type == "BACKGROUND")
    links.new(nodes.new("ShaderNodeLightPath").outputs[rays], background.inputs["Strength"])
    scene.sunfleck_settings.use_world = True


def two_worlds(scene):
    """The camera sees a gradient, and a mirror what lights the leaves."""
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    nodes, links = scene.world.node_tree.nodes, scene.world.node_tree.links
    light, seen, mix = (nodes.new(f"ShaderNode{kind}") for kind in ("Background", "Background", "MixShader"))
    light.inputs["Color"].default_value, light.inputs["Strength"].default_value = (0.3, 0.6, 1.0, 1.0), 0.7
    links.new(nodes.new("ShaderNodeTexGradient").outputs["Color"], seen.inputs["Color"])
    links.new(nodes.new("ShaderNodeLightPath").outputs["Is Camera Ray"], mix.inputs[0])
    for number, shader in ((1, light), (2, seen)):
        links.new(shader.outputs["Background"], mix.inputs[number])
    links.new(mix.outputs["Shader"], next(one for one in nodes if one.type == "OUTPUT_WORLD").inputs["Surface"])
    mirror = matte()
    mirror.shader.inputs["Metallic"].default_value, mirror.shader.inputs["Roughness"].default_value = 1.0, 0.1
    leaves(scene, matte())[2].data.materials[0] = mirror.material


def world_by_the_window(scene):
    world_by_rays(scene)
    nodes, links = scene.world.node_tree.nodes, scene.world.node_tree.links
    background = next(node for node in nodes if node.type == "BACKGROUND")
    links.remove(background.inputs["Strength"].links[0])
    links.new(nodes.new("ShaderNodeTexCoord").outputs["Window"], background.inputs["Color"])


def keyed_shutter(scene):
    leaves(scene, matte())
    scene.render.use_motion_blur = True
    scene.render.motion_blur_shutter = 0.2
    scene.render.keyframe_insert("motion_blur_shutter", frame=1)


# What moves and what nodes make.


def velocities(scene, position="CENTER"):
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 0.5
    scene.render.motion_blur_position = position
    tree = Nodes(scenes.quad(scene, "row", 0.7, matte().material))
    time, grid, more = (
        tree.node(f"{kind}") for kind in ("GeometryNodeInputSceneTime", "GeometryNodeMeshGrid", "ShaderNodeMath")
    )
    more.operation = "ADD"
    more.inputs[1].default_value = 3.0
    grid.inputs["Size X"].default_value = grid.inputs["Size Y"].default_value = 0.8
    tree.link(time.outputs["Frame"], more.inputs[0])
    tree.link(more.outputs["Value"], grid.inputs["Vertices X"])
    along, place, moved = (
        tree.node(kind) for kind in ("ShaderNodeMath", "ShaderNodeCombineXYZ", "GeometryNodeTransform")
    )
    along.operation, along.inputs[1].default_value = "SUBTRACT", 6.0
    tree.link(time.outputs["Frame"], along.inputs[0])
    tree.link(along.outputs["Value"], place.inputs["X"])
    place.inputs["Z"].default_value, moved.inputs["Rotation"].default_value = 1.0, (1.4, 0.0, 0.0)
    tree.link(grid.outputs["Mesh"], moved.inputs["Geometry"])
    tree.link(place.outputs["Vector"], moved.inputs["Translation"])
    store = tree.node("GeometryNodeStoreNamedAttribute", data_type="FLOAT_VECTOR", domain="POINT")
    store.inputs["Name"].default_value = "velocity"
    next(one for one in store.inputs if one.name == "Value" and one.enabled).default_value = (24.0, 0.0, 0.0)
    tree.link(moved.outputs["Geometry"], store.inputs["Geometry"])
    put_material(tree, store.outputs["Geometry"])


def put_material(tree, geometry):
    made = tree.node("GeometryNodeSetMaterial")
    made.inputs["Material"].default_value = bpy.data.materials["shade"]
    tree.link(geometry, made.inputs["Geometry"])
    tree.link(made.outputs["Geometry"], tree.target.inputs["Geometry"])


def nodes_volume(scene):
    tree = Nodes(scenes.quad(scene, "fog", 1.0, matte().material))
    put_material(tree, tree.node("GeometryNodeVolumeCube").outputs["Volume"])


def nodes_pencil(scene):
    tree = Nodes(scenes.quad(scene, "strokes", 1.0, matte().material))
    circle, strokes = tree.node("GeometryNodeCurvePrimitiveCircle"), tree.node("GeometryNodeCurvesToGreasePencil")
    strokes.inputs["Instances as Layers"].default_value = False
    tree.link(circle.outputs["Curve"], strokes.inputs["Curves"])
    tree.link(strokes.outputs["Grease Pencil"], tree.target.inputs["Geometry"])


def nodes_points(scene):
    tree = Nodes(scenes.quad(scene, "points", 1.0, matte().material))
    put_material(tree, tree.node("GeometryNodePoints").outputs["Geometry"])


def zoom(scene):
    """The shutter is open while the camera zooms in, ever faster."""
    leaves(scene, matte())
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 0.6
    keyed(scene.camera.data, "lens", (20.0, 80.0))


# By name: how it is built, the frame, and how far from Cycles' mean it may be.
BACK = (0.2, -1.0, -0.5)
EXACT, BAKED = 0.005, 0.02
BESIDE = {
    "light nodes": (light_nodes, 6, EXACT), "sky with a disc": (sky_with_a_disc, 1, BAKED),
    "object colours": (object_colors, 10, EXACT), "properties": (properties, 10, EXACT), "seasons": (seasons, 1, EXACT),
    "places": (places, 10, EXACT), "particles, random": (particles_random, 8, EXACT), "particles, age": (particles_age, 8, EXACT),
    "from instancer": (from_instancer, 1, EXACT), "tints": (instances.tints, 1, EXACT), "colours of faces": (colors_of_faces, 1, EXACT),
    "numbers of points": (numbers_of("POINT"), 1, BAKED), "numbers of faces": (numbers_of("FACE"), 1, BAKED),
    "numbers of edges": (numbers_of("EDGE"), 1, BAKED), "vertex group": (vertex_group, 1, BAKED), "missing attribute": (missing_attribute, 1, EXACT), "strips": (strips, 10, EXACT), "velocities": (velocities, 6, EXACT),
    "two-sided": (surfaces.two_sided, 1, EXACT),
    "two-sided by shaders": (surfaces.two_sided_by_shaders, 1, EXACT),
    "hair": (hairs.hair, 1, BAKED), "hair from the side": (hairs.hair_from_the_side, 1, BAKED),
    "hair of children": (hairs.hair_of_children, 1, BAKED), "zoom": (zoom, 5, EXACT), "mixed by chance": (surfaces.mixed_by_chance, 1, EXACT),
    "thin wall": (surfaces.thin_wall, 1, EXACT),
    "thin wall, frosted": (surfaces.frosted, 1, EXACT), "thin wall, frosted metal": (surfaces.frosted_metal, 1, EXACT),
    "thin metal": (surfaces.thin_metal, 1, EXACT), "thin metal in colours": (surfaces.thin_metal_in_colours, 1, BAKED),
    "fog box": (surfaces.fog_box, 6, EXACT),
    "face of glass": (surfaces.rough_transmission, 1, EXACT), "face of smoother glass": (lambda scene: surfaces.rough_transmission(scene, 0.2), 1, EXACT),
    "face of glass, textured": (surfaces.textured_transmission, 1, EXACT), "glossy leaf": (surfaces.glossy_leaf, 1, EXACT),
    "picture with alpha": (surfaces.picture_with_alpha, 1, EXACT), "lamp for its size": (lamps.lamp_for_its_size, 1, EXACT),
    "soft lamp for its size": (lambda scene: lamps.lamp_for_its_size(scene, True), 1, EXACT),
    "thin wall of a texture": (surfaces.thin_wall_of_a_texture, 1, BAKED), "keys in a group": (grouped, 6, EXACT),
    "light in a group": (light_in_a_group, 6, EXACT), "fog in a group": (surfaces.fog_in_a_group, 1, EXACT),
    "path of a property": (path_of_a_property, 1, EXACT), "softbox": (lamps.softbox, 6, EXACT),
    "free normals": (surfaces.free_normals, 1, EXACT), "pictures apart": (surfaces.pictures_apart, 1, BAKED), "emptied": (surfaces.emptied, 1, EXACT), "clay": (surfaces.clay, 1, EXACT),
    "bumps": (surfaces.bumps, 1, BAKED), "film scan": (surfaces.film_scan, 1, BAKED), "broadcast": (surfaces.broadcast, 1, BAKED),
    "lacquered": (shine.lacquered, 1, EXACT), "hammered": (shine.hammered, 1, EXACT),
    "hammered in objects' axes": (lambda scene: shine.hammered(scene, 0.6, "OBJECT"), 1, BAKED), "hammered weakly": (lambda scene: shine.hammered(scene, 0.4), 1, EXACT), "polished": (shine.polished, 1, EXACT),
    "flattened": (surfaces.flattened, 1, EXACT), "muted": (surfaces.muted, 1, EXACT), "box on the ground": (instances.box_on_the_ground, 1, EXACT),
    "coarse picture": (surfaces.coarse_picture, 1, EXACT),
    "numbers of colours": (made.numbers_of_colours, 1, EXACT), "beyond one": (made.beyond_one, 1, EXACT),
    "generated": (made.generated, 1, BAKED), "shining colour": (made.shining_colour, 1, EXACT),
    "half mixed": (made.half_mixed, 1, EXACT), "open while it changes": (made.open_while_it_changes, 5, EXACT),
    "open while light changes": (made.open_while_light_changes, 3, EXACT), "swung": (made.swung, 5, EXACT),
    "associated": (made.associated, 1, BAKED), "alpha asked for": (made.alpha_asked_for, 1, BAKED),
    "stained": (clear.stained, 1, EXACT), "flame": (clear.flame, 1, BAKED), "paths": (made.paths, 1, EXACT), "uv of nodes": (made.uv_of_nodes, 1, EXACT),
    "rounded": (made.rounded, 1, BAKED),
    "lights for their size": (made.lights_for_their_size, 1, EXACT), "world switched off": (made.world_switched_off, 1, EXACT),
    "lamps in mirrors": (lamps.in_mirrors, 1, EXACT), "lamps seen": (lamps.seen, 1, EXACT), "soft lamp by a leaf": (lamps.soft_by_a_leaf, 1, EXACT),
    "soft lamp in fog": (lambda scene: lamps.in_fog(scene, True, 0.7), 1, EXACT), "sphere in fog": (lambda scene: lamps.in_fog(scene, False, 0.0), 1, EXACT),
    "grazed leaves": (shine.grazed_leaves, 1, EXACT), "grazed leaves, muddy": (lambda scene: shine.grazed_leaves(scene, "BsdfDiffuse"), 1, EXACT),
    "grazed leaves, baked": (lambda scene: shine.grazed_leaves(scene, is_baked=True), 1, BAKED),
    "world of fog": (surfaces.world_of_fog, 1, EXACT),
    "world by rays": (two_worlds, 1, BAKED), "cut leaf": (surfaces.cut_leaf, 1, EXACT),
    "squares": (lambda scene: surfaces.coarse_picture(scene, "Closest", 4), 1, BAKED), "decal": (surfaces.decal, 1, BAKED),
}
# By name: how it is built, and what has to be said, as a warning.
SAID = {
    "world by shine": (lambda scene: world_by_rays(scene, "Is Glossy Ray"), "world-depends-on-rays"), "world by the window": (world_by_the_window, "world-depends-on-rays"), "sheen": (surfaces.sheen, "material-lost"),
    "thin metal of a texture": (surfaces.thin_metal_of_a_texture, "material-lost"),
    "two-sided and transparent": (surfaces.two_sided_and_transparent, "material-lost"),
    "keyed shutter": (keyed_shutter, "shutter-changes"),
    "velocities at the start": (lambda scene: velocities(scene, "START"), "velocity-blur"),
    "volume of nodes": (nodes_volume, "volume"), "pencil of nodes": (nodes_pencil, "grease-pencil"),
    "points of nodes": (nodes_points, "point-cloud"), "hair": (hairs.hair, "hair"),
    "smooth transmission": (lambda scene: surfaces.rough_transmission(scene, 0.0), "material-lost"),
    "keyed coat": (surfaces.keyed_coat, "material-changes"), "stained gloss": (clear.stained_gloss, "material-lost", "transparent-tint"),
    "uneven spot": (lamps.uneven_spot, "light-uneven"), "fading lamp": (lamps.fading, "light-nodes"),
    "lamp about a leaf": (lamps.about_a_leaf, "light-near"), "mirror without bounces": (lamps.mirror_alone, "mirror-bounces"), "scrolled": (surfaces.scrolled, "material-changes"),
    "doubled": (instances.doubled, "coincident-faces"), "flat box": (instances.flat_box, "coincident-faces"),
    "lines of pixels": (made.lines_of_pixels, "material-lost", "depends-on-view"),
    "doubled while the shutter is open": (lambda scene: instances.doubled(scene, True), "coincident-faces"), "two-sided leaf": (surfaces.two_sided_and_translucent, "material-lost"),
    "leaning normals": (surfaces.leaning_normals, "custom-normals"), "few faces": (surfaces.few_faces, "shadow-terminator"),
    "window": (surfaces.window, "material-lost"), "added translucence": (surfaces.added_translucence, "material-lost"),
    "light info": (surfaces.light_info, "material-lost"), "hues": (surfaces.hues, "instance-colors"),
    "polished otherwise": (lambda scene: shine.polished(scene, "BECKMANN"), "material-lost"),
    "fog of noise": (surfaces.fog_of_noise, "fog-material"),
    "fog about the camera": (surfaces.fog_about_the_camera, "fog-clipped"),
    "fog on the ground": (surfaces.fog_on_the_ground, "fog-touches"),
    "fogs that overlap": (surfaces.two_fogs, "fog-overlaps"),
    "fogs side by side": (lambda scene: surfaces.two_fogs(scene, (4.0, 0.1, 0.1)), "fog-touches"),
    "normals as colours": (made.normals_as_colours, "material-lost", "depends-on-place"),
    "two shines": (made.two_shines, "material-lost", "mixed-shine"),
    "one scattering": (made.one_scattering, "material-lost", "single-scattering"),
    "bent elsewhere": (made.bent_elsewhere, "material-lost", "normal-map-uv"),
    "of what bends": (made.of_what_bends, "material-lost", "depends-on-shape"),
    "moving lamp": (made.swung_late, "light-blur"), "swung late": (made.swung_late, "motion-blur-off"), "light of one bounce": (made.light_of_one_bounce, "light-bounces"),
    "fog unseen": (lambda scene: surfaces.fog_box(scene, visible_camera=False), "ray-visibility"),
}
# What came after Blender 5.0.
LATER = {
    "light info": (5, 1),
    **dict.fromkeys((name for name in (*BESIDE, *SAID) if name.startswith("thin ")), (5, 2)),
}
