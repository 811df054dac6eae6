"""sRGB curve (IEC 61966-2-1), in both directions."""

import numpy as np


def srgb_from_linear(linear: np.ndarray) -> np.ndarray:
    """Encodes values from 0 to 1."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.power(linear, 1 / 2.4) - 0.055)


def linear_from_srgb(encoded: np.ndarray) -> np.ndarray:
    """Decodes them."""
    return np.where(
        encoded <= 0.04045, encoded / 12.92, ((np.maximum(encoded, 0.04045) + 0.055) / 1.055) ** 2.4
    )
