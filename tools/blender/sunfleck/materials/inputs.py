"""Losses of shaders' inputs.

In goes a material, out come names of losses. Invariant: an unknown input that is linked or differs from
its default is among them, as later Blenders have more inputs.
"""

import bpy

from . import closures, dependence, links, sheets

# Losses by input: None is honoured, or has no effect alone.
OF_PRINCIPLED = {
    **dict.fromkeys((
        "Base Color", "Metallic", "Roughness", "IOR", "Alpha", "Normal", "Weight", "Subsurface Radius", "Subsurface Scale",
        "Subsurface IOR", "Subsurface Anisotropy", "Specular IOR Level", "Specular Tint", "Anisotropic Rotation", "Tangent",
        "Coat Weight", "Coat Roughness", "Coat Normal", "Sheen Roughness", "Sheen Tint", "Emission Color",
        "Emission Strength", "Thin Film IOR", "Transmission Dispersion Abbe Number",
    )),
    "Thin Wall": "thin-wall", "Sheen Weight": "sheen", "Diffuse Roughness": "diffuse-roughness", "Subsurface Weight": "subsurface",
    "Anisotropic": "anisotropy", "Transmission Weight": "transmission", "Transmission Dispersion Scale": "dispersion",
    "Thin Film Thickness": "thin-film", "Coat IOR": "coat-tint", "Coat Tint": "coat-tint",
}
PLAIN = dict.fromkeys(("Color", "Normal", "Weight"))
KNOWN = {
    "BSDF_PRINCIPLED": OF_PRINCIPLED,
    "BSDF_DIFFUSE": {**PLAIN, "Roughness": "diffuse-roughness"},
    "BSDF_TRANSLUCENT": PLAIN,
    "BSDF_TRANSPARENT": {**PLAIN, "Color": "transparent-tint"},
    "EMISSION": {**PLAIN, "Strength": None},
    "BSDF_GLOSSY": {**PLAIN, "Roughness": None, "Rotation": None, "Tangent": None, "Anisotropy": "anisotropy"},
}
# Shaders that are only approximated.
NEARLY = {
    "SUBSURFACE_SCATTERING", "BSDF_SHEEN", "BSDF_VELVET", "BSDF_TOON", "BSDF_HAIR", "BSDF_METALLIC", "BSDF_GLASS",
}


def losses(material):
    return {loss for node in dependence.nodes_of(material) for loss in losses_of(node)}


def losses_of(node):
    # One of the distributions matches the renderer's metal.
    if node.type in NEARLY or getattr(node, "distribution", "MULTI_GGX") != "MULTI_GGX" and node.type == "BSDF_GLOSSY":
        yield f"nearly-{node.type}"
    if node.type == "BSDF_PRINCIPLED":
        yield from losses_of_principled(node)
    if node.type not in KNOWN:
        return
    known, usual = KNOWN[node.type], as_new(node.bl_idname)
    for socket in node.inputs:
        if not socket.enabled or (not links.link_to(socket) and value_of(socket) == usual.get(socket.name)):
            continue
        loss = known.get(socket.name, f"input-{socket.name.lower().replace(' ', '-')}")
        if loss and not does_nothing(node, loss):
            yield loss


def losses_of_principled(node):
    if has_rough_coat(node):
        yield "rough-coat"
    if not sheets.is_zero(node, "Metallic") and not is_white(node.inputs["Specular Tint"]):
        yield "metal-tint"
    # Interreflection among facets of a rough surface.
    roughness = node.inputs["Roughness"]
    is_rough = links.link_to(roughness) is not None or roughness.default_value > closures.ROUGH
    if node.distribution != "MULTI_GGX" and is_rough and not all(sheets.is_zero(node, of) for of in ("Metallic", "Specular IOR Level")):
        yield "single-scattering"


def is_white(socket):
    return not links.link_to(socket) and value_of(socket)[:3] == (1.0, 1.0, 1.0)


def has_rough_coat(node):
    """Whether the coat attenuates more than here, by up to 3 %: since Blender 5.3."""
    roughness = node.inputs["Coat Roughness"]
    is_rough = links.link_to(roughness) is not None or roughness.default_value > 0.5
    return bpy.app.version >= (5, 3) and is_rough and not sheets.is_zero(node, "Coat Weight")


def does_nothing(node, loss):
    """Whether an input has no effect, or is honoured, given the others."""
    if loss == "subsurface":
        return sheets.is_sheet(node)
    if loss == "thin-wall":
        # Metal has the base colour, a uniform share of which remains.
        is_even = not node.inputs["Subsurface Weight"].is_linked
        is_exact = sheets.is_sheet(node) and (is_even or sheets.is_zero(node, "Metallic"))
        return sheets.is_zero(node, "Subsurface Weight") or is_exact
    if loss == "dispersion":
        return sheets.is_zero(node, "Transmission Weight")
    return loss == "coat-tint" and sheets.is_zero(node, "Coat Weight")


_as_new = {}


def as_new(kind):
    """Default values of a new node's inputs, by name."""
    if kind not in _as_new:
        tree = bpy.data.node_groups.new("sunfleck as new", "ShaderNodeTree")
        try:
            _as_new[kind] = {socket.name: value_of(socket) for socket in tree.nodes.new(kind).inputs}
        finally:
            bpy.data.node_groups.remove(tree)
    return _as_new[kind]


def know(owners, trees):
    """Queries all types of nodes in trees, as no node can be created later."""
    for tree in [*(owner.node_tree for owner in owners if owner.node_tree), *trees]:
        for node in tree.nodes:
            if node.type in KNOWN:
                as_new(node.bl_idname)


def value_of(socket):
    value = getattr(socket, "default_value", None)
    return tuple(value) if hasattr(value, "__len__") and not isinstance(value, str) else value
