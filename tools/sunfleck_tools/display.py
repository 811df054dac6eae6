"""Scene light to the bytes that a screen is sent, as the program's own previews have it (docs/display.md).

Invariant: a byte is a function of colour, place and choice alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

CURVES = ("agx", "srgb", "raw")
REC_2020_FROM_REC_709 = np.array(
    [
        [0.6274039, 0.32928304, 0.04331307],
        [0.06909729, 0.9195404, 0.01136232],
        [0.01639144, 0.08801331, 0.89559525],
    ],
    np.float32,
)
REC_709_FROM_REC_2020 = np.linalg.inv(REC_2020_FROM_REC_709)
INSET = np.array(
    [
        [0.85662715, 0.09512124, 0.04825161],
        [0.13731897, 0.761242, 0.10143904],
        [0.11189821, 0.07679942, 0.81130237],
    ],
    np.float32,
)
OUTSET = np.array(
    [[1.1271006, -0.11060664, -0.01649394], [-0.14132976, 1.1578237, -0.01649394], [-0.14132976, -0.11060664, 1.2519364]],
    np.float32,
)
MIDDLE_GREY, STOPS_BELOW, STOPS_ABOVE, SLOPE, GAMMA, HUE_SHIFT_KEPT = 0.18, 10.0, 6.5, 2.4, 2.4, 0.4
GLARE = 1e9
"""Light beyond this is white under every curve, and its logarithm still finite."""
BAYER: np.ndarray = np.zeros((1, 1))
for _ in range(3):
    # Bayer 1973: each quarter is the smaller matrix times 4, plus its place in the order of the quarters.
    BAYER = np.block([[4 * BAYER, 4 * BAYER + 2], [4 * BAYER + 3, 4 * BAYER + 1]])
BAYER = BAYER.astype(np.float32)


@dataclass(frozen=True)
class Display:
    """How light is brought into the range of a screen."""

    curve: str = "agx"
    exposure_stops: float = 0.0

    def encode(self, light: np.ndarray) -> np.ndarray:
        """Values from 0 to 1, in the last axis red, green and blue; what is no number is black."""
        light = np.nan_to_num(light.astype(np.float32), nan=0.0, posinf=GLARE, neginf=0.0)
        light = np.clip(light * np.float32(2.0**self.exposure_stops), 0.0, GLARE)
        if self.curve == "agx":
            return srgb_from_linear(agx(light))
        light = np.minimum(light, 1.0)
        return srgb_from_linear(light) if self.curve == "srgb" else light

    def bytes(self, light: np.ndarray, corner: tuple[int, int] = (0, 0)) -> np.ndarray:
        """The same as bytes of a picture whose upper left pixel is `corner`, with Bayer's ordered dither."""
        height, width = light.shape[:2]
        rows, columns = (
            np.arange(corner[1], corner[1] + height) % 8,
            np.arange(corner[0], corner[0] + width) % 8,
        )
        threshold = (BAYER[np.ix_(rows, columns)] + 0.5) / 64
        return (self.encode(light) * 255 + threshold[..., None]).astype(np.uint8)


def srgb_from_linear(linear: np.ndarray) -> np.ndarray:
    """Encodes values from 0 to 1 with the sRGB curve (IEC 61966-2-1)."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.power(linear, 1 / 2.4) - 0.055)


def agx(light: np.ndarray) -> np.ndarray:
    """AgX as Blender shows it, linear Rec. 709 to linear Rec. 709 from 0 to 1; by the
    formulas of docs/display.md."""
    mixed = light @ (INSET @ REC_2020_FROM_REC_709).T
    formed = _sigmoid(mixed) ** GAMMA
    most, least = formed.max(-1, keepdims=True), formed.min(-1, keepdims=True)
    before = _hue(mixed)
    hue = before + HUE_SHIFT_KEPT * ((_hue(formed) - before + 3) % 6 - 3)
    share = np.clip(2 - np.abs((hue[..., None] - np.array([0, 2, 4], np.float32) + 3) % 6 - 3), 0, 1)
    return np.clip((least + (most - least) * share) @ (REC_709_FROM_REC_2020 @ OUTSET).T, 0, 1)


def _sigmoid(light: np.ndarray) -> np.ndarray:
    """Each channel to its encoded value: a sigmoid of its logarithm, through middle grey."""
    x_pivot, y_pivot = STOPS_BELOW / (STOPS_BELOW + STOPS_ABOVE), MIDDLE_GREY ** (1 / GAMMA)
    stops = np.clip(np.log2(np.maximum(light, np.float32(1e-30)) / MIDDLE_GREY), -STOPS_BELOW, STOPS_ABOVE)

    def side(width: float, height: float) -> float:
        return SLOPE * width * ((SLOPE * width / height) ** 1.5 - 1) ** (-2 / 3)

    scale = np.where(
        stops < 0, np.float32(side(x_pivot, y_pivot)), np.float32(side(1 - x_pivot, 1 - y_pivot))
    )
    e = SLOPE / (STOPS_BELOW + STOPS_ABOVE) * np.abs(stops) / scale
    return np.clip(y_pivot + np.sign(stops) * scale * e * (1 + e * np.sqrt(e)) ** (-2 / 3), 0, 1)


def _hue(color: np.ndarray) -> np.ndarray:
    """Hue of the HSV model, 0 to 6, 0 for red; of greys 0."""
    red, green, blue = np.moveaxis(color, -1, 0)
    most = color.max(-1)
    spread = most - color.min(-1)
    divisor = np.where(spread > 0, spread, 1)
    sixth = np.where(
        most == red,
        (green - blue) / divisor,
        np.where(most == green, (blue - red) / divisor + 2, (red - green) / divisor + 4),
    )
    return np.where(spread > 0, sixth % 6, 0)
