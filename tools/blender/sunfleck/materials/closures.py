"""Mixed shaders that glTF can represent exactly: with transparency, translucency or emission.

In goes a shader node, out comes a `Surface`. Invariant: any other mixture raises `NotSimple`, and is
baked.
"""

from dataclasses import replace

from . import links, principled, sockets
from .principled import MATTE, Surface
from .sources import BLACK, WHITE, NotSimple, Source

# Roughness from which interreflection of facets is visible.
ROUGH = 0.3


def read(link):
    """Surface of a link to a shader."""
    node = link.from_node
    if node.mute:
        raise NotSimple(node)
    if link.from_socket.type != "SHADER":
        # A colour linked to a shader input is emission.
        return principled.emission(sockets.of_output(link.from_socket))
    if node.type in {"GROUP", "GROUP_INPUT"}:
        with links.behind(link.from_socket) as socket:
            return of_socket(node, socket)
    if node.type == "MIX_SHADER":
        return mixed(node)
    if node.type == "ADD_SHADER":
        return added(node)
    if node.type == "BSDF_TRANSPARENT":
        return transparent(node)
    if node.type == "BSDF_TRANSLUCENT":
        return translucent(node)
    return principled.read(node)


def of_input(node, number):
    return of_socket(node, node.inputs[number])


def of_socket(node, socket):
    link = links.link_to(socket)
    if link is None:
        raise NotSimple(node)
    return read(link)


def transparent(node):
    """Nothing, or a tint on all light that passes through."""
    color = sockets.of(node.inputs["Color"])
    if not (color.is_constant() and 0.0 <= min(color.factor) <= max(color.factor) <= 1.0):
        raise NotSimple(node)
    sources = {"base": BLACK, **MATTE}
    is_clear = min(color.factor) > 1.0 - 1e-6
    return Surface(sources, alpha=BLACK) if is_clear else Surface({**sources, "filter": color})


def translucent(node):
    """Lambertian transmission."""
    sources = {"base": BLACK, **MATTE, "through": sockets.of(node.inputs["Color"])}
    return Surface(sources, normal=principled.normal(node.inputs["Normal"]))


def is_nothing(surface):
    return surface.alpha.is_constant() and surface.alpha.number() == 0.0 and not glows(surface)


def glows(surface):
    strength = surface.sources.get("emission_strength", BLACK)
    return not (strength.is_constant() and strength.number() == 0.0)


def is_matte(surface):
    """Neither glossy nor emissive, and opaque."""
    if {"thin", "filter"} & surface.sources.keys():
        return False
    has_shine = not (surface.sources.get("specular", WHITE).is_zero() and surface.sources.get("metallic", BLACK).is_zero())
    return not has_shine and not glows(surface) and surface.alpha == WHITE


def is_mirror(surface):
    """Metal of one colour."""
    metallic, base = surface.sources.get("metallic", BLACK), surface.sources["base"]
    return metallic == WHITE and base.is_constant() and not glows(surface) and surface.alpha == WHITE and not surface.losses


def is_glazed(surface):
    """Matte Principled BSDF under a uniform gloss."""
    return is_even_glaze(surface) and not glows(surface) and surface.alpha == WHITE and surface.cutoff is None


def is_even_glaze(surface):
    """Whether its gloss is that of one dielectric."""
    none = (surface.sources.get(name) for name in ("metallic", "coat", "sheen", "transmission"))
    is_plain = all(source == BLACK for source in none) and all(surface.sources.get(name, BLACK).is_constant() for name in ("specular", "ior"))
    return is_plain and "thin" not in surface.sources


def half_glazed(node, share, glazed, matte):
    """Partly glossy surface: the gloss covers all with this weight, and only reduces that part."""
    beneath, made = ([one.sources.get(name, BLACK) for name in ("base", "through")] for one in (glazed, matte))
    mixed = [blended(node, 1.0 - share, *parts) for parts in zip(beneath, made)]
    takes = tuple(
        [part / whole if whole > 0.0 else 1.0 for part, whole in zip(own.factor, of_all.factor)] for own, of_all in zip(beneath, mixed))
    sources = {**glazed.sources, **dict(zip(("base", "through"), mixed)), "shine": Source((share,) * 3)}
    return replace(glazed, sources=sources, shine_takes=takes)


def shining(node, share, matte, mirror):
    """Surface with a share of a mirror with its own colour."""
    if "metal" in matte.sources or "thin" in mirror.sources or max(mirror.sources["base"].factor) > 1.0:
        raise NotSimple(node)
    added = {"metallic": Source((share,) * 3), "roughness": mirror.sources["roughness"], "metal": mirror.sources["base"]}
    return replace(matte, sources={**matte.sources, **added}, has_even_metal=mirror.has_even_metal)


