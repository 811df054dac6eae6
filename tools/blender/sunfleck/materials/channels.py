"""Parts of a shader tree as colours that nodes can compute, for baking.

In go a copy of a node tree and a shader's output in it. Out come parts, each a constant or a socket.
Invariant: parts are weighted by coverage ("cover"), so mixtures of shaders are mixtures of parts.
"""

import math

from . import sheets
from .links import link_to
from .sources import NotSimple

COLORS = ("reflected", "through", "emission")
NUMBERS = ("cover", "roughness", "metallic")
NOTHING = {**dict.fromkeys(COLORS, (0.0, 0.0, 0.0)), **dict.fromkeys(NUMBERS, 0.0)}
# Share of Principled BSDFs in the surface, if it is a constant.
SHINE, UNKNOWN = "shine", math.nan
# Part of an unlinked input of a mix.
BLACK = {**NOTHING, "cover": 1.0}
# Shaders of one colour: their part, roughness and metallic factor (None: by their socket).
PLAIN = {
    **dict.fromkeys(
        ("BSDF_DIFFUSE", "SUBSURFACE_SCATTERING", "BSDF_SHEEN", "BSDF_VELVET", "BSDF_TOON", "BSDF_HAIR"), ("reflected", 1.0, 0.0)
    ),
    **dict.fromkeys(("BSDF_GLOSSY", "BSDF_ANISOTROPIC", "BSDF_METALLIC"), ("reflected", None, 1.0)),
    "BSDF_TRANSLUCENT": ("through", 1.0, 0.0), "BSDF_GLASS": ("reflected", None, 0.0),
}


