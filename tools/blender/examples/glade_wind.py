"""Leaves in the wind, as a simulation zone of geometry nodes: they let go, drift, strike trunks and come
to rest on the ground.

What an artist would build in the node editor, in Python. Lengths are metres, times seconds.
"""

import bpy

# How soon a leaf goes along with the air, per second, and how it falls in still air, m/s.
DRAG, FALL = 3.0, 0.75
# Share of its tilt that a leaf loses in a frame once it lies on the ground.
SETTLES = 0.3


class Nodes:
    """A tree of geometry nodes whose sums are written as calls; sockets and numbers may
    stand for each other."""

    def __init__(self, name):
        self.group = bpy.data.node_groups.new(name, "GeometryNodeTree")
        self.group.is_modifier = True
        for way in ("INPUT", "OUTPUT"):
            self.group.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")

    def add(self, kind, sockets=(), **properties):
        """A node; `sockets` are values or sockets by name or number."""
        made = self.group.nodes.new(kind)
        for name, value in properties.items():
            setattr(made, name, value)
        for name, value in dict(sockets).items():
            self.put(made.inputs[name] if isinstance(name, int) else enabled(made.inputs, name), value)
        return made

    def put(self, socket, value):
        if isinstance(value, bpy.types.NodeSocket):
            self.group.links.new(value, socket)
        else:
            socket.default_value = value

    def math(self, operation, *values):
        return self.add("ShaderNodeMath", dict(enumerate(values)), operation=operation).outputs[0]

    def vector(self, operation, *values):
        made = self.add("ShaderNodeVectorMath", dict(enumerate(values)), operation=operation)
        return made.outputs["Value" if operation in {"LENGTH", "DOT_PRODUCT"} else "Vector"]

    def scaled(self, vector, factor):
        return self.add("ShaderNodeVectorMath", {0: vector, "Scale": factor}, operation="SCALE").outputs["Vector"]

    def xyz(self, x, y, z):
        return self.add("ShaderNodeCombineXYZ", {0: x, 1: y, 2: z}).outputs[0]

    def random(self, kind, low, high, seed):
        made = self.add("FunctionNodeRandomValue", {"Min": low, "Max": high, "Seed": seed}, data_type=kind)
        return next(socket for socket in made.outputs if socket.enabled)

    def attribute(self, kind, name):
        made = self.add("GeometryNodeInputNamedAttribute", {"Name": name}, data_type=kind)
        return enabled(made.outputs, "Attribute")

    def stored(self, geometry, **values):
        """The geometry with attributes of its points, each a kind and a field."""
        for name, (kind, field) in values.items():
            made = self.add(
                "GeometryNodeStoreNamedAttribute",
                {"Geometry": geometry, "Name": name},
                data_type=kind,
                domain="POINT",
            )
            self.put(enabled(made.inputs, "Value"), field)
            geometry = made.outputs[0]
        return geometry

    def captured(self, geometry, **fields):
        """The geometry and fields as they are on it now, by name."""
        made = self.add("GeometryNodeCaptureAttribute", {"Geometry": geometry}, domain="POINT")
        for name, field in fields.items():
            made.capture_items.new({"VALUE": "FLOAT"}.get(field.type, field.type), name)
            self.put(made.inputs[name], field)
        return made.outputs


def enabled(sockets, name):
    """Of sockets that share a name, the one of the node's kind of data."""
    return next(socket for socket in sockets if socket.name == name and socket.enabled)


def blow(air, twigs, leaves, colliders, a_second):
    """Gives the mesh `air`, whose vertices are leaves that fall already, a modifier that moves them and
    lets others go from `twigs`, so many a second; they show objects of the collection `leaves` and strike
    those of `colliders`."""
    nodes = Nodes("leaves in the wind")
    time = nodes.add("GeometryNodeInputSceneTime")
    start, end = nodes.add("GeometryNodeSimulationInput"), nodes.add("GeometryNodeSimulationOutput")
    start.pair_with_output(end)
    source = nodes.add("NodeGroupInput").outputs[0]
    falling = nodes.add("GeometryNodeMeshToPoints", {"Mesh": source}).outputs[0]
    nodes.put(start.inputs["Geometry"], born(nodes, falling, (0.3, 0.0, -FALL), 1.0))
    joined = nodes.add("GeometryNodeJoinGeometry")
    nodes.put(joined.inputs[0], start.outputs["Geometry"])
    nodes.put(joined.inputs[0], let_go(nodes, twigs, time.outputs["Frame"], a_second))
    obstacles = nodes.add(
        "GeometryNodeCollectionInfo", {"Collection": colliders}, transform_space="RELATIVE"
    ).outputs[0]
    solid = nodes.add("GeometryNodeRealizeInstances", {"Geometry": obstacles}).outputs[0]
    moved = step(nodes, joined.outputs[0], solid, time.outputs["Seconds"], start.outputs["Delta Time"])
    nodes.put(end.inputs["Geometry"], moved)
    shown = show(nodes, end.outputs["Geometry"], leaves)
    nodes.put(nodes.add("NodeGroupOutput").inputs[0], shown)
    air.modifiers.new("wind", "NODES").node_group = nodes.group


