"""Meaning of channels by their names: layers, the picture, and kinds of values.

Names are those that renderers give their passes (AOVs). Arnold has N, P, Z and motionvector, RenderMan Nn,
__Pworld and dPdtime, V-Ray normals, velocity and zDepth. Redshift, Karma and Mantra have Pz, hitN and
primId, Cycles Vector, IndexOB and Denoising Normal. Invariant: an unknown name counts as light, for which
checks are strictest.
"""

import re
from collections.abc import Iterable, Sequence
from enum import Enum
from functools import lru_cache

COLOURS = (("R", "G", "B"), ("r", "g", "b"), ("red", "green", "blue"))
PICTURES = ("", "rgba", "rgb", "beauty", "combined", "composite", "color", "colour", "ci", "c", "main")
"""Layers that hold the picture itself, the likeliest first."""
LUMINANCE, CHROMA = "Y", ("RY", "BY")
"""Luminance and chroma (OpenEXR's luminance-chroma pictures)."""


class Kind(Enum):
    """Kind of a channel's values."""

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
"""Matches names in lower case, with `_` between words."""
VECTOR_COMPONENTS = frozenset("XYZUVWxyzuvw")


@lru_cache(maxsize=None)
def split(name: str) -> tuple[str, str]:
    """Layer and component: `view.diffuse.R` is `view.diffuse` and `R`."""
    layer, _, component = name.rpartition(".")
    return layer, component


@lru_cache(maxsize=None)
def kind(name: str) -> Kind:
    """Kind by the layer's last name (`Normal` in `ViewLayer.Normal.X`), else by the component."""
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
    """True if values are ids: every other channel of Cryptomatte is, the rest are coverages."""
    component = split(name)[1]
    return kind(name) is Kind.ID and (not is_cryptomatte(name) or component.lower() in ("r", "b", "red", "blue"))


def is_cryptomatte(name: str) -> bool:
    """True for ids and coverages of Cryptomatte."""
    return CRYPTOMATTE.match(_called(name)[0]) is not None


@lru_cache(maxsize=None)
def is_motion(name: str) -> bool:
    """True if the channel holds motion vectors."""
    return MOTIONS.fullmatch(_called(name)[1]) is not None


def _called(name: str) -> tuple[str, str]:
    """The layer's last name, and the one that tells its contents: the same, or without a layer the
    component."""
    layer, component = split(name)
    own = re.sub(r"[\s-]+", "_", layer.rpartition(".")[2].lower())
    return own, own or component.lower()


def picture(names: Iterable[str]) -> tuple[str, ...]:
    """Channels of the picture: three of colour, or luminance alone; empty without a picture."""
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
    """Index of the part with the picture, by names of parts and of their channels: the likeliest name, in
    any order; the first if none has colours."""

    def rank(name: str) -> int:
        own = name.rpartition(".")[2].lower()
        return PICTURES.index(own) if own in PICTURES else len(PICTURES)

    found = [
        (rank(name), number)
        for number, (name, channels) in enumerate(parts)
        if picture(channels) and kind(f"{name}.R") is Kind.LIGHT
    ]
    return min(found, default=(0, 0))[1]
