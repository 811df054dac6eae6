"""What a material is in glTF's words, or that it has to be baked.

In go materials, out come `Look`s. Invariant: what is no `Look` of its own is `NotSimple`, and is baked.
"""

from dataclasses import dataclass, field

from . import closures, dependence, inputs, links, principled
from .principled import MATTE, Surface
from .sources import BLACK, WHITE, NotSimple, Source

# What a mesh without a material looks like in Cycles (a new Principled BSDF), and what a material
# without a shader does.
DEFAULT = Surface({"base": Source((0.8,) * 3)})
NOTHING = Surface({"base": BLACK, **MATTE})


@dataclass
class Look:
    """What a material is: a surface, or none where it lets all light through; and what of it is lost."""

    surface: Surface | None
    losses: list = field(default_factory=list)
    # Why it has to be baked; the surface is then that of each bake.
    baked: str = ""
    sizes: set = field(default_factory=set)
    bakes: int = 0
    mean: Surface | None = None
    failed: str = ""
    glows: bool = False

    @property
    def texels(self):
        """Sizes of its bakes."""
        return f"at {', '.join(f'{size} x {size}' for size in sorted(self.sizes))} texels"


def looked_at(material, is_still):
    if material is None:
        return Look(DEFAULT)
    link = principled.surface_link(material)
    if link is None:
        return Look(None if is_volume(material) else NOTHING)
    losses = sorted(dependence.losses(material) | inputs.losses(material))
    if dependence.is_of_film(material) and not is_still:
        losses.append("image-sequence")
    try:
        surface = closures.read(link)
        check_bumps(material)
        check_attributes(surface)
        check_pictures(surface)
        honoured = {"transparent-tint", *({"transmission"} if "thin" in surface.sources else ())}
        return Look(surface, [loss for loss in losses if loss not in honoured])
    except NotSimple as more:
        node = more.args[0] if more.args else None
        return Look(DEFAULT, losses, f"node `{node.name}`" if node else "nodes")


def check_bumps(material):
    """Displacement that bends normals is a normal map, once it is baked."""
    link = links.link_to(principled.output_of(material.node_tree).inputs["Displacement"])
    if link and material.displacement_method != "DISPLACEMENT":
        raise NotSimple(link.from_node)


def check_attributes(surface):
    """glTF has one colour of vertices, for the base colour, and its alpha for alpha."""
    base, alpha = surface.sources.get("base", WHITE), surface.alpha
    others = [source for name, source in surface.sources.items() if name != "base"]
    two = None not in (base.attribute, alpha.attribute) and base.attribute != alpha.attribute
    swapped = (base.attribute is not None and base.attribute_channel == 3) or (
        alpha.attribute is not None and alpha.attribute_channel != 3
    )
    if two or swapped or any(source.attribute is not None for source in others):
        raise NotSimple(None)


def check_pictures(surface):
    """glTF has one place for base colour and alpha, and one for metallic and roughness. What glows and what goes
    through has colours, and no picture of how much."""
    source = lambda name: surface.sources.get(name, WHITE)
    pairs = (source("base"), surface.alpha), (source("metallic"), source("roughness"))
    pictures = [[one.picture, other.picture] for one, other in pairs]
    are_apart = any(None not in pair and pair[0].place() != pair[1].place() for pair in pictures)
    are_colours = all(source(name).channel == "rgb" for name in ("emission", "through"))
    # Factors of numbers end at 1, and what they multiply a picture by need not.
    numbers = [surface.alpha, *map(source, ("metallic", "roughness", "coat", "coat_roughness"))]
    are_apart |= any(number.picture is not None and number.number() > 1.0 for number in numbers)
    if are_apart or not (are_colours and source("emission_strength").is_constant()):
        raise NotSimple(None)


def is_volume(material):
    output = principled.output_of(material.node_tree) if material.node_tree else None
    return bool(output and links.link_to(output.inputs["Volume"]))
