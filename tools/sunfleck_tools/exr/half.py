"""Half precision by integer operations, which are vectorized where those of halves are not.

Invariant: `widened` gives the bits of `astype(float32)`, except NaN's payload.
"""

from math import copysign, isfinite, nan

import numpy as np

INFINITY, NEGATIVE = 0x7C00, 0x8000
EXPONENT_STEP = np.float32(2.0**112)
"""Scale between the two formats' exponent biases, 127 and 15."""


def widened(stored: np.ndarray) -> np.ndarray:
    """Halves as float32: fraction and exponent are shifted, and a product corrects the exponent, subnormal
    numbers included (Giesen 2012, half_to_float_fast4)."""
    smallest, largest = extremes(stored)
    if not (isfinite(smallest) and isfinite(largest)):
        return stored.astype(np.float32)
    bits: np.ndarray = stored.view(np.uint16).astype(np.uint32)
    if copysign(1.0, smallest) < 0:
        sign = bits & NEGATIVE
        bits ^= sign
        sign <<= 16
        bits <<= 13
        bits |= sign
    else:
        bits <<= 13
    result = bits.view(np.float32)
    result *= EXPONENT_STEP
    return result


def plain(smallest: float, largest: float) -> bool:
    """True if halves in that range are finite and have no sign, as `scaled_into` requires."""
    return copysign(1.0, smallest) > 0 and isfinite(largest)


def scaled_into(stored: np.ndarray, factor: np.float32, out: np.ndarray) -> None:
    """`factor` times plain halves, as float32. It joins both products of `widened(stored) * factor`, which
    changes no bit, as the first is by a power of two."""
    bits = out.view(np.uint32)
    np.copyto(bits, stored.view(np.uint16))
    np.left_shift(bits, 13, out=bits)
    np.multiply(out, factor * EXPONENT_STEP, out=out)


def extremes(stored: np.ndarray) -> tuple[float, float]:
    """Smallest and largest value; NaN twice if any value is NaN. Bits without the sign are ordered like
    magnitudes."""
    bits = stored.view(np.uint16)
    top = int(bits.max())
    if top <= INFINITY:
        return _value(int(bits.min())), _value(top)
    top_positive = int(bits.view(np.int16).max())
    if top_positive > INFINITY or top > NEGATIVE | INFINITY:
        return nan, nan
    return _value(top), _value(top_positive if top_positive >= 0 else int(bits.min()))


def _value(bits: int) -> float:
    return float(np.uint16(bits).view(np.float16))
