"""Principled BSDFs in glTF's terms.

In goes a node tree, out comes a `Surface`: sources by purpose. Invariant: features that glTF lacks are in
`losses`, by id; a socket without a simple source raises `NotSimple`.
"""

from dataclasses import dataclass, field, replace

from . import links, sheets, sockets
from .sources import BLACK, WHITE, NotSimple, Source

# Blender's sockets by their names here.
SOCKETS = {
    "base": "Base Color", "metallic": "Metallic", "roughness": "Roughness", "ior": "IOR", "specular": "Specular IOR Level",
    "specular_tint": "Specular Tint", "transmission": "Transmission Weight", "coat": "Coat Weight", "coat_roughness": "Coat Roughness",
    "sheen": "Sheen Weight", "sheen_roughness": "Sheen Roughness", "sheen_tint": "Sheen Tint", "emission": "Emission Color",
    "emission_strength": "Emission Strength",
}
# No gloss.
MATTE = {"specular": BLACK, "roughness": WHITE}


@dataclass
class Surface:
    """Sources by name, and the use of alpha."""

    sources: dict = field(default_factory=dict)
    alpha: Source = WHITE
    # None is coverage; otherwise the cutoff of a mask.
    cutoff: float | None = None
    # Picture and strength.
    normal: tuple | None = None
    coat_normal: tuple | None = None
    # Whether metal reflects equally at all angles.
    has_even_metal: bool = False
    # Whether a dielectric is one face of a solid, and not a thin wall.
    has_one_face: bool = False
    # Factors on the light that the gloss removes from the base colour, and from transmission.
    shine_takes: tuple | None = None
    losses: list = field(default_factory=list)

    def pictures(self):
        """All pictures."""
        found = [source.picture for source in (*self.sources.values(), self.alpha) if source.picture]
        return found + [bent[0] for bent in (self.normal, self.coat_normal) if bent]

    def share_through(self):
        """Transmitted share of the light that is not absorbed, such that both colours stay within 1."""
        through = self.sources.get("through")
        if through is None or max(through.factor) == 0.0:
            return 0.0
        base = self.sources.get("base", WHITE)
        return max(through.factor) / max(max(through.factor) + max(base.factor), max(through.factor) / 0.999)


def output_of(tree):
    """Output node that renders: Cycles' own if there is one."""
    return tree.get_output_node("CYCLES")


def surface_link(material):
    """Link to a material's surface; None without one."""
    output = output_of(material.node_tree) if material.node_tree else None
    return links.link_to(output.inputs["Surface"]) if output else None


def read(shader):
    """Surface of a Principled BSDF, or of a plain diffuse one."""
    if shader.type == "BSDF_DIFFUSE":
        return diffuse(shader)
    if shader.type == "EMISSION":
        return emission(sockets.of(shader.inputs["Color"]), sockets.of(shader.inputs["Strength"]))
    if shader.type == "BSDF_GLOSSY":
        return glossy(shader)
    if shader.type != "BSDF_PRINCIPLED" or shader.mute:
        raise NotSimple(shader)
    surface = Surface({name: sockets.of(shader.inputs[socket]) for name, socket in SOCKETS.items()})
    surface.alpha, surface.cutoff = alpha(shader.inputs["Alpha"])
    surface.normal, surface.coat_normal = normal(shader.inputs["Normal"]), normal(shader.inputs["Coat Normal"])
    if sheets.is_sheet(shader):
        weight, base = sockets.of(shader.inputs["Subsurface Weight"]), surface.sources["base"]
        if not weight.is_constant():
            raise NotSimple(shader)
        share = sheets.unit(weight.number()) * sheets.through(shader)
        surface.sources["base"], surface.sources["through"] = scaled(base, 1.0 - share), scaled(base, share)
    if surface.sources["ior"].is_constant() and surface.sources["ior"].number() < 1.0:
        surface.losses.append("ior-below-one")
    frost(surface, sheets.is_thin_wall(shader))
    scatter(surface)
    return surface


