"""Sources of a surface's inputs: numbers, a texture, or the mesh's own colours, through interfaces and node
graphs.

Invariant: any other source is reported, and the input has its default.
"""

import math
from dataclasses import dataclass, replace

from pxr import Usd, UsdShade

from .losses import Losses
from .numbers import numbers_in
from .shaders import Dialect
from .textures import Texture, Textures, file_input

COLORS_OF_MESH = {"diffuseColor": "displayColor", "opacity": "displayOpacity"}
"""Inputs that vertex colours can feed, with the primvar."""

SHARES = frozenset(
    {"diffuseColor", "specularColor", "opacity", "metallic", "roughness", "clearcoat", "clearcoatRoughness"}
)
"""Inputs from 0 to 1; emission is from 0 on."""


@dataclass(frozen=True)
class Fed:
    """Numbers; with a texture, factors on its `output` (`rgb`, or one letter)."""

    numbers: tuple[float, ...]
    texture: Texture | None = None
    output: str = ""
    is_of_mesh: bool = False
    """Whether the mesh's colours multiply the numbers."""
    changing: Usd.Attribute | None = None
    """Animated attribute of the numbers."""

    @property
    def map(self) -> Texture:
        """Texture of an input that has one."""
        assert self.texture is not None
        return self.texture


class Network:
    """Surface shader with its sources."""

    def __init__(self, shader: UsdShade.Shader, dialect: Dialect, textures: Textures, layers: list[str]):
        self.shader, self.dialect, self.textures, self.layers = shader, dialect, textures, layers
        self.lost: Losses = textures.lost

    def fed(self, name: str) -> Fed:
        """Source of an input, by its name in UsdPreviewSurface."""
        theirs = self.dialect.names.get(name)
        default = self.dialect.default(name)
        found = self._fed(theirs, default, name) if theirs else Fed(default)
        for weight, usual in self.dialect.weights.get(name, {}).items():
            weighed = self._fed(weight, (usual,), weight)
            if weighed.changing is not None:
                self.say(f"{weight} that changes over time")
            factor = weighed.numbers[0]
            found = replace(found, numbers=tuple(each * factor for each in found.numbers))
        return found

    def number(self, name: str) -> float:
        """Number without a texture or animation; others are reported."""
        found = self.fed(name)
        if found.texture is not None or found.changing is not None:
            self.say(
                f"{name} from a texture" if found.texture is not None else f"{name} that changes over time"
            )
        return found.numbers[0]

    def say(self, what: str) -> None:
        """Reports a loss of the surface."""
        self.lost.add("usd-material-input", self.shader, f"{what} is not carried")

    def _fed(self, theirs: str, default: tuple[float, ...], ours: str) -> Fed:
        found = self.shader.GetInput(theirs)
        attributes = found.GetValueProducingAttributes() if found else []
        if not attributes:
            return Fed(default)
        if UsdShade.Utils.GetType(attributes[0].GetName()) == UsdShade.AttributeType.Output:
            node = UsdShade.Shader(attributes[0].GetPrim())
            return self._node(node, attributes[0].GetName().rpartition(":")[2], default, ours)
        numbers = self._numbers(attributes[0], default)
        most = 1.0 if ours in SHARES else math.inf
        if (ours in SHARES or ours == "emissiveColor") and not all(0 <= each <= most for each in numbers):
            said = ", ".join(f"{each:g}" for each in numbers)
            self.lost.add("usd-material-value", attributes[0].GetPath(), f"{said} lies outside its range, and the nearest within is taken")
        return Fed(numbers, changing=attributes[0] if attributes[0].ValueMightBeTimeVarying() else None)

    def _numbers(self, attribute: Usd.Attribute, default: tuple[float, ...]) -> tuple[float, ...]:
        numbers = numbers_in(attribute.Get(self.textures.code), len(default))
        if numbers is None:
            value = attribute.Get(self.textures.code)
            said = f"expected {len(default)} finite numbers, found {value}; the default is taken"
            self.lost.add("usd-material-value", attribute, said)
        return default if numbers is None else numbers

    def _node(self, node: UsdShade.Shader, output: str, default: tuple[float, ...], ours: str) -> Fed:
        kind = str(node.GetIdAttr().Get())
        if file_input(node) is not None:
            texture = self.textures.read(node, self.layers)
            if texture is None:
                fallback = self.textures.fallback(node)
                return Fed(default if fallback is None else _picked(fallback, output, len(default)))
            if output not in ("r", "g", "b", "a"):
                output = "rgb"
            return Fed((1.0,) * len(default), texture, output)
        if kind.startswith("UsdPrimvarReader_float"):
            return self._primvar(node, default, ours)
        self.say(f"{ours} from a {kind}")
        return Fed(default)

    def _primvar(self, node: UsdShade.Shader, default: tuple[float, ...], ours: str) -> Fed:
        named = node.GetInput("varname")
        producers = named.GetValueProducingAttributes() if named else []
        varname = str(producers[0].Get(self.textures.code)) if producers else ""
        if varname == COLORS_OF_MESH.get(ours):
            return Fed((1.0,) * len(default), is_of_mesh=True)
        self.say(f"{ours} from the primvar `{varname}`")
        fallback = node.GetInput("fallback")
        numbers = numbers_in(fallback.GetAttr().Get(self.textures.code), len(default)) if fallback else None
        return Fed(numbers or default)


def _picked(rgba: tuple[float, ...], output: str, width: int) -> tuple[float, ...]:
    """Values of an output, from four numbers."""
    first = "rgba".find(output) if len(output) == 1 else 0
    return rgba[first : first + 1] * width if len(output) == 1 else rgba[:width]
