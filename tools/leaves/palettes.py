"""Colours of autumn: a species and an age in, sRGB out.

Invariant: a ramp's ages go from 0, a summer leaf, to 1, a leaf of last year, and its colours change
without a jump.
"""

from dataclasses import dataclass

Color = tuple[float, float, float]


def mix(a: Color, b: Color, t: float) -> Color:
    """From a at 0 to b at 1."""
    return (a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t)


@dataclass(frozen=True)
class Ramp:
    """Colours of a blade as it ages, sRGB from 0 to 255, at equal steps from 0 to 1."""

    stops: tuple[Color, ...]
    vein: Color
    spot: Color

    def at(self, age: float) -> Color:
        """The colour at an age; before 0 and after 1 the first and the last."""
        place = min(max(age, 0.0), 1.0) * (len(self.stops) - 1)
        step = min(int(place), len(self.stops) - 2)
        return mix(self.stops[step], self.stops[step + 1], place - step)


RAMPS = {
    "maple": Ramp(
        ((78, 112, 34), (156, 158, 40), (244, 200, 46), (236, 140, 30), (200, 52, 22), (108, 62, 34)),
        (250, 214, 126), (74, 40, 20),
    ),
    "birch": Ramp(((92, 122, 42), (166, 168, 46), (246, 208, 56), (226, 162, 40), (122, 82, 42)), (252, 232, 150), (92, 60, 26)),
    "oak": Ramp(((80, 106, 42), (142, 138, 46), (204, 150, 48), (178, 94, 36), (118, 74, 40), (82, 52, 32)), (226, 190, 120), (58, 36, 20)),
    "beech": Ramp(((90, 118, 40), (198, 176, 50), (228, 168, 52), (204, 112, 38), (150, 78, 36), (96, 58, 32)), (246, 206, 130), (74, 42, 22)),
    "ginkgo": Ramp(((120, 148, 48), (204, 198, 54), (252, 216, 56), (244, 192, 46), (190, 148, 78)), (255, 236, 140), (140, 98, 34)),
    "aspen": Ramp(((100, 132, 48), (206, 190, 48), (252, 210, 50), (240, 164, 40), (118, 82, 42)), (255, 232, 150), (80, 52, 24)),
    "willow": Ramp(((106, 132, 60), (178, 180, 68), (234, 206, 80), (176, 142, 76), (116, 80, 46)), (246, 236, 170), (94, 66, 34)),
}  # fmt: skip
