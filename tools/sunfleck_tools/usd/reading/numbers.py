"""Values of attributes as numbers, whatever the authored type."""

import math

import numpy as np


def shortest(numbers) -> tuple[float, ...]:
    """Shortest decimals, without the noise of single precision."""
    with np.errstate(over="ignore"):
        return tuple(float(str(np.float32(each))) for each in numbers)


def numbers_in(value: object, width: int) -> tuple[float, ...] | None:
    """`width` finite numbers; one becomes three, and three their mean for one, as shaders convert them.
    None for anything else."""
    if value is None or isinstance(value, str):
        return None
    try:
        numbers = shortest(value if hasattr(value, "__len__") else [value])
    except (TypeError, ValueError):
        return None
    if not all(map(math.isfinite, numbers)):
        return None
    if len(numbers) == 1:
        return numbers * width
    if width == 1 and len(numbers) == 3:
        return (sum(numbers) / 3,)
    return numbers[:width] if len(numbers) == width or (width == 3 and len(numbers) == 4) else None
