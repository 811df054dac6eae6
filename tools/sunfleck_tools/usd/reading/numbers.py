"""Values of attributes as numbers, whatever their type: attributes of schemas may have any."""

import math

import numpy as np


def shortest(numbers) -> tuple[float, ...]:
    """What was written, not what single precision made of it."""
    with np.errstate(over="ignore"):
        return tuple(float(str(np.float32(each))) for each in numbers)


def numbers_in(value: object, width: int) -> tuple[float, ...] | None:
    """So many finite numbers; one for three, and the mean of three for one, as shaders convert them.
    None for all else."""
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
