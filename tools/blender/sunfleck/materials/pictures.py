"""Image textures as glTF has words for them.

In go nodes, out come a `Source` of a picture, and where it is looked up. Invariant: it is what Cycles shows, between
its texels and by its alpha too.
"""

import math

from .links import link_to
from .sources import NotSimple, Picture, Source

# Of what has 8 bits; a bake knows the others.
KNOWN_SPACES = {"sRGB", "Non-Color", "Linear Rec.709"}
# Texels of the longer side of a picture: bakes have twice as many.
COARSE = 256
# Ways between texels that glTF has no word for.
OTHER_FILTERS = {"Closest", "Cubic", "Smart"}


def read_image(node, output):
    image = node.image
    if image is None or node.projection != "FLAT" or image.source not in {"FILE", "GENERATED"}:
        raise NotSimple(node)
    # Of a Cineon file Cycles shows the logarithms as they are, Blender what they stand for.
    if image.file_format == "CINEON" or has_odd_alpha(image) or not (image.is_float or image.colorspace_settings.name in KNOWN_SPACES):
        raise NotSimple(node)
    place = coordinates(node.inputs["Vector"])
    # Nothing beyond its edges, and other smoothing, which a bake of many texels has too: glTF has no word for these.
    is_coarse = node.interpolation in OTHER_FILTERS and max(image.size) <= COARSE
    if is_coarse or is_moved(node) or (node.extension == "CLIP" and "scale" in place):
        raise NotSimple(node)
    alpha = by_alpha(node) if output.name == "Color" else ""
    picture = Picture(image, extension=node.extension, interpolation=node.interpolation, by_alpha=alpha, **place)
    return Source((1.0, 1.0, 1.0), picture, 3 if output.name == "Alpha" else "rgb")


def is_moved(node):
    """Whether a texture's own panel moves what it shows about."""
    moves = node.texture_mapping
    axes = (moves.mapping_x, moves.mapping_y, moves.mapping_z)
    is_as_new = (*moves.translation, *moves.rotation) == (0.0,) * 6 and tuple(moves.scale) == (1.0,) * 3
    return not is_as_new or axes != ("X", "Y", "Z") or moves.vector_type == "NORMAL"


# Depths of pictures with an alpha: of 8 bits, of 16 and of floats.
WITH_ALPHA = {32, 64, 128}
# Whether alpha is in the colours, as files of a format usually have it.
USUAL_ALPHA = {"PNG": "STRAIGHT", "OPEN_EXR": "PREMUL", "OPEN_EXR_MULTILAYER": "PREMUL"}


def has_odd_alpha(image):
    """Whether its colours are said to have alpha in them or not otherwise than usual: there Blender and Cycles
    differ, and so do Cycles' versions."""
    is_simple = image.depth not in WITH_ALPHA or image.alpha_mode not in {"STRAIGHT", "PREMUL"}
    usual = "STRAIGHT" if image.depth == 32 else USUAL_ALPHA.get(image.file_format) if image.source == "FILE" else None
    return not is_simple and image.alpha_mode != usual


def by_alpha(node):
    """Colours are multiplied by alpha where nobody asks for it. Where someone does they are divided again, of 8 bits
    by what is left of them."""
    image, is_asked = node.image, node.outputs["Alpha"].is_linked
    if image.depth not in WITH_ALPHA or image.colorspace_settings.is_data:
        return ""
    if image.alpha_mode == "STRAIGHT":
        return "" if is_asked and image.depth > 32 else "there and back" if is_asked else "times"
    return "over" if is_asked and image.alpha_mode == "PREMUL" else ""


def coordinates(socket):
    """Which texture coordinates, and how they are moved about."""
    link = link_to(socket)
    if link is None:
        return {"uv": ""}
    node = link.from_node
    if node.type == "UVMAP" and not node.from_instancer:
        return {"uv": node.uv_map}
    if node.type == "TEX_COORD" and link.from_socket.name == "UV" and not node.from_instancer:
        return {"uv": ""}
    if node.type == "ATTRIBUTE" and node.attribute_type == "GEOMETRY" and link.from_socket.name == "Vector":
        return {"uv": node.attribute_name}
    if node.type != "MAPPING" or node.mute:
        raise NotSimple(node)
    return {**coordinates(node.inputs["Vector"]), **mapped(node)}


def mapped(node):
    """A Mapping node as KHR_texture_transform, which turns about the top left corner and has v downwards."""
    inner = link_to(node.inputs["Vector"])
    if inner is None or inner.from_node.type == "MAPPING" or node.vector_type != "POINT":
        raise NotSimple(node)
    if any(link_to(node.inputs[name]) for name in ("Location", "Rotation", "Scale")):
        raise NotSimple(node)
    location, rotation, scale = (
        node.inputs[name].default_value for name in ("Location", "Rotation", "Scale")
    )
    if abs(rotation[0]) > 1e-6 or abs(rotation[1]) > 1e-6:
        raise NotSimple(node)
    angle = rotation[2]
    # Blender: p = R(angle) S uv + location, v upwards. With v' = 1 - v the same is R(-angle) S uv' +
    # offset in v downwards.
    offset = (
        location[0] - scale[1] * math.sin(angle),
        1.0 - location[1] - scale[1] * math.cos(angle),
    )
    return {"offset": offset, "rotation": angle, "scale": (scale[0], scale[1])}
