"""Falling leaves as artists animate them: particles, geometry nodes and simulation zones, whose leaves are
born, move and turn."""

import math

import bpy

SCENES = ("particles", "nodes", "nodes_born", "simulation", "simulation_emits")
FRAMES = range(1, 25)
LEAVES = 60


def stage():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end, scene.render.fps = FRAMES[0], FRAMES[-1], 24
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 320, 180, 100
    leaf = mesh("leaf", [(-0.1, 0, 0), (0, 0.2, 0.02), (0.1, 0, 0), (0, -0.2, 0.02)], [(0, 1, 2), (0, 2, 3)])
    leaf.location.z = -5.0
    gold = bpy.data.materials.new("gold")
    gold.use_nodes = True
    gold.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.8, 0.5, 0.05, 1.0)
    leaf.data.materials.append(gold)
    mesh("ground", [(-6, -6, 0), (6, -6, 0), (6, 6, 0), (-6, 6, 0)], [(0, 1, 2, 3)])
    emitter = mesh("emitter", [(-3, -2, 4), (3, -2, 4), (3, 2, 4), (-3, 2, 4)], [(0, 1, 2, 3)])
    camera = add("camera", bpy.data.cameras.new("camera"))
    camera.location, camera.rotation_euler = (0, -8, 1.6), (math.radians(90), 0, 0)
    scene.camera = camera
    sun = bpy.data.lights.new("sun", "SUN")
    sun.energy = 5.0
    add("sun", sun).rotation_euler = (math.radians(35), math.radians(20), 0)
    return scene, leaf, emitter


def add(name, data):
    placed = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(placed)
    return placed


def mesh(name, points, faces):
    made = bpy.data.meshes.new(name)
    made.from_pydata(points, [], faces)
    return add(name, made)


def particles(leaf, emitter):
    settings = emitter.modifiers.new("fall", "PARTICLE_SYSTEM").particle_system.settings
    settings.count, settings.frame_start, settings.frame_end, settings.lifetime = LEAVES, -20, 10, 100
    settings.render_type, settings.instance_object, settings.particle_size = "OBJECT", leaf, 1.0
    settings.normal_factor, settings.brownian_factor, settings.drag_factor = 0.0, 2.0, 0.5
    settings.use_rotations, settings.angular_velocity_mode, settings.angular_velocity_factor = (
        True,
        "VELOCITY",
        3.0,
    )
    settings.effector_weights.gravity = 0.2
    emitter.show_instancer_for_render = emitter.show_instancer_for_viewport = False


class Tree:
    """A geometry node tree of a modifier, in few words."""

    def __init__(self, emitter):
        self.group = bpy.data.node_groups.new("fall", "GeometryNodeTree")
        self.group.is_modifier = True
        for way in ("INPUT", "OUTPUT"):
            self.group.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
        self.source, self.target = self.node("NodeGroupInput"), self.node("NodeGroupOutput")
        emitter.modifiers.new("fall", "NODES").node_group = self.group

    def node(self, kind, **values):
        made = self.group.nodes.new(kind)
        for name, value in values.items():
            setattr(made, name, value)
        return made

    def link(self, output, socket):
        self.group.links.new(output, socket)

    def random(self, low, high, seed=0):
        """The output of a random number for each point. Sockets by name: numbers differ by version."""
        made = self.node("FunctionNodeRandomValue", data_type="FLOAT")
        for name, value in (("Min", low), ("Max", high), ("Seed", seed)):
            next(socket for socket in made.inputs if socket.enabled and socket.name == name).default_value = value
        return next(output for output in made.outputs if output.enabled)

    def scatter(self, density):
        made = self.node("GeometryNodeDistributePointsOnFaces")
        made.inputs["Density"].default_value = density
        self.link(self.source.outputs[0], made.inputs["Mesh"])
        return made

    def instances(self, points, leaf):
        on_points, info = self.node("GeometryNodeInstanceOnPoints"), self.node("GeometryNodeObjectInfo")
        info.inputs["Object"].default_value, info.inputs["As Instance"].default_value = leaf, True
        self.link(points, on_points.inputs["Points"])
        self.link(info.outputs["Geometry"], on_points.inputs["Instance"])
        self.link(on_points.outputs[0], self.target.inputs[0])
        return on_points