def shone_upon(node, matte, mirror):
    """Matte surface plus a mirror: a mixture of both, brightened by the inverse shares."""
    base, color, roughness = matte.sources["base"], mirror.sources["base"], mirror.sources["roughness"]
    share = 1.0 - max(base.factor)
    if "through" in matte.sources or not max(color.factor) - 1e-6 <= share < 1.0:
        raise NotSimple(node)
    matte = replace(matte, sources={**matte.sources, "base": principled.scaled(base, 1.0 / (1.0 - share))})
    color = replace(color, factor=tuple(min(1.0, channel / share) for channel in color.factor))
    found = shining(node, share, matte, replace(mirror, sources={**mirror.sources, "base": color}))
    # Interreflection grows with the facets' colour.
    is_smooth = roughness.is_constant() and roughness.number() <= ROUGH
    return found if is_smooth else replace(found, losses=[*found.losses, "mixed-shine"])


def mixed(node):
    share, cutoff = principled.alpha(node.inputs[0])
    a, b = of_input(node, 1), of_input(node, 2)
    if cutoff is not None:
        if not is_nothing(a) or is_nothing(b):
            raise NotSimple(node)
        return replace(covered(node, share, a, b), cutoff=cutoff)
    if share.is_constant():
        value = min(1.0, max(0.0, share.number()))
        if value in (0.0, 1.0):
            return b if value else a
    if is_nothing(a) or is_nothing(b):
        return covered(node, share, a, b)
    if not share.is_constant() or a.normal != b.normal:
        raise NotSimple(node)
    if all(is_matte(one) or is_filter(one) for one in (a, b)):
        return matte(node, value, a, b)
    for share, one, other in ((1.0 - value, a, b), (value, b, a)):
        if is_glazed(one) and is_matte(other):
            return half_glazed(node, share, one, other)
    if is_matte(a) and is_mirror(b):
        return shining(node, value, a, b)
    if is_mirror(a) and is_matte(b):
        return shining(node, 1.0 - value, b, a)
    raise NotSimple(node)


def covered(node, share, a, b):
    """One shader is transparent: the share is coverage."""
    there = b if is_nothing(a) else a
    if is_nothing(there):
        return there
    if is_nothing(b):
        if not share.is_constant():
            # A picture would need a new one.
            raise NotSimple(node)
        share = Source((1.0 - share.number(),) * 3)
    if there.cutoff is not None or there.alpha != WHITE:
        raise NotSimple(node)
    return replace(there, alpha=share)


def matte(node, share, a, b):
    """Two matte surfaces: reflection and transmission have one colour each."""
    parts = {
        name: blended(node, share, a.sources.get(name, BLACK), b.sources.get(name, BLACK)) for name in ("base", "through", "filter")
    }
    if parts["filter"] == BLACK:
        del parts["filter"]
    return Surface({**parts, **MATTE}, normal=a.normal)


def blended(node, share, a, b):
    if a == BLACK or b == BLACK:
        there, weight = (b, share) if a == BLACK else (a, 1.0 - share)
        return replace(there, factor=tuple(weight * channel for channel in there.factor))
    if replace(a, factor=b.factor) == b:
        return replace(a, factor=tuple((1.0 - share) * x + share * y for x, y in zip(a.factor, b.factor)))
    raise NotSimple(node)


def added(node):
    """Emission or a mirror added to a surface."""
    a, b = of_input(node, 0), of_input(node, 1)
    for one, other in ((a, b), (b, a)):
        if is_matte(one) and is_mirror(other):
            return shone_upon(node, one, other)
    light, surface = (a, b) if is_light(a) else (b, a)
    if is_nothing(surface):
        # A flame: its background shows fully.
        surface = replace(surface, sources={**surface.sources, "filter": WHITE}, alpha=WHITE)
    if not is_light(light) or glows(surface) or surface.alpha != WHITE:
        raise NotSimple(node)
    kept = {name: light.sources[name] for name in ("emission", "emission_strength")}
    return replace(surface, sources={**surface.sources, **kept})


def is_filter(surface):
    return "filter" in surface.sources and not glows(surface)


def is_light(surface):
    is_black = surface.sources.get("base") == BLACK and not {"through", "filter"} & surface.sources.keys()
    return is_black and glows(surface) and surface.alpha == WHITE
