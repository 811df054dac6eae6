"""The colour space of an EXR file, by `colorInteropID` (names of the ASWF's Color Interop Forum) and
`chromaticities`.

Invariant: the id takes precedence, as in OpenImageIO; a file without attributes is linear Rec. 709.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from ..srgb import linear_from_srgb
from .header import Header

D65, ACES_WHITE = (0.3127, 0.329), (0.32168, 0.33767)
PRIMARIES = {
    "rec709": (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, *D65),
    "ap0": (0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, *ACES_WHITE),
    "ap1": (0.713, 0.293, 0.165, 0.83, 0.128, 0.044, *ACES_WHITE),
    "rec2020": (0.708, 0.292, 0.17, 0.797, 0.131, 0.046, *D65),
    "p3d65": (0.68, 0.32, 0.265, 0.69, 0.15, 0.06, *D65),
    "adobergb": (0.64, 0.33, 0.21, 0.71, 0.15, 0.06, *D65),
}
XYZ = "ciexyzd65"
"""CIE XYZ, not scaled so that white is 1, 1, 1."""
CURVES: dict[str, float | str] = {"lin": 1.0, "srgb": "srgb", "srgbe": "srgb", "g18": 1.8, "g22": 2.2, "g24": 2.4, "g26": 2.6}
CONE_FROM_XYZ = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])
"""Bradford's (ICC.1:2022, annex E)."""
SAME = 1e-3
"""Tolerance of equal chromaticities, for rounded digits in files."""


@dataclass(frozen=True)
class ColorSpace:
    """Meaning of a picture's numbers. Two are equal if their colours are."""

    primaries: str | tuple[float, ...] = "rec709"
    """Name of known primaries, or x and y of red, green, blue and white."""
    curve: float | str = 1.0
    name: str = field(default="linear Rec. 709", compare=False)
    doubt: str | None = field(default=None, compare=False)
    """Attribute that is not honoured."""

    def __str__(self) -> str:
        return self.name

    @property
    def is_ours(self) -> bool:
        """True for linear Rec. 709."""
        return self == OURS

    def to_rec_709(self, colors: Sequence[np.ndarray]) -> list[np.ndarray]:
        """Converts red, green and blue to linear Rec. 709; the curve is odd, for negative values."""
        if self.is_ours:
            return list(colors)
        with np.errstate(all="ignore"):
            linear = [_linear(color.astype(np.float64), self.curve) for color in colors]
            matrix = _known_matrix(self.primaries)
            return [sum(m * c for m, c in zip(row, linear)).astype(np.float32) for row in matrix]


OURS = ColorSpace()


def color_space(header: Header) -> ColorSpace:
    """Colour space of a part."""
    said, found = header.values.get("chromaticities"), OURS
    doubt = None
    if isinstance(said, tuple):
        words = f"chromaticities {' '.join(f'{value:.4f}' for value in said)}"
        known = next((name for name, ours in PRIMARIES.items() if _are_same(said, ours)), None)
        found = ColorSpace(known or tuple(round(value, 4) for value in said), name=words)
        if _matrix(found.primaries) is None:
            found, doubt = OURS, f"{words} span no colours"
    id = header.text("colorInteropID")
    if id is None or id in ("", "unknown") and isinstance(said, tuple):
        return ColorSpace(found.primaries, found.curve, found.name, doubt)
    named = _named(id)
    if named is not None:
        if isinstance(said, tuple) and named.primaries != found.primaries:
            doubt = f"colorInteropID `{id}` and {found.name} disagree, the id counts"
        return ColorSpace(named.primaries, named.curve, id, doubt)
    what = "says that it holds data" if id.removeprefix("ocio:") == "data" else f"is in the space `{id}`, which is not known"
    return ColorSpace(found.primaries, found.curve, found.name, f"it {what}: colours are taken as {found.name}")


def _named(id: str) -> ColorSpace | None:
    words = id.removeprefix("ocio:").split("_")
    if len(words) != 3 or words[2] not in ("scene", "display"):
        return None
    curve, primaries = CURVES.get(words[0]), words[1]
    return ColorSpace(primaries, curve, id) if curve and (primaries in PRIMARIES or primaries == XYZ) else None


def _are_same(one: Sequence[float], other: Sequence[float]) -> bool:
    return all(abs(a - b) < SAME for a, b in zip(one, other))


def _linear(color: np.ndarray, curve: float | str) -> np.ndarray:
    if curve == 1.0:
        return color
    size = np.abs(color)
    return np.copysign(linear_from_srgb(size) if curve == "srgb" else size**curve, color)


def luminances(space: ColorSpace) -> np.ndarray:
    """Luminance weights of a space's linear red, green and blue (ITU-R BT.709, item 3.2)."""
    return _known_matrix(space.primaries).T @ (0.2126, 0.7152, 0.0722)


def _known_matrix(primaries: str | tuple[float, ...]) -> np.ndarray:
    """Matrix of a `ColorSpace` whose primaries span colours."""
    matrix = _matrix(primaries)
    assert matrix is not None
    return matrix


@lru_cache(maxsize=None)
def _matrix(primaries: str | tuple[float, ...]) -> np.ndarray | None:
    """Matrix to linear Rec. 709 from linear colours; None if they span none."""
    ours = _xyz_from_rgb(PRIMARIES["rec709"])
    assert ours is not None
    if primaries == XYZ:
        return np.linalg.inv(ours)
    said = PRIMARIES[primaries] if isinstance(primaries, str) else primaries
    if (its := _xyz_from_rgb(said)) is None:
        return None
    from_white, to_white = (CONE_FROM_XYZ @ _xyz(*white) for white in (said[6:], D65))
    adapted = np.linalg.inv(CONE_FROM_XYZ) @ np.diag(to_white / from_white) @ CONE_FROM_XYZ
    return np.linalg.inv(ours) @ adapted @ its


def _xyz(x: float, y: float) -> np.ndarray:
    return np.array([x, y, 1 - x - y]) / y


def _xyz_from_rgb(said: Sequence[float]) -> np.ndarray | None:
    """Matrix to XYZ with white at Y = 1 (SMPTE RP 177, section 3.3)."""
    columns = np.array([[x, y, 1 - x - y] for x, y in zip(said[0:6:2], said[1:6:2])]).T
    if not np.isfinite(columns).all() or abs(np.linalg.det(columns)) <= 1e-9 or not said[7] > 0:
        return None
    return columns @ np.diag(np.linalg.inv(columns) @ _xyz(*said[6:]))
