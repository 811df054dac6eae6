"""Errors of lossy compression near black.

Invariant: the error is 0 for lossless compression, and for truncation of digits (PXR24).
"""

from .header import COMPRESSIONS, Header

LOSSY = frozenset({"b44", "b44a", "dwaa", "dwab", "lj2k"})
ROUNDING = 2.0**-12
"""Five times the largest error of B44, DWA of level 45 and JPEG 2000, beside pixels of any brightness."""
USUAL_LEVEL, GAMMA = 45.0, 2.2
"""DWA's error grows with its level, for values encoded with this exponent."""
MOST = 2.0**-5


def rounding(header: Header) -> float:
    """Maximum magnitude of values that were 0 before compression."""
    name = COMPRESSIONS[header.compression]
    if name not in LOSSY:
        return 0.0
    level = header.values.get("dwaCompressionLevel")
    if name not in ("dwaa", "dwab") or not isinstance(level, float) or not level > USUAL_LEVEL:
        return ROUNDING
    return min(ROUNDING * (level / USUAL_LEVEL) ** GAMMA, MOST)
