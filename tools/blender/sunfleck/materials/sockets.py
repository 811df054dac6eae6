"""What gives a socket's value, where that is simple: a constant, a picture, a colour attribute,
or a product of those.

In goes a socket, out comes a `Source`. Invariant: the source is exact; whatever is more involved is
`NotSimple`, by the node's name. Groups are looked through.
"""

import colorsys
import math
from contextlib import contextmanager
from dataclasses import dataclass, replace

from . import blackbody

CHANNELS = {"Red": 0, "Green": 1, "Blue": 2, "X": 0, "Y": 1, "Z": 2}
# Of what has 8 bits; a bake knows the others.
KNOWN_SPACES = {"sRGB", "Non-Color", "Linear Rec.709"}
# Texels of the longer side of a picture: bakes have twice as many.
COARSE = 256
# Ways between texels that glTF has no word for.
OTHER_FILTERS = {"Closest", "Cubic", "Smart"}
# Of a colour in linear Rec. 709.
BRIGHTNESS = (0.2126, 0.7152, 0.0722)


class NotSimple(Exception):
    """The node that is more than glTF has words for."""


@dataclass(frozen=True)
class Picture:
    """An image as a node shows it."""

    image: object
    # Where it is looked up: the name of texture coordinates ("" for those that render), and
    # glTF's transform of them.
    uv: str
    offset: tuple = (0.0, 0.0)
    rotation: float = 0.0
    scale: tuple = (1.0, 1.0)
    extension: str = "REPEAT"
    interpolation: str = "Linear"
    # What Cycles does to its colours by its alpha: "times", "over", "there and back" or nothing.
    by_alpha: str = ""

    def place(self):
        return (self.uv, self.offset, self.rotation, self.scale, self.extension, self.interpolation)


@dataclass(frozen=True)
class Source:
    """`factor` (three numbers) times a picture's channel ("rgb", "grey", 0, 1, 2 or 3 for alpha) times a
    colour attribute's."""

    factor: tuple
    picture: Picture | None = None
    channel: object = "rgb"
    attribute: str | None = None
    attribute_channel: object = "rgb"

    def is_constant(self):
        return self.picture is None and self.attribute is None

    def number(self):
        """Of a constant: Blender makes numbers of colours by their brightness."""
        r, g, b = self.factor
        return r if r == g == b else sum(weight * channel for weight, channel in zip(BRIGHTNESS, self.factor))


def of(socket):
    """What gives an input's value."""
    link = link_to(socket)
    if link is None:
        return constant(socket)
    source = of_output(link.from_socket)
    if socket.type != "VALUE" or link.from_socket.type not in {"RGBA", "VECTOR"}:
        return source
    return grey(link.from_node, source, is_vector=link.from_socket.type == "VECTOR")


def grey(node, source, is_vector):
    """As Blender makes a number: of a colour its brightness, of a vector its mean."""
    number = sum(source.factor) / 3.0 if is_vector else source.number()
    if source.is_constant():
        return Source((number,) * 3)
    is_color = "rgb" in (source.picture and source.channel, source.attribute is not None and source.attribute_channel)
    if not is_color:
        return replace(source, factor=(number,) * 3)
    if source.attribute is not None or is_vector or len(set(source.factor)) > 1:
        raise NotSimple(node)
    return replace(source, channel="grey")


def link_to(socket):
    """The link that counts; reroutes and muted nodes are passed through. What leads nowhere is none, as in Cycles."""
    while socket is not None and socket.is_linked and socket.links and not socket.links[0].is_muted:
        link = socket.links[0]
        if link.from_node.type == "REROUTE":
            socket = link.from_node.inputs[0]
        elif link.from_node.mute:
            within = link.from_node.internal_links
            socket = next((one.from_socket for one in within if one.to_socket == link.from_socket), None)
        else:
            return link
    return None


def constant(socket):
    value = getattr(socket, "default_value", 0.0)
    return Source(tuple(value[:3]) if hasattr(value, "__len__") else (float(value),) * 3)


def constants(node, inputs):
    """Of inputs that all have to be constant."""
    sources = [of(socket) for socket in inputs]
    if not all(source.is_constant() for source in sources):
        raise NotSimple(node)
    return sources