def frost(surface, is_thin):
    """Rough transmission of a thin wall, or rough refraction at a face, with constant parameters."""
    transmission, ior, roughness, tint = (
        surface.sources[name] for name in ("transmission", "ior", "roughness", "specular_tint")
    )
    if not (transmission.is_constant() and ior.is_constant() and tint == WHITE):
        return
    is_rough = sheets.is_frosted if is_thin else sheets.is_rough
    if transmission.number() > 0.0 and (not roughness.is_constant() or is_rough(roughness.number(), ior.number())):
        surface.sources["thin"], surface.sources["transmission"] = transmission, BLACK
        surface.has_one_face = not is_thin


def scatter(surface):
    """Rough transmission is scattered: of the transmitted share, the roughness is the diffuse part, and
    the rest passes straight. This approximates Cycles, light included."""
    transmission, roughness = (surface.sources.get(name) for name in ("transmission", "roughness"))
    if not (transmission and transmission.is_constant() and roughness.is_constant()):
        return
    weight, rough = (sheets.unit(source.number()) for source in (transmission, roughness))
    if weight * rough == 0.0 or "through" in surface.sources:
        return
    through, straight = weight * rough, weight * (1.0 - rough)
    base, left = surface.sources["base"], max(1e-6, 1.0 - straight)
    surface.sources["through"] = scaled(base, through / left)
    surface.sources["base"] = scaled(base, max(1.0 - weight, 1e-3 * through) / left)
    surface.sources["transmission"] = Source((straight,) * 3)


def scaled(source, share):
    return replace(source, factor=tuple(share * channel for channel in source.factor))


def diffuse(shader):
    """Lambertian surface: a Principled BSDF without specular reflection."""
    return Surface({"base": sockets.of(shader.inputs["Color"]), **MATTE}, normal=normal(shader.inputs["Normal"]))


def glossy(shader):
    """A mirror of microfacets, whatever the angle: metal that reflects alike."""
    if shader.mute or shader.distribution != "MULTI_GGX" or links.link_to(shader.inputs["Normal"]):
        raise NotSimple(shader)
    base, roughness = sockets.of(shader.inputs["Color"]), sockets.of(shader.inputs["Roughness"])
    return Surface({"base": base, "metallic": WHITE, "specular": BLACK, "roughness": roughness}, has_even_metal=True)


def emission(color, strength=WHITE):
    """Emission alone, without reflection."""
    return Surface({"emission": color, "emission_strength": strength, "base": BLACK, **MATTE})


def alpha(socket):
    """Its source and, of a mask, the alpha from which on there is something."""
    link = links.link_to(socket)
    node = link.from_node if link else None
    if node is None or node.type != "MATH" or node.mute:
        return sockets.of(socket), None
    if node.operation == "ROUND":
        return sockets.of(node.inputs[0]), 0.5
    if node.operation == "GREATER_THAN":
        return sockets.of(node.inputs[0]), still(node, node.inputs[1])
    if node.operation == "LESS_THAN" and not links.link_to(node.inputs[0]):
        return sockets.of(node.inputs[1]), still(node, node.inputs[0])
    if node.operation == "SUBTRACT" and not links.link_to(node.inputs[0]) and node.inputs[0].default_value == 1.0:
        inner = links.link_to(node.inputs[1])
        if inner and inner.from_node.type == "MATH" and inner.from_node.operation == "LESS_THAN":
            return sockets.of(inner.from_node.inputs[0]), still(node, inner.from_node.inputs[1])
    return sockets.of(socket), None


def still(node, socket):
    source = sockets.of(socket)
    if not source.is_constant():
        raise NotSimple(node)
    return source.number()


def normal(socket):
    """Picture and strength of a normal map in tangent space; None if nothing bends the normal."""
    link = links.link_to(socket)
    if link is None:
        return None
    node = link.from_node
    if node.type != "NORMAL_MAP" or node.space != "TANGENT" or node.mute:
        raise NotSimple(node)
    source = sockets.of(node.inputs["Color"])
    if replace(source, picture=None) != WHITE or source.picture is None:
        raise NotSimple(node)
    if node.uv_map and source.picture.uv not in {"", node.uv_map}:
        raise NotSimple(node)
    return source.picture, still(node, node.inputs["Strength"])
