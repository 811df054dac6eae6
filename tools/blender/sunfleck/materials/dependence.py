"""Dependencies of a node tree: texture coordinates, the surface, or the instance.

In go trees, out come names. Invariant: only nodes that reach the output count.
"""

from . import principled, sheets

# Textures that use generated coordinates unless others are linked.
PROCEDURAL = {
    "TEX_NOISE", "TEX_VORONOI", "TEX_WAVE", "TEX_MAGIC", "TEX_CHECKER", "TEX_BRICK", "TEX_GRADIENT", "TEX_WHITE_NOISE", "TEX_GABOR",
    "TEX_MUSGRAVE", "TEX_ENVIRONMENT", "TEX_SKY", "TEX_IES",
}
OF_SURFACES = {
    "NEW_GEOMETRY", "VERTEX_COLOR", "BEVEL", "AMBIENT_OCCLUSION", "WIREFRAME", "CURVE_INFO", "HAIR_INFO", "POINT_INFO", "TEX_ENVIRONMENT",
}
OF_INSTANCES = {"OBJECT_INFO", "PARTICLE_INFO"}
OF_INSTANCERS = {"INSTANCER", "OBJECT", "VIEW_LAYER"}
# Dependencies that a bake cannot represent: by type of node, all its outputs or some.
VIEW, PLACE, SIDE, SURROUNDINGS, HAIR = (
    f"depends-on-{what}" for what in ("view", "place", "side", "surroundings", "hair")
)
LOST = {
    "FRESNEL": VIEW, "LAYER_WEIGHT": VIEW, "CAMERA": VIEW, "LIGHT_PATH": VIEW, "LIGHT_FALLOFF": VIEW,
    "TANGENT": PLACE, "HAIR_INFO": HAIR, "CURVE_INFO": HAIR, "POINT_INFO": HAIR,
}
LOST_OUTPUTS = {
    "NEW_GEOMETRY": {
        "Position": PLACE, "Normal": PLACE, "True Normal": PLACE, "Tangent": PLACE, "Incoming": VIEW, "Backfacing": SIDE,
    },
    "TEX_COORD": {"Camera": VIEW, "Window": VIEW, "Reflection": VIEW},
}
# Sources of images that change from frame to frame.
FILMS = {"SEQUENCE", "MOVIE"}
# A key identifies only one of the files of a picture.
OF_SEVERAL_FILES = {*FILMS, "TILED"}
# Nodes that were compared with Cycles.
COMPARED = {
    *PROCEDURAL, *OF_SURFACES, *OF_INSTANCES, *LOST, *LOST_OUTPUTS, "TEX_IMAGE", "UVMAP", "ATTRIBUTE", "VERTEX_COLOR", "RGB",
    "VALUE", "MIX", "MIX_RGB", "MATH", "VECT_MATH", "SEPARATE_COLOR", "SEPRGB", "SEPXYZ", "SEPHSV", "COMBINE_COLOR", "COMBRGB",
    "COMBXYZ", "COMBHSV", "VALTORGB", "CURVE_RGB", "CURVE_FLOAT", "CURVE_VEC", "HUE_SAT", "BRIGHTCONTRAST", "GAMMA", "INVERT",
    "MAP_RANGE", "CLAMP", "RGBTOBW", "BLACKBODY", "WAVELENGTH", "MAPPING", "NORMAL", "VECTOR_ROTATE", "NORMAL_MAP", "BUMP",
    "TANGENT", "DISPLACEMENT", "VECTOR_DISPLACEMENT", "REROUTE", "FRAME", "GROUP", "GROUP_INPUT", "GROUP_OUTPUT",
    "OUTPUT_MATERIAL", "MIX_SHADER", "ADD_SHADER", "EMISSION", "HOLDOUT", "SUBSURFACE_SCATTERING", "VECT_TRANSFORM",
    "NodeClosureInput", "NodeClosureOutput", "NodeEvaluateClosure", "NodeCombineBundle", "NodeSeparateBundle", "REPEAT_INPUT",
    "REPEAT_OUTPUT", "MENU_SWITCH",
}

