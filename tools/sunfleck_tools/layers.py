"""What channels are, by their names: layers, the picture itself, and what values of a channel mean.

Names are those that renderers give their passes (AOVs). Arnold has N, P, Z and motionvector, RenderMan
Nn, __Pworld and dPdtime, V-Ray normals, velocity and zDepth. Redshift, Karma and Mantra have Pz, hitN and
primId, Cycles Vector, IndexOB and Denoising Normal. Invariant: a name that says nothing is light, of
which the strictest is asked.
"""

import re
from collections.abc import Iterable, Sequence
from enum import Enum
from functools import lru_cache

COLOURS = (("R", "G", "B"), ("r", "g", "b"), ("red", "green", "blue"))
PICTURES = ("", "rgba", "rgb", "beauty", "combined", "composite", "color", "colour", "ci", "c", "main")
"""Layers that hold the picture itself, the likeliest first."""
LUMINANCE, CHROMA = "Y", ("RY", "BY")
"""Luminance, and how far red and blue are from it (OpenEXR's luminance-chroma pictures)."""


class Kind(Enum):
    """What the values of a channel are."""

    LIGHT = "light"  # or a share of it: finite, and not negative
    ALPHA = "alpha"
    DEPTH = "depth"  # infinite where there is nothing
    DATA = "data"  # directions, places, motion: of any sign
    ID = "id"  # names of things, some of them in the bits of floats


THINGS = "leaf|object|material|prim|instance|mesh|render|element"
IDS = re.compile(rf"(\w*_)?({THINGS})?_?id\d*|index_?(ob|ma)|({THINGS})_index|crypto\w*|udim")
CRYPTOMATTE = re.compile(r"crypto\w*\d\d$")
DEPTHS = re.compile(r"_*(z|zback|pz|hit_?pz|distance|mist)|(\w*_)?z?_?depth(_\w*|\d*)")
DIRECTIONS = re.compile(r"(\w*_)?(n|nn|ng|ns|hitn)|\w*normals?\d*|\w*tangents?|dpd\w+|reflvec")
PLACES = re.compile(
    r"_*(p|po|pw|pref|hitp|pworld|pcam\w*|st|uv\w*)|\w*position\w*|points?|texcoords?|disparity\w*"
)
MOTIONS = re.compile(r"\w*(motion|velocity|vector)\w*|mv|speed|forward|backward|(\w*_)?flow")
"""Of names in small letters, whose words `_` joins."""
VECTOR_COMPONENTS = frozenset("XYZUVWxyzuvw")


@lru_cache(maxsize=None)
def split(name: str) -> tuple[str, str]:
    """Layer and component: `view.diffuse.R` is `view.diffuse` and `R`."""
    layer, _, component = name.rpartition(".")
    return layer, component


@lru_cache(maxsize=None)
def kind(name: str) -> Kind:
    """By the layer's own name (of `ViewLayer.Normal.X` that is `Normal`), else by the component's."""
    component = split(name)[1]
    own, called = _called(name)
    if IDS.fullmatch(called):
        return Kind.ID
    if DIRECTIONS.fullmatch(called) or PLACES.fullmatch(called) or is_motion(name):
        return Kind.DATA
    if DEPTHS.fullmatch(called) or (
        component in ("Z", "z", "ZBack") and own in ("", "rgba", "beauty", "combined")
    ):
        return Kind.DEPTH
    if component in ("A", "a", "alpha"):
        return Kind.ALPHA
    if component in (LUMINANCE, "y") and own in ("", "luminance", "error"):
        return Kind.LIGHT
    return Kind.DATA if component in VECTOR_COMPONENTS or component in CHROMA else Kind.LIGHT


def holds_ids(name: str) -> bool:
    """True if the values themselves are names of things: of Cryptomatte's channels every other is, the
    rest are coverages."""
    component = split(name)[1]
    return kind(name) is Kind.ID and (not is_cryptomatte(name) or component.lower() in ("r", "b", "red", "blue"))


def is_cryptomatte(name: str) -> bool:
    """True of ids and coverages of Cryptomatte."""
    return CRYPTOMATTE.match(_called(name)[0]) is not None


@lru_cache(maxsize=None)
def is_motion(name: str) -> bool:
    """True if the channel says how far things move."""
    return MOTIONS.fullmatch(_called(name)[1]) is not None


def _called(name: str) -> tuple[str, str]:
    """The layer's own name, and that which says what is in it: the same, or without a
    layer the component's."""
    layer, component = split(name)
    own = re.sub(r"[\s-]+", "_", layer.rpartition(".")[2].lower())
    return own, own or component.lower()


def picture(names: Iterable[str]) -> tuple[str, ...]:
    """The channels of the picture itself: three of colour, or its luminance alone; none where
    there is no picture."""
    names = list(names)
    known = set(names)
    found: dict[str, tuple[str, ...]] = {}
    for layer in dict.fromkeys(split(name)[0] for name in names):
        prefix = f"{layer}." if layer else ""
        for colours in COLOURS:
            channels = tuple(prefix + colour for colour in colours)
            if known.issuperset(channels) and kind(channels[0]) is Kind.LIGHT:
                found.setdefault(layer, channels)
    for wanted in PICTURES:
        for layer, channels in found.items():
            if layer.rpartition(".")[2].lower() == wanted:
                return channels
    if found:
        return next(iter(found.values()))
    return (LUMINANCE,) if LUMINANCE in known else ()


def part_of_picture(parts: Sequence[tuple[str, Sequence[str]]]) -> int:
    """Which part of a file holds the picture, by names of parts and of their channels: that of the likeliest name,
    whatever the order; the first where none has colours."""

    def rank(name: str) -> int:
        own = name.rpartition(".")[2].lower()
        return PICTURES.index(own) if own in PICTURES else len(PICTURES)

    found = [
        (rank(name), number)
        for number, (name, channels) in enumerate(parts)
        if picture(channels) and kind(f"{name}.R") is Kind.LIGHT
    ]
    return min(found, default=(0, 0))[1]