class Channels:
    """Computes parts in one tree."""

    def __init__(self, tree):
        self.tree, self.bends, self.principled = tree, False, []
        # Types of shaders that are only metal, and that are matte; whether any are added.
        self.metals, self.mattes, self.adds = set(), set(), False

    def of(self, output):
        """Parts of a shader's output."""
        node = output.node
        if node.mute:
            raise NotSimple(node)
        if output.type != "SHADER":
            # A colour linked to a shader input is emission.
            return {**BLACK, "emission": output}
        if node.type == "GROUP":
            return self.of_group(node, output)
        if node.type == "MIX_SHADER":
            share, a, b = node.inputs
            return self.mixed(self.value(share), self.of_input(a), self.of_input(b))
        if node.type == "ADD_SHADER":
            a, b = (self.of_input(socket, NOTHING) for socket in node.inputs)
            self.adds |= not any(same(one["reflected"], 0.0) for one in (a, b))
            found = {name: self.sum(a[name], b[name]) for name in NOTHING}
            found[SHINE] = shine_of(0.5, a, b)
            # Emission is on top of the existing surface.
            covers = [one["cover"] for one in (a, b) if not is_light(one)] or [1.0]
            return {**found, "cover": covers[0] if len(covers) == 1 else self.most(*covers)}
        if node.type == "BSDF_TRANSPARENT":
            return dict(NOTHING)
        if node.type == "EMISSION":
            return {**BLACK, "emission": self.product(self.value(node.inputs["Color"]), self.value(node.inputs["Strength"]))}
        if node.type == "BSDF_PRINCIPLED":
            return self.of_principled(node)
        return self.of_plain(node)

    def of_input(self, socket, unlinked=BLACK):
        link = link_to(socket)
        return self.of(link.from_socket) if link else dict(unlinked)

    def of_plain(self, node):
        if node.type not in PLAIN:
            raise NotSimple(node)
        part, roughness, metallic = PLAIN[node.type]
        color = next(socket for socket in node.inputs if socket.name in {"Color", "Base Color"})
        self.note_normal(node)
        (self.metals if metallic else self.mattes).add(node.type)
        found = {**NOTHING, part: self.value(color), "cover": 1.0, "metallic": metallic}
        return {**found, "roughness": self.value(node.inputs["Roughness"]) if roughness is None else roughness}

    def of_principled(self, node):
        self.principled.append(node)
        self.note_normal(node)
        cover = self.share(node.inputs["Alpha"])
        emission = self.product(self.value(node.inputs["Emission Color"]), self.value(node.inputs["Emission Strength"]))
        base, share = self.product(self.value(node.inputs["Base Color"]), cover), 0.0
        if sheets.is_sheet(node):
            share = self.product(self.value(node.inputs["Subsurface Weight"]), sheets.through(node))
        return {
            "reflected": self.mix(share, base, 0.0), "through": self.product(base, share),
            "emission": self.product(emission, cover), "cover": cover,
            "roughness": self.product(self.value(node.inputs["Roughness"]), cover),
            "metallic": self.product(self.value(node.inputs["Metallic"]), cover), SHINE: 1.0,
        }

    def note_normal(self, node):
        self.bends |= any(socket.name in {"Normal", "Coat Normal"} and link_to(socket) is not None for socket in node.inputs)

    def of_group(self, node, output):
        """Parts of a group, computed inside and output from it."""
        node.node_tree = inner = node.node_tree.copy()
        end = next((one for one in inner.nodes if one.type == "GROUP_OUTPUT" and one.is_active_output), None)
        within = Channels(inner)
        link = link_to(end.inputs[list(node.outputs).index(output)]) if end else None
        parts = within.of(link.from_socket) if link else dict(NOTHING)
        self.bends |= within.bends
        self.principled += within.principled
        self.metals |= within.metals
        self.mattes |= within.mattes
        self.adds |= within.adds
        found = {}
        for name, part in parts.items():
            if not is_socket(part):
                found[name] = part
                continue
            kind = "NodeSocketColor" if name in COLORS else "NodeSocketFloat"
            inner.interface.new_socket(f"sunfleck {name}", in_out="OUTPUT", socket_type=kind)
            inner.links.new(part, end.inputs[f"sunfleck {name}"])
            found[name] = node.outputs[f"sunfleck {name}"]
        return found

    # Arithmetic of constants and sockets.

    def value(self, socket):
        link = link_to(socket)
        if link:
            source = link.from_socket
            return self.number(source) if socket.type == "VALUE" and source.type in {"RGBA", "VECTOR"} else source
        value = socket.default_value
        return tuple(value[:3]) if hasattr(value, "__len__") else float(value)

    def share(self, socket):
        """Number clamped to 0 and 1."""
        value = self.value(socket)
        if not is_socket(value):
            return min(1.0, max(0.0, value))
        found = self.number(value)
        found.node.use_clamp = True
        return found

    def number(self, colour):
        """Number from a colour, by the rule of the target socket."""
        made = self.tree.nodes.new("ShaderNodeMath")
        made.operation, made.inputs[1].default_value = "ADD", 0.0
        self.tree.links.new(colour, made.inputs[0])
        return made.outputs[0]

    def mixed(self, share, a, b):
        return {**{name: self.mix(share, a[name], b[name]) for name in NOTHING}, SHINE: shine_of(share, a, b)}

    def mix(self, share, a, b):
        if not is_socket(share):
            share = min(1.0, max(0.0, share if isinstance(share, float) else share[0]))
            if share in (0.0, 1.0):
                return b if share else a
        return a if same(a, b) else self.node("MIX", a, b, share)

    def product(self, a, b):
        if isinstance(a, float) and isinstance(b, float):
            return a * b
        if same(a, 1.0):
            return b
        if same(b, 1.0):
            return a
        return 0.0 if same(a, 0.0) or same(b, 0.0) else self.node("MULTIPLY", a, b)

    def sum(self, a, b):
        if same(a, 0.0):
            return b
        return a if same(b, 0.0) else self.node("ADD", a, b)

    def most(self, a, b):
        return 1.0 if same(a, 1.0) or same(b, 1.0) else self.node("LIGHTEN", a, b)

    def node(self, blend, a, b, share=1.0):
        made = self.tree.nodes.new("ShaderNodeMix")
        made.data_type, made.blend_type, made.clamp_result = "RGBA", blend, False
        inputs = {socket.identifier: socket for socket in made.inputs}
        for name, value in (("Factor_Float", share), ("A_Color", a), ("B_Color", b)):
            self.give(inputs[name], value)
        return next(socket for socket in made.outputs if socket.identifier == "Result_Color")

    def give(self, socket, value):
        """Links a socket, or sets its value."""
        if is_socket(value):
            self.tree.links.new(value, socket)
        elif hasattr(socket.default_value, "__len__"):
            color = tuple(value) if isinstance(value, tuple) else (value,) * 3
            socket.default_value = (*color, 1.0)
        else:
            socket.default_value = value[0] if isinstance(value, tuple) else value


def shine_of(share, a, b):
    """Gloss share of a mixture; absent parts have none."""
    shines = [one.get(SHINE, 0.0) for one in (a, b) if not same(one["cover"], 0.0)] or [0.0]
    if min(shines) == max(shines):
        return shines[0]
    is_told = isinstance(share, float) and same(a["cover"], 1.0) and same(b["cover"], 1.0)
    return shines[0] + min(1.0, max(0.0, share)) * (shines[1] - shines[0]) if is_told else UNKNOWN


def is_light(parts):
    return same(parts["reflected"], 0.0) and same(parts["through"], 0.0) and same(parts["cover"], 1.0)


def is_socket(value):
    return not isinstance(value, (float, tuple))


def same(value, other):
    """Whether a constant is this number, or two constants are equal."""
    if is_socket(value) or is_socket(other):
        return value == other
    spread = lambda one: one if isinstance(one, tuple) else (one,) * 3
    return spread(value) == spread(other)