def nodes_of(material):
    """Nodes that reach the surface output, in groups too."""
    output = principled.output_of(material.node_tree) if material.node_tree else None
    found = []

    def follow(node):
        if node in found:
            return
        found.append(node)
        for socket in node.inputs:
            for link in socket.links:
                follow(link.from_node)
        if node.type == "GROUP" and node.node_tree:
            for inner in node.node_tree.nodes:
                if inner.type == "GROUP_OUTPUT":
                    follow(inner)

    if output:
        follow(output)
    return found


def is_of_surface(material):
    """Whether it varies over places with the same texture coordinates."""
    nodes, uvs = nodes_of(material), set()
    for node in nodes:
        if node.type == "UVMAP" or is_tangential(node):
            uvs.add(node.uv_map)
        if (node.type == "TEX_COORD" and node.outputs["UV"].is_linked) or (node.type == "TEX_IMAGE" and not node.inputs["Vector"].is_linked):
            uvs.add("")
    return len(uvs) > 1 or any(map(is_node_of_surface, nodes))


def is_node_of_surface(node):
    if node.type == "TEX_COORD":
        return any(output.is_linked and output.name != "UV" for output in node.outputs)
    if node.type == "TEX_IMAGE":
        return node.projection != "FLAT"
    return node.type in OF_SURFACES or is_unplaced(node) or (node.type == "ATTRIBUTE" and node.attribute_type == "GEOMETRY")


def uv_of(material):
    """Texture coordinates that it uses, if only one set."""
    return next((node.uv_map for node in nodes_of(material) if node.type == "UVMAP"), "")


def uvs_of(material):
    """Names of the texture coordinates that it uses."""
    return {node.uv_map for node in nodes_of(material) if node.type == "UVMAP" and node.uv_map}


def colors_of(material):
    """Names of the attributes that it uses."""
    found = set()
    for node in nodes_of(material):
        if node.type == "VERTEX_COLOR":
            found.add(node.layer_name)
        if node.type == "ATTRIBUTE" and node.attribute_type == "GEOMETRY":
            found.add(node.attribute_name)
    return found


def is_tangential(node):
    """Whether a node bends normals along texture coordinates."""
    return node.type == "NORMAL_MAP" and node.space == "TANGENT"


def tangents_of(material):
    """Names of the texture coordinates along which normals are bent."""
    return {node.uv_map for node in nodes_of(material) if is_tangential(node)}


def is_generated(material):
    """Whether it uses generated coordinates."""
    return any(is_unplaced(node) or (node.type == "TEX_COORD" and is_asked(node, "Generated")) for node in nodes_of(material))


def is_asked(node, *names):
    return not getattr(node, "from_instancer", False) and any(node.outputs[name].is_linked for name in names)


def is_asked_of_view(node):
    """Whether a node outputs window or camera coordinates."""
    return node.type == "TEX_COORD" and is_asked(node, "Window", "Camera")


def is_unplaced(node):
    """Whether a texture uses generated coordinates by default."""
    return node.type in PROCEDURAL and "Vector" in node.inputs and not node.inputs["Vector"].is_linked


def is_of_shape(material):
    """Whether it looks otherwise once a mesh is bent."""
    return any(
        node.type in {"BEVEL", "AMBIENT_OCCLUSION"} or (node.type == "TEX_COORD" and is_asked(node, "Object", "Normal"))
        for node in nodes_of(material)
    )


def has_lines(material):
    return any(node.type == "WIREFRAME" for node in nodes_of(material))


def has_bumps(material):
    """Whether normals depend on lengths in the world."""
    return any(node.type in {"BUMP", "DISPLACEMENT", "VECTOR_DISPLACEMENT"} for node in nodes_of(material))


def questions(material):
    """Its questions to each instance, and the components of the answers that it uses."""
    found = {}
    for node in nodes_of(material):
        for output, question in questions_of_node(node):
            before = found.get(question, (False,) * 4)
            found[question] = tuple(map(max, before, parts_of(output)))
    return found


