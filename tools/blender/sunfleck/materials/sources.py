"""What a socket's value can be that glTF has words for: a constant, a picture, a colour attribute, or a product of
those.

In go numbers, pictures and names of attributes, out come a `Source` and what nodes make of it. Invariant: a source is
exact; whatever is more involved is `NotSimple`, by the node's name.
"""

from dataclasses import dataclass, replace

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

    def is_zero(self):
        """Whether it is a constant that is not above 0."""
        return self.is_constant() and self.number() <= 0.0

    def number(self):
        """Of a constant: Blender makes numbers of colours by their brightness."""
        r, g, b = self.factor
        return r if r == g == b else sum(weight * channel for weight, channel in zip(BRIGHTNESS, self.factor))


WHITE, BLACK = Source((1.0, 1.0, 1.0)), Source((0.0, 0.0, 0.0))


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


def product(node, a, b):
    """Both factors; at most one picture and one attribute among them."""
    if (a.picture and b.picture) or (a.attribute is not None and b.attribute is not None):
        raise NotSimple(node)
    with_picture, with_attribute = (a if a.picture else b), (a if a.attribute is not None else b)
    return Source(
        tuple(x * y for x, y in zip(a.factor, b.factor)), with_picture.picture, with_picture.channel,
        with_attribute.attribute, with_attribute.attribute_channel,
    )


def clamped(node, source):
    """From 0 to 1."""
    if source.is_constant():
        return Source(tuple(min(1.0, max(0.0, channel)) for channel in source.factor))
    if source.attribute is not None or source.picture.image.is_float or not 0.0 <= min(source.factor) <= max(source.factor) <= 1.0:
        raise NotSimple(node)
    return source
