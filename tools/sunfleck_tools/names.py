"""Frame numbers in names of files.

Invariant: a version (`v2`, `_v003`) is not a frame number, and a name without a number is a single
picture.
"""

import re
from typing import NamedTuple

WHOLE = re.compile(r"(?:(?<=\.)|^)(-?\d+)(?=\.)")
"""Number between dots, as in `shot.1001.beauty.exr`; the last dot is the extension's."""
AT_END = re.compile(r"((?:(?:(?<=[._])|^)-)?\d+)(?=\.[^.]*$)")
"""Number before the extension, as in `leaf_0007.exr` and Blender's `render0007.exr`. A minus is a sign at
the beginning and after `.` or `_`; elsewhere (`take-0007.exr`) it is a dash."""
BETWEEN = re.compile(r"(?<=[._-])(\d+)(?=[._-])")
"""Number between any separators, as in `shot_0007_left.exr`."""
VERSION = re.compile(r"(?:^|[^a-z])v$", re.IGNORECASE)
"""Text before a version number."""
MOST_DIGITS = 18


class Parts(NamedTuple):
    """Name split around its frame number."""

    before: str
    number: str
    after: str

    @property
    def digits(self) -> str:
        """Digits without the sign."""
        return self.number.lstrip("-")


def parts(name: str) -> Parts | None:
    """Parts of a name; `None` without a frame number."""
    for pattern in (WHOLE, AT_END, BETWEEN):
        found = [match for match in pattern.finditer(name) if not VERSION.search(name[: match.start(1)])]
        if found and len(found[-1][1]) <= MOST_DIGITS:
            start, end = found[-1].span(1)
            return Parts(name[:start], name[start:end], name[end:])
    return None