def of_output(output):
    node = output.node
    if node.mute:
        raise NotSimple(node)
    if node.type in {"GROUP", "GROUP_INPUT"}:
        with behind(output) as socket:
            return of(socket)
    read = READERS.get(node.type)
    if read is None or any(socket.enabled and socket.is_linked and socket.name not in KNOWN for socket in node.inputs):
        raise NotSimple(node)
    return read(node, output)


# The group nodes within which one looks, the innermost last.
_groups = []


@contextmanager
def behind(output):
    """The socket that an output of a group, or of its input node, takes its value from."""
    node = output.node
    if node.type == "GROUP":
        nodes = node.node_tree.nodes if node.node_tree else ()
        ends = [one for one in nodes if one.type == "GROUP_OUTPUT" and one.is_active_output]
        before, after, sockets = _groups[:], [*_groups, node], ends[0].inputs if ends else ()
    elif _groups:
        before, after, sockets = _groups[:], _groups[:-1], _groups[-1].inputs
    else:
        raise NotSimple(node)
    found = next((socket for socket in sockets if socket.identifier == output.identifier), None)
    if found is None:
        raise NotSimple(node)
    _groups[:] = after
    try:
        yield found
    finally:
        _groups[:] = before


def product(node, a, b):
    """Both factors; at most one picture and one attribute among them."""
    if (a.picture and b.picture) or (a.attribute is not None and b.attribute is not None):
        raise NotSimple(node)
    with_picture, with_attribute = (a if a.picture else b), (a if a.attribute is not None else b)
    return Source(
        tuple(x * y for x, y in zip(a.factor, b.factor)), with_picture.picture, with_picture.channel,
        with_attribute.attribute, with_attribute.attribute_channel,
    )


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
    picture = Picture(
        image,
        extension=node.extension,
        interpolation=node.interpolation,
        by_alpha=by_alpha(node) if output.name == "Color" else "",
        **place,
    )
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


def read_mix(node, output):
    if node.data_type not in {"RGBA", "FLOAT"} or (node.data_type == "RGBA" and node.blend_type not in {"MULTIPLY", "MIX"}):
        raise NotSimple(node)
    factor, a, b = (
        next(socket for socket in node.inputs if socket.enabled and socket.name == name)
        for name in ("Factor", "A", "B")
    )
    found = mixed(node, of(factor), of(a), of(b))
    return clamped(node, found) if node.clamp_result and node.data_type == "RGBA" else found


def clamped(node, source):
    """From 0 to 1."""
    if source.is_constant():
        return Source(tuple(min(1.0, max(0.0, channel)) for channel in source.factor))
    if source.attribute is not None or source.picture.image.is_float or not 0.0 <= min(source.factor) <= max(source.factor) <= 1.0:
        raise NotSimple(node)
    return source


def read_mix_legacy(node, output):
    if node.blend_type not in {"MULTIPLY", "MIX"} or node.use_clamp:
        raise NotSimple(node)
    return mixed(node, of(node.inputs["Fac"]), of(node.inputs["Color1"]), of(node.inputs["Color2"]))


def mixed(node, factor, a, b):
    if not factor.is_constant():
        raise NotSimple(node)
    share = factor.number()
    share = min(1.0, max(0.0, share)) if getattr(node, "clamp_factor", True) else share
    if node.blend_type == "MULTIPLY" and getattr(node, "data_type", "RGBA") == "RGBA":
        if share == 1.0:
            return product(node, a, b)
        if b.is_constant():
            return product(node, a, Source(tuple(1.0 - share + share * value for value in b.factor)))
    elif share in (0.0, 1.0):
        return b if share else a
    elif a.is_constant() and b.is_constant():
        return Source(tuple((1.0 - share) * x + share * y for x, y in zip(a.factor, b.factor)))
    raise NotSimple(node)


def read_separate(node, output):
    if getattr(node, "mode", "RGB") != "RGB":
        raise NotSimple(node)
    inner = of(node.inputs[0])
    channel = CHANNELS[output.name]
    if inner.is_constant():
        return Source((inner.factor[channel],) * 3)
    if inner.channel != "rgb" or inner.attribute is not None:
        raise NotSimple(node)
    return replace(inner, factor=(inner.factor[channel],) * 3, channel=channel)


