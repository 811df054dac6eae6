"""What gives a socket's value, where that is simple.

In goes a socket, out comes a `Source`. Invariant: the source is exact; anything more complex raises
`NotSimple` with the node's name. Groups are followed.
"""

import colorsys
from dataclasses import replace

from . import blackbody
from .links import behind, link_to
from .pictures import read_image
from .sources import NotSimple, Source, clamped, grey, product

CHANNELS = {"Red": 0, "Green": 1, "Blue": 2, "X": 0, "Y": 1, "Z": 2}


def of(socket):
    """Source of an input."""
    link = link_to(socket)
    if link is None:
        return constant(socket)
    source = of_output(link.from_socket)
    if socket.type != "VALUE" or link.from_socket.type not in {"RGBA", "VECTOR"}:
        return source
    return grey(link.from_node, source, is_vector=link.from_socket.type == "VECTOR")


def constant(socket):
    value = getattr(socket, "default_value", 0.0)
    return Source(tuple(value[:3]) if hasattr(value, "__len__") else (float(value),) * 3)


def constants(node, inputs):
    """Values of inputs that all have to be constant."""
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


def read_mix(node, output):
    if node.data_type not in {"RGBA", "FLOAT"} or (node.data_type == "RGBA" and node.blend_type not in {"MULTIPLY", "MIX"}):
        raise NotSimple(node)
    factor, a, b = (
        next(socket for socket in node.inputs if socket.enabled and socket.name == name)
        for name in ("Factor", "A", "B")
    )
    found = mixed(node, of(factor), of(a), of(b))
    return clamped(node, found) if node.clamp_result and node.data_type == "RGBA" else found


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
    """Constants only."""
    names = ("Hue", "Saturation", "Value", "Fac" if "Fac" in node.inputs else "Factor", "Color")
    hue, saturation, value, share, color = constants(node, (node.inputs[name] for name in names))
    h, s, v = colorsys.rgb_to_hsv(*color.factor)
    saturated = min(1.0, max(0.0, s * saturation.number()))
    turned = colorsys.hsv_to_rgb((h + hue.number() + 0.5) % 1.0, saturated, v * value.number())
    weight = share.number()
    return Source(tuple(max(0.0, (1.0 - weight) * old + weight * new) for old, new in zip(color.factor, turned)))


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
    """Vertex colours; the mesh decides which of them it has."""
    if node.type == "ATTRIBUTE" and node.attribute_type != "GEOMETRY":
        raise NotSimple(node)
    name = node.layer_name if node.type == "VERTEX_COLOR" else node.attribute_name
    if output.name not in {"Color", "Alpha"}:
        raise NotSimple(node)
    return Source((1.0, 1.0, 1.0), attribute=name, attribute_channel=3 if output.name == "Alpha" else "rgb")


# Inputs that the readers handle; any other linked input, as of later Blenders, is left to Cycles.
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
    "TEX_IMAGE": read_image, "MIX": read_mix, "MIX_RGB": read_mix_legacy, "MATH": read_math, "VALTORGB": read_ramp,
    "HUE_SAT": read_hue, "MAP_RANGE": read_range, "BLACKBODY": read_blackbody,
    **dict.fromkeys(("SEPARATE_COLOR", "SEPRGB", "SEPXYZ"), read_separate),
    **dict.fromkeys(("COMBINE_COLOR", "COMBXYZ"), read_combine),
    **dict.fromkeys(("VERTEX_COLOR", "ATTRIBUTE"), read_attribute),
    **dict.fromkeys(("RGB", "VALUE"), lambda node, output: constant(output)),
}
