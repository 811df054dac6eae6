"""Frame numbers drawn into pictures, without a font."""

from __future__ import annotations

import numpy as np

GLYPHS = {
    "0": "### #.# #.# #.# ###", "1": ".#. ##. .#. .#. ###", "2": "### ..# ### #.. ###", "3": "### ..# ### ..# ###",
    "4": "#.# #.# ### ..# ..#", "5": "### #.. ### ..# ###", "6": "### #.. ### #.# ###", "7": "### ..# ..# ..# ..#",
    "8": "### #.# ### #.# ###", "9": "### #.# ### ..# ###", "-": "... ... ### ... ...",
}  # fmt: skip
SCALE = 2
HEIGHT = 5 * SCALE
"""Rows of what `drawn` gives."""


def drawn(number: int) -> np.ndarray:
    """A number as a mask, three columns a digit and one between."""
    columns = []
    for digit in str(number):
        rows = [[pixel == "#" for pixel in row] + [False] for row in GLYPHS[digit].split()]
        columns.append(np.array(rows))
    return np.kron(np.concatenate(columns, axis=1), np.ones((SCALE, SCALE), bool))
