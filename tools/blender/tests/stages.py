"""Small scenes of everything that moves, shows or hides in Blender, each by its name;
four to eight frames."""

import math

import bpy
import scenes

FRAMES = (1, 6)


def stage(frames=FRAMES):
    scene = scenes.empty(frames)
    scenes.camera(scene)
    scenes.sun(scene)
    return scene


def quad(scene, name="quad", size=1.0, location=(0.0, 0.0, 1.0)):
    return scenes.quad(scene, name, size, scenes.material(name, (0.2, 0.5, 0.1)), location)


def grid(scene, name="grid", columns=4):
    """A mesh with something to bend."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=columns, y_subdivisions=columns, size=1.0)
    thing = bpy.context.object
    thing.name = thing.data.name = name
    return thing


def key(owner, path, values, frames=FRAMES, interpolation=None):
    for frame, value in zip(frames, values):
        setattr(owner, path, value)
        owner.keyframe_insert(path, frame=frame)
    if interpolation:
        from sunfleck import keys

        for curve in keys.curves_of(owner):
            for point in getattr(curve, "keyframe_points", ()):
                point.interpolation = interpolation


def moving(thing):
    key(thing, "location", ((0.0, 0.0, 1.0), (2.0, 1.0, 0.0)))
    key(thing, "rotation_euler", ((0.0, 0.0, 0.0), (3.0, 2.0, 1.0)))


def spins_and_jumps(scene):
    thing = quad(scene)
    moving(thing)
    jumps = quad(scene, "jumps", location=(2.0, 0.0, 0.0))
    key(jumps, "location", ((2.0, 0.0, 0.0), (0.0, 2.0, 0.0)), interpolation="CONSTANT")


def shears(scene):
    parent = scenes.add(scene, "parent", None)
    parent.scale = (1.0, 3.0, 0.5)
    for name in ("turns", "still"):
        child = quad(scene, name)
        child.parent = parent
        child.rotation_euler = (0.3, 0.4, 0.5)
        if name == "turns":
            key(child, "rotation_euler", ((0.0, 0.0, 0.1), (0.5, 1.5, 3.0)))
    key(parent, "rotation_euler", ((0.0, 0.0, 0.0), (0.0, 1.0, 1.0)))


def mirrors(scene):
    for name, scale in (("one", (-1.0, 1.0, 1.0)), ("two", (-1.0, -2.0, 1.0)), ("three", (-1.0, -1.0, -1.0))):
        thing = quad(scene, name)
        moving(thing)
        thing.scale = scale


def scales_to_nothing(scene):
    thing = quad(scene)
    key(thing, "scale", ((1.0, 1.0, 1.0), (0.0, 0.0, 0.0)))
    flat = quad(scene, "flat")
    flat.scale.z = 0.0
    moving(flat)


def shape_keys_and_modifiers(scene):
    """One object's shape keys must not take another's modifiers."""
    bent = grid(scene, "bent")
    bent.shape_key_add(name="rest")
    curl = bent.shape_key_add(name="curl")
    for index, point in enumerate(curl.data):
        point.co.z += 0.2 * math.sin(index)
    key(curl, "value", (0.0, 1.0))
    twist = bent.modifiers.new("twist", "SIMPLE_DEFORM")
    twist.deform_method = "TWIST"
    key(twist, "angle", (0.0, 1.0))
    thick = quad(scene, "thick", location=(2.0, 0.0, 0.0))
    thick.modifiers.new("thick", "SOLIDIFY").thickness = 0.1


def keyed_visibility(scene):
    """One that comes and goes; one that is hidden; one that shows in the viewport alone."""
    comes = quad(scene, "comes")
    for frame, hidden in ((1, True), (3, False), (5, True)):
        comes.hide_render = comes.hide_viewport = hidden
        comes.keyframe_insert("hide_render", frame=frame)
        comes.keyframe_insert("hide_viewport", frame=frame)
    hidden = quad(scene, "hidden", location=(1.0, 0.0, 0.0))
    hidden.hide_render = hidden.hide_viewport = True
    quad(scene, "seen", location=(-1.0, 0.0, 0.0))


def collections(scene):
    """Excluded, hidden, nested and instanced ones."""
    for name in ("excluded", "hidden", "instanced"):
        collection = bpy.data.collections.new(name)
        scene.collection.children.link(collection)
        thing = quad(scene, f"in {name}")
        scene.collection.objects.unlink(thing)
        collection.objects.link(thing)
    children = scene.view_layers[0].layer_collection.children
    children["excluded"].exclude = True
    bpy.data.collections["hidden"].hide_render = bpy.data.collections["hidden"].hide_viewport = True
    inner = bpy.data.collections["instanced"]
    outer = bpy.data.collections.new("outer")
    nested = bpy.data.objects.new("nested", None)
    nested.instance_type, nested.instance_collection, nested.location = "COLLECTION", inner, (0.0, 0.0, 0.5)
    outer.objects.link(nested)
    for number in range(3):
        empty = scenes.add(scene, f"group {number}", None, (float(number), 2.0, 0.0))
        empty.instance_type, empty.instance_collection = "COLLECTION", outer
        moving(empty)


def topology_changes(scene):
    """A row that grows, and a wall that is built."""
    row = quad(scene, "row", 0.5)
    array = row.modifiers.new("array", "ARRAY")
    key(array, "count", (1, 4))
    wall = grid(scene, "wall")
    build = wall.modifiers.new("build", "BUILD")
    build.frame_start, build.frame_duration = 2.0, 4.0


def words_curves_and_balls(scene):
    text = bpy.data.curves.new("text", "FONT")
    text.body, text.extrude = "leaf", 0.05
    moving(scenes.add(scene, "text", text))
    curve = bpy.data.curves.new("curve", "CURVE")
    curve.dimensions, curve.bevel_depth, curve.resolution_u = "3D", 0.05, 3
    spline = curve.splines.new("BEZIER")
    spline.bezier_points.add(2)
    for index, point in enumerate(spline.bezier_points):
        point.co, point.handle_left_type, point.handle_right_type = (
            (index, math.sin(index), 0.2 * index),
            "AUTO",
            "AUTO",
        )
    scenes.add(scene, "curve", curve)
    key(curve, "bevel_factor_end", (0.3, 1.0))
    balls = bpy.data.metaballs.new("ball")
    balls.resolution = balls.render_resolution = 0.4
    for number in range(2):
        balls.elements.new().co = (0.8 * number, 0.0, 0.0)
    scenes.add(scene, "ball", balls, (0.0, 3.0, 0.0))


def skeleton(scene):
    thing = grid(scene, "skin")
    data = bpy.data.armatures.new("bones")
    bones = scenes.add(scene, "bones", data)
    bpy.context.view_layer.objects.active = bones
    bpy.ops.object.mode_set(mode="EDIT")
    bone = data.edit_bones.new("bone")
    bone.head, bone.tail = (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)
    bpy.ops.object.mode_set(mode="OBJECT")
    group = thing.vertex_groups.new(name="bone")
    group.add(list(range(len(thing.data.vertices) // 2)), 1.0, "REPLACE")
    thing.modifiers.new("skin", "ARMATURE").object = bones
    pose = bones.pose.bones["bone"]
    pose.rotation_mode = "XYZ"
    for frame, angle in zip(FRAMES, (0.0, 1.5)):
        pose.rotation_euler = (angle, 0.0, 0.0)
        pose.keyframe_insert("rotation_euler", frame=frame)


def waves(scene):
    """Every frame another shape, on an object that others instance."""
    thing = grid(scene, "wave", 6)
    wave = thing.modifiers.new("wave", "WAVE")
    wave.height, wave.width, wave.speed = 0.3, 0.4, 0.2
    collection = bpy.data.collections.new("waves")
    scene.collection.objects.unlink(thing)
    collection.objects.link(thing)
    for number in range(2):
        empty = scenes.add(scene, f"at {number}", None, (2.0 * number, 0.0, 0.0))
        empty.instance_type, empty.instance_collection = "COLLECTION", collection


def on_faces_and_vertices(scene):
    for kind in ("FACES", "VERTS"):
        parent = grid(scene, f"parent {kind}", 2)
        child = quad(scene, f"child {kind}", 0.2, (0.0, 0.0, 0.0))
        child.parent = parent
        parent.instance_type = kind
        parent.show_instancer_for_render = parent.show_instancer_for_viewport = False
        moving(parent)


def constraints_and_drivers(scene):
    path = bpy.data.curves.new("path", "CURVE")
    path.dimensions = "3D"
    spline = path.splines.new("POLY")
    spline.points.add(2)
    for index, point in enumerate(spline.points):
        point.co = (2.0 * index, index * index, 0.5 * index, 1.0)
    line = scenes.add(scene, "path", path)
    follower = quad(scene, "follower")
    follow = follower.constraints.new("FOLLOW_PATH")
    follow.target, follow.use_fixed_location, follow.use_curve_follow = line, True, True
    key(follow, "offset_factor", (0.0, 1.0))
    driven = quad(scene, "driven")
    driven.driver_add("location", 0).driver.expression = "0.1 * frame"


def negative_frames(scene):
    """What began before the first frame, which Blender lets be 0."""
    scene.frame_start, scene.frame_end = 0, 3
    thing = quad(scene)
    key(thing, "location", ((0.0, 0.0, 0.0), (3.0, 1.0, 2.0)), frames=(-4, 2))


def odd_rate(scene):
    scene.frame_start, scene.frame_end = 101, 106
    scene.render.fps, scene.render.fps_base = 24, 1.001
    key(quad(scene), "location", ((0.0, 0.0, 0.0), (3.0, 1.0, 2.0)), frames=(101, 106))


def remapped(scene):
    scene.render.frame_map_old, scene.render.frame_map_new = 100, 50
    key(quad(scene), "location", ((0.0, 0.0, 0.0), (3.0, 1.0, 2.0)))


def drops(scene):
    """A rigid body."""
    thing = quad(scene, "falls", location=(0.0, 0.0, 3.0))
    bpy.context.view_layer.objects.active = thing
    bpy.ops.rigidbody.world_add()
    bpy.ops.rigidbody.object_add(type="ACTIVE")


def cloth(scene):
    thing = grid(scene, "cloth", 5)
    thing.location.z = 2.0
    thing.modifiers.new("cloth", "CLOTH")


def many_materials(scene):
    thing = grid(scene, "patches", 3)
    for name in ("one", "two", "three"):
        thing.data.materials.append(scenes.material(name, (0.1, 0.2, 0.3)))
    for face in thing.data.polygons:
        face.material_index = face.index % 3
    other = scenes.add(scene, "other", thing.data, (2.0, 0.0, 0.0))
    other.material_slots[0].link = "OBJECT"
    other.material_slots[0].material = scenes.material("own", (0.5, 0.1, 0.1))


STAGES = {
    build.__name__: build
    for build in (
        spins_and_jumps, shears, mirrors, scales_to_nothing, shape_keys_and_modifiers, keyed_visibility, collections, topology_changes,
        words_curves_and_balls, skeleton, waves, on_faces_and_vertices, constraints_and_drivers, negative_frames, odd_rate, remapped,
        drops, cloth, many_materials,
    )
}