def born(nodes, points, velocity, seed):
    """Points with all that a leaf knows; `seed` is the first of eight numbers."""
    of = lambda kind, low, high, more: nodes.random(kind, low, high, nodes.math("ADD", seed, float(more)))
    turn = nodes.add(
        "FunctionNodeEulerToRotation", {0: of("FLOAT_VECTOR", (0.0,) * 3, (6.28,) * 3, 0)}
    ).outputs[0]
    return nodes.stored(
        points,
        velocity=("FLOAT_VECTOR", velocity),
        turn=("QUATERNION", turn),
        spin=("FLOAT_VECTOR", of("FLOAT_VECTOR", (-3.5, -3.5, -2.0), (3.5, 3.5, 2.0), 1)),
        size=("FLOAT", of("FLOAT", 0.14, 0.24, 2)),
        phase=("FLOAT", of("FLOAT", 0.0, 6.28, 3)),
        kind=("INT", of("INT", 0, 99, 4)),
        ground=("FLOAT_VECTOR", (0.0, 0.0, 1.0)),
        rests=("FLOAT", 0.0),
    )


def let_go(nodes, twigs, frame, a_second):
    """Leaves that leave the twigs in this frame."""
    area = sum(face.area for face in twigs.data.polygons) * twigs.matrix_world.to_scale().x ** 2
    mesh = nodes.add("GeometryNodeObjectInfo", {"Object": twigs}, transform_space="RELATIVE").outputs["Geometry"]
    density = a_second / (bpy.context.scene.render.fps * area)
    points = nodes.add(
        "GeometryNodeDistributePointsOnFaces", {"Mesh": mesh, "Density": density, "Seed": frame}
    ).outputs["Points"]
    return born(nodes, points, (0.0, 0.0, 0.0), nodes.math("MULTIPLY_ADD", frame, 8.0, 100.0))


def air_at(nodes, position, seconds):
    """The wind's velocity: gusts that roll across the clearing, and eddies."""
    x = nodes.add("ShaderNodeSeparateXYZ", {0: position}).outputs[0]
    roll = nodes.math("SINE", nodes.math("MULTIPLY_ADD", x, -0.35, nodes.math("MULTIPLY", seconds, 2.2)))
    gust = nodes.scaled((1.0, -0.25, 0.1), nodes.math("MULTIPLY_ADD", roll, 0.5, 0.7))
    eddies = nodes.add(
        "ShaderNodeTexNoise",
        {"Vector": position, "W": nodes.math("MULTIPLY", seconds, 0.5), "Scale": 0.55, "Detail": 1.0},
        noise_dimensions="4D",
    )
    swirl = nodes.vector("SUBTRACT", eddies.outputs["Color"], (0.5, 0.5, 0.5))
    return nodes.vector("ADD", gust, nodes.vector("MULTIPLY", swirl, (4.0, 4.0, 2.5)))