def questions_of_node(node):
    """Linked outputs that vary by instance, with their questions."""
    for output in node.outputs:
        if not output.is_linked:
            continue
        if node.type in OF_INSTANCES:
            yield output, (node.type, output.name, "")
        elif node.type == "ATTRIBUTE" and node.attribute_type in OF_INSTANCERS:
            yield output, (node.type, node.attribute_type, node.attribute_name)
        elif getattr(node, "from_instancer", False) and output.name in {"UV", "Generated"}:
            yield output, (node.type, output.name, "")


def parts_of(output):
    """Linked components of a vector that is only separated."""
    ends = [link.to_node for link in output.links]
    if output.type != "VECTOR" or not all(end.type == "SEPXYZ" for end in ends):
        return (True,) * 4
    return (*(any(end.outputs[axis].is_linked for end in ends) for axis in "XYZ"), False)


def losses(material):
    """Dependencies that a file cannot represent: the view, the placement, the side, the surroundings, and
    nodes without a comparison."""
    found = set()
    for node in nodes_of(material):
        found.add(LOST.get(node.type))
        outputs = LOST_OUTPUTS.get(node.type, {})
        found |= {outputs.get(output.name) for output in node.outputs if output.is_linked}
        if not {node.type, node.bl_idname} & COMPARED and not node.type.startswith("BSDF_"):
            found.add(f"unknown-node-{node.bl_label.lower().replace(' ', '-')}")
        if node.type == "AMBIENT_OCCLUSION" and not node.only_local:
            found.add(SURROUNDINGS)
        if node.type == "WIREFRAME" and node.use_pixel_size:
            found.add(VIEW)
        if node.type == "TEX_COORD" and node.object and node.outputs["Object"].is_linked:
            found.add(PLACE)
        if node.type == "VECT_TRANSFORM" and {node.convert_from, node.convert_to} != {"OBJECT"}:
            found.add(VIEW if "CAMERA" in {node.convert_from, node.convert_to} else PLACE)
        if node.type in {"TEX_ENVIRONMENT", "TEX_SKY"} and not ("Vector" in node.inputs and node.inputs["Vector"].is_linked):
            found.add(PLACE)
        if node.type in {"BUMP", "NORMAL_MAP", "BEVEL"}:
            # As a colour a normal is the world's.
            is_seen = any(link.to_socket.type in {"RGBA", "VALUE"} for link in node.outputs["Normal"].links)
            found.add(PLACE if is_seen or getattr(node, "space", "TANGENT") in {"WORLD", "BLENDER_WORLD"} else None)
    # An opaque sheet gets a mesh for each side.
    return found - ({None, SIDE} if is_two_sided(material) and not is_transparent(material) else {None})


def backfacing(node):
    """Outputs that depend on the visible side."""
    outputs = node.outputs if node.type == "NEW_GEOMETRY" else ()
    return [output for output in outputs if output.name == "Backfacing" and output.is_linked]


def is_two_sided(material):
    """Whether its sides differ, and it transmits no light."""
    nodes = nodes_of(material)
    return any(map(backfacing, nodes)) and not any(map(is_passing, nodes))


def is_passing(node):
    """Whether a shader transmits light, except by alpha."""
    if node.type == "BSDF_PRINCIPLED":
        return not sheets.is_zero(node, "Transmission Weight") or sheets.is_sheet(node)
    return node.type in {"BSDF_TRANSLUCENT", "BSDF_GLASS", "BSDF_REFRACTION"}


def is_transparent(material):
    """Whether any part may transmit light unscattered."""
    return any(map(is_clear, nodes_of(material)))


def is_clear(node):
    if node.type == "BSDF_PRINCIPLED":
        return node.inputs["Alpha"].is_linked or node.inputs["Alpha"].default_value < 1.0
    return node.type == "BSDF_TRANSPARENT"


def lets_through(material):
    """Whether any light is transmitted."""
    return material is not None and (is_transparent(material) or any(map(is_passing, nodes_of(material))))


def is_of_film(material, sources=FILMS):
    """Whether an image changes from frame to frame, or is from one of `sources`."""
    return any(getattr(node, "image", None) and node.image.source in sources for node in nodes_of(material))


def largest_image(material):
    sizes = [max(node.image.size) for node in nodes_of(material) if node.type == "TEX_IMAGE" and node.image]
    return max(sizes, default=0)
