"""Losses of a stage: requests that are not honoured, by kinds with permanent ids.

Invariant: every loss is in `KINDS`; a kind is reported once, with its count and first place.
"""

from collections import Counter
from dataclasses import dataclass

from pxr import Tf, Usd

from ...errors import SceneError

KINDS = {
    "usd-animated": "texture coordinates, normals or faces of a material that change over time",
    "usd-camera-input": "an input of a camera that is not carried",
    "usd-camera-or-light-type": "a light or a shape of a kind that is not carried",
    "usd-clock": "a rate or a range of frames that cannot be",
    "usd-composition": "an arc or an opinion that USD itself passes over",
    "usd-dome-animated": "a DomeLight that changes over time",
    "usd-dome-picture": "the picture of a DomeLight that is tilted or not by longitude and latitude",
    "usd-dome-second": "one DomeLight more than there is sky",
    "usd-empty": "a stage that holds nothing to be seen",
    "usd-instances": "times at which the arrays of an instancer do not fit one another",
    "usd-light-cone": "a cone wider than a half space",
    "usd-light-input": "an input of a light that is not carried",
    "usd-light-shape": "a light whose form is not carried, but one like it",
    "usd-light-value": "an input of a light that is no number that can be",
    "usd-material": "a material without a surface that is known",
    "usd-material-animated": "a file, a place or another input of a texture, or a colour, that changes over time",
    "usd-material-approximated": "a surface of which only the most important inputs are taken",
    "usd-material-input": "an input of a material that is not carried",
    "usd-material-value": "an input of a material, or a colour of a mesh, that is none that can be",
    "usd-mesh-light": "a mesh that is a light: it is seen to shine, and lights other things by indirect "
                      "light alone",
    "usd-missing": "a layer, a prim or a variant that the stage refers to and that is not there",
    "usd-motion": "a word on how far things move while a shutter is open",
    "usd-normal-map": "a normal map that does not say how it is to be read",
    "usd-prim": "a prim that cannot be read, or of a type that USD does not know",
    "usd-primvar": "values, or subsets, that do not fit their mesh",
    "usd-purpose": "a shape of a purpose that is not drawn",
    "usd-render-settings": "what a RenderSettings asks for and is not carried",
    "usd-shape": "a shape without faces, or a drawMode",
    "usd-shear": "a node that shears as it moves",
    "usd-skeleton": "a skeleton that cannot be followed",
    "usd-subdivision": "a subdivision surface that is refined less than twice",
    "usd-texture": "a texture that is not there or cannot be read",
    "usd-texture-packing": "a texture of which only the mean is carried",
    "usd-texture-range": "numbers of a texture that are clipped, or more than 256 steps can tell apart",
    "usd-texture-size": "a texture that is made smaller",
    "usd-texture-wrap": "a texture with black around it",
    "usd-unit": "a unit of length, or an axis that points up, that is none",
    "usd-volume": "a field or the material of a volume, or another volume than one with a density",
}
"""Ids and their meanings; docs/usd.md lists them for users."""


UNREADABLE = (SceneError, Tf.ErrorException, TypeError, ValueError, OverflowError)
"""Exceptions of reading a prim: attributes may have any type and value; errors of USD, numpy and Python
about them are one fault."""


class TooMuch(SceneError):
    """Exceeds the size of a file; no single prim is at fault."""


@dataclass(frozen=True)
class Loss:
    """Kind of loss: its first place, its sentence, and its count."""

    kind: str
    place: str
    sentence: str
    count: int

    def __str__(self) -> str:
        more = f" (and {self.count - 1} more)" if self.count > 1 else ""
        return f"[{self.kind}] {self.sentence}{more}"


class Losses:
    """Collects losses during reading."""

    def __init__(self) -> None:
        self._first: dict[str, tuple[str, str]] = {}
        # A dictionary serves as an ordered set.
        self._seen: dict[tuple[str, str, str], None] = {}
        self._counts: Counter[str] = Counter()

    def add(self, kind: str, place: object, what: str) -> None:
        """Adds a loss of a kind of `KINDS` at a place: an object with a path, a path, or a node. Equal
        losses at one place count once."""
        if kind not in KINDS:
            raise KeyError(kind)
        place = getattr(place, "GetPath", lambda: place)()
        key = (kind, str(place), what)
        if key in self._seen:
            return
        self._seen[key] = None
        self._counts[kind] += 1
        self._first.setdefault(kind, (str(place), f"{place}: {what}"))

    def leaving_out(self, prim: Usd.Prim) -> "_LeavingOut":
        """Context that drops a prim that cannot be read, and reports the reason."""
        return _LeavingOut(self, prim)

    def every(self) -> list[Loss]:
        """Losses one by one, in the order of discovery."""
        return [Loss(kind, place, f"{place}: {what}", 1) for kind, place, what in self._seen]

    def list(self) -> list[Loss]:
        """One loss a kind, in the order of discovery."""
        return [Loss(kind, *first, self._counts[kind]) for kind, first in self._first.items()]


class _LeavingOut:
    """See `Losses.leaving_out`. A class, as generators are slower, and each mesh enters several."""

    def __init__(self, losses: Losses, prim: Usd.Prim):
        self.losses, self.prim = losses, prim

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: type | None, error: BaseException | None, _: object) -> bool:
        if error is None or isinstance(error, TooMuch) or not isinstance(error, UNREADABLE):
            return False
        place = str(self.prim.GetPath())
        self.losses.add("usd-prim", self.prim, f"is left out: {str(error).removeprefix(f'{place}: ')}")
        return True