def nodes(leaf, emitter, born=False):
    tree = Tree(emitter)
    points, time = tree.scatter(LEAVES / 24), tree.node("GeometryNodeInputSceneTime")
    age, drop, spin = (
        tree.node("ShaderNodeMath", operation=kind) for kind in ("ADD", "MULTIPLY", "MULTIPLY")
    )
    tree.link(time.outputs["Seconds"], age.inputs[0])
    tree.link(tree.random(0.0, 2.0), age.inputs[1])
    drop.inputs[1].default_value, spin.inputs[1].default_value = -1.2, 5.0
    tree.link(age.outputs[0], drop.inputs[0])
    tree.link(age.outputs[0], spin.inputs[0])
    offset, turn = tree.node("ShaderNodeCombineXYZ"), tree.node("ShaderNodeCombineXYZ")
    tree.link(drop.outputs[0], offset.inputs["Z"])
    tree.link(spin.outputs[0], turn.inputs["X"])
    tree.link(age.outputs[0], turn.inputs["Y"])
    moved = tree.node("GeometryNodeSetPosition")
    tree.link(points.outputs["Points"], moved.inputs["Geometry"])
    tree.link(offset.outputs[0], moved.inputs["Offset"])
    alive = moved.outputs[0]
    if born:
        later = tree.node("FunctionNodeCompare", data_type="FLOAT", operation="GREATER_THAN")
        tree.link(tree.random(0.0, 24.0, seed=7), later.inputs["A"])
        tree.link(time.outputs["Frame"], later.inputs["B"])
        unborn = tree.node("GeometryNodeDeleteGeometry", domain="POINT")
        tree.link(moved.outputs[0], unborn.inputs["Geometry"])
        tree.link(later.outputs[0], unborn.inputs["Selection"])
        alive = unborn.outputs[0]
    placed, rotation = tree.instances(alive, leaf), tree.node("FunctionNodeEulerToRotation")
    tree.link(turn.outputs[0], rotation.inputs[0])
    tree.link(rotation.outputs[0], placed.inputs["Rotation"])


def simulation(leaf, emitter, emits=False):
    tree = Tree(emitter)
    start, end = tree.node("GeometryNodeSimulationInput"), tree.node("GeometryNodeSimulationOutput")
    start.pair_with_output(end)
    first = tree.scatter(0.1 if emits else 2.5)
    tree.link(first.outputs["Points"], start.inputs["Geometry"])
    step = tree.node("GeometryNodeSetPosition")
    step.inputs["Offset"].default_value = (0.01, 0.0, -0.05)
    state = start.outputs["Geometry"]
    if emits:
        joined, more, time = (
            tree.node("GeometryNodeJoinGeometry"),
            tree.scatter(0.15),
            tree.node("GeometryNodeInputSceneTime"),
        )
        tree.link(time.outputs["Frame"], more.inputs["Seed"])
        tree.link(state, joined.inputs[0])
        tree.link(more.outputs["Points"], joined.inputs[0])
        state = joined.outputs[0]
    tree.link(state, step.inputs["Geometry"])
    tree.link(step.outputs[0], end.inputs["Geometry"])
    tree.instances(end.outputs["Geometry"], leaf)


def build(name):
    scene, leaf, emitter = stage()
    {
        "particles": lambda: particles(leaf, emitter),
        "nodes": lambda: nodes(leaf, emitter),
        "nodes_born": lambda: nodes(leaf, emitter, born=True),
        "simulation": lambda: simulation(leaf, emitter),
        "simulation_emits": lambda: simulation(leaf, emitter, emits=True),
    }[name]()
    return scene