def step(nodes, points, solid, seconds, interval):
    """One frame on: drag and weight, then the way as far as something stands in it."""
    position = nodes.add("GeometryNodeInputPosition").outputs[0]
    velocity, phase = nodes.attribute("FLOAT_VECTOR", "velocity"), nodes.attribute("FLOAT", "phase")
    free = nodes.math("SUBTRACT", 1.0, nodes.attribute("FLOAT", "rests"))
    # To and fro, as plates fall.
    sway = nodes.math("MULTIPLY", nodes.math("SINE", nodes.math("MULTIPLY_ADD", seconds, 5.0, phase)), 2.5)
    flutter = nodes.scaled(nodes.xyz(nodes.math("COSINE", phase), nodes.math("SINE", phase), 0.3), sway)
    dragged = nodes.scaled(nodes.vector("SUBTRACT", air_at(nodes, position, seconds), velocity), DRAG)
    force = nodes.vector("ADD", nodes.vector("ADD", dragged, (0.0, 0.0, -DRAG * FALL)), flutter)
    faster = nodes.scaled(nodes.vector("ADD", velocity, nodes.scaled(force, interval)), free)
    way = nodes.scaled(faster, interval)
    hit = nodes.add(
        "GeometryNodeRaycast",
        {
            "Target Geometry": solid, "Source Position": position, "Ray Direction": faster,
            "Ray Length": nodes.math("ADD", nodes.vector("LENGTH", way), 0.03),
        },
    )
    normal, is_hit = hit.outputs["Hit Normal"], nodes.math("MULTIPLY", hit.outputs["Is Hit"], free)
    is_flat = nodes.math("GREATER_THAN", nodes.add("ShaderNodeSeparateXYZ", {0: normal}).outputs[2], 0.5)
    lands = nodes.math("MULTIPLY", is_hit, is_flat)
    rests = nodes.math("MAXIMUM", nodes.attribute("FLOAT", "rests"), lands)
    # What strikes a trunk keeps what goes along the bark.
    into = nodes.math(
        "MULTIPLY", nodes.vector("DOT_PRODUCT", faster, normal), nodes.math("MULTIPLY", is_hit, -1.2)
    )
    slower = nodes.vector("ADD", faster, nodes.scaled(normal, into))
    onto = nodes.vector("ADD", hit.outputs["Hit Position"], nodes.scaled(normal, 0.02))
    target = switched(nodes, "VECTOR", is_hit, nodes.vector("ADD", position, way), onto)
    ground = switched(nodes, "VECTOR", lands, nodes.attribute("FLOAT_VECTOR", "ground"), normal)
    rolled = nodes.add(
        "FunctionNodeEulerToRotation", {0: nodes.scaled(nodes.attribute("FLOAT_VECTOR", "spin"), interval)}
    ).outputs[0]
    turned = settling(nodes, rolled, rests, ground)
    # Each of these looks at what was before, so all are known before anything moves.
    known = nodes.captured(points, position=target, velocity=slower, turn=turned, ground=ground, rests=rests)
    moved = nodes.add(
        "GeometryNodeSetPosition", {"Geometry": known["Geometry"], "Position": known["position"]}
    ).outputs[0]
    return nodes.stored(
        moved, velocity=("FLOAT_VECTOR", known["velocity"]), turn=("QUATERNION", known["turn"]),
        ground=("FLOAT_VECTOR", known["ground"]), rests=("FLOAT", known["rests"]),
    )


def settling(nodes, rolled, rests, ground):
    """How a leaf is turned a frame on: it spins in the air, and lies down on the ground."""
    turn = nodes.attribute("QUATERNION", "turn")
    spinning = nodes.add("FunctionNodeRotateRotation", {0: turn, 1: rolled}, rotation_space="LOCAL").outputs[0]
    share = nodes.math("MULTIPLY", rests, SETTLES)
    lying = nodes.add(
        "FunctionNodeAlignRotationToVector", {"Rotation": turn, "Factor": share, "Vector": ground}, axis="Z"
    ).outputs[0]
    return switched(nodes, "ROTATION", rests, spinning, lying)


def show(nodes, points, leaves):
    """A leaf on each point."""
    chosen = nodes.add(
        "GeometryNodeCollectionInfo",
        {"Collection": leaves, "Separate Children": True, "Reset Children": True},
    )
    return nodes.add(
        "GeometryNodeInstanceOnPoints",
        {
            "Points": points, "Instance": chosen.outputs[0], "Pick Instance": True, "Instance Index": nodes.attribute("INT", "kind"),
            "Rotation": nodes.attribute("QUATERNION", "turn"), "Scale": nodes.attribute("FLOAT", "size"),
        },
    ).outputs[0]


def switched(nodes, kind, condition, off, on):
    made = nodes.add(
        "GeometryNodeSwitch", {"Switch": nodes.math("GREATER_THAN", condition, 0.5)}, input_type=kind
    )
    nodes.put(made.inputs["False"], off)
    nodes.put(made.inputs["True"], on)
    return made.outputs[0]