def read_math(node, output):
    a, b = of(node.inputs[0]), of(node.inputs[1])
    if node.operation == "MULTIPLY" and not node.use_clamp:
        return product(node, a, b)
    if not (a.is_constant() and b.is_constant()) or node.operation not in ARITHMETIC:
        raise NotSimple(node)
    value = ARITHMETIC[node.operation](a.number(), b.number())
    return Source((min(1.0, max(0.0, value)) if node.use_clamp else value,) * 3)


def read_ramp(node, output):
    value = constants(node, node.inputs[:1])[0]
    color = node.color_ramp.evaluate(value.number())
    return Source((color[3],) * 3 if output.name == "Alpha" else tuple(color[:3]))


def read_hue(node, output):
    """Of constants alone."""
    names = ("Hue", "Saturation", "Value", "Fac" if "Fac" in node.inputs else "Factor", "Color")
    hue, saturation, value, share, color = constants(node, (node.inputs[name] for name in names))
    h, s, v = colorsys.rgb_to_hsv(*color.factor)
    turned = colorsys.hsv_to_rgb(
        (h + hue.number() + 0.5) % 1.0, min(1.0, max(0.0, s * saturation.number())), v * value.number()
    )
    weight = share.number()
    return Source(
        tuple(max(0.0, (1.0 - weight) * old + weight * new) for old, new in zip(color.factor, turned))
    )


def read_range(node, output):
    if node.data_type != "FLOAT" or node.interpolation_type != "LINEAR":
        raise NotSimple(node)
    names = ("Value", "From Min", "From Max", "To Min", "To Max")
    there = {socket.name: socket for socket in node.inputs if socket.enabled}
    sources = constants(node, (there[name] for name in names))
    value, from_low, from_high, low, high = (source.number() for source in sources)
    share = (value - from_low) / (from_high - from_low) if from_high != from_low else 0.0
    share = min(1.0, max(0.0, share)) if node.clamp else share
    return Source((low + share * (high - low),) * 3)


def read_blackbody(node, output):
    return Source(blackbody.color(constants(node, [node.inputs["Temperature"]])[0].number()))


def read_combine(node, output):
    """Three constants."""
    if getattr(node, "mode", "RGB") != "RGB":
        raise NotSimple(node)
    return Source(tuple(source.number() for source in constants(node, node.inputs[:3])))


def read_attribute(node, output):
    """Colours of vertices; which of them a mesh has is seen there."""
    if node.type == "ATTRIBUTE" and node.attribute_type != "GEOMETRY":
        raise NotSimple(node)
    name = node.layer_name if node.type == "VERTEX_COLOR" else node.attribute_name
    if output.name not in {"Color", "Alpha"}:
        raise NotSimple(node)
    return Source((1.0, 1.0, 1.0), attribute=name, attribute_channel=3 if output.name == "Alpha" else "rgb")


# Inputs that the readers read: whatever else is linked, in later Blenders, is left to Cycles.
KNOWN = {
    "Vector", "Factor", "Fac", "A", "B", "Color1", "Color2", "Color", "Image", "Value", "Hue", "Saturation", "From Min",
    "From Max", "To Min", "To Max", "Red", "Green", "Blue", "X", "Y", "Z", "Temperature",
}
ARITHMETIC = {
    "ADD": lambda a, b: a + b,
    "SUBTRACT": lambda a, b: a - b,
    "DIVIDE": lambda a, b: a / b if b else 0.0,
    "MINIMUM": min,
    "MAXIMUM": max,
}
READERS = {
    "TEX_IMAGE": read_image,
    "MIX": read_mix,
    "MIX_RGB": read_mix_legacy,
    "SEPARATE_COLOR": read_separate,
    "SEPRGB": read_separate,
    "SEPXYZ": read_separate,
    "MATH": read_math,
    "VERTEX_COLOR": read_attribute,
    "ATTRIBUTE": read_attribute,
    "VALTORGB": read_ramp,
    "HUE_SAT": read_hue,
    "MAP_RANGE": read_range,
    "COMBINE_COLOR": read_combine,
    "COMBXYZ": read_combine,
    "BLACKBODY": read_blackbody,
    "RGB": lambda node, output: constant(output),
    "VALUE": lambda node, output: constant(output),
}
