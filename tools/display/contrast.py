#!/usr/bin/env python3
"""Contrast of pictures as a display shows them, a row each.

    target/tools-venv/bin/python tools/display/contrast.py docs/gallery/photo.jpg docs/gallery/title.jpg

Luma of Rec. 601, 0 to 1, by percentiles, and shares of the picture that are black (below .04) and burnt (above .97).
"""

import pathlib
import sys

import numpy
from PIL import Image

PERCENTILES = (1, 10, 50, 90, 99)
BLACK, BURNT = 0.04, 0.97


def row(path: str) -> str:
    """Row of a Markdown table for a picture."""
    luma = numpy.asarray(Image.open(path).convert("L")) / 255
    figures = [f"{value:.2f}" for value in numpy.percentile(luma, PERCENTILES)]
    shares = [f"{100 * share.mean():.1f}" for share in (luma < BLACK, luma > BURNT)]
    return f"| {' | '.join([pathlib.Path(path).stem, *figures, *shares])} |"


print("| picture | 1st | 10th | 50th | 90th | 99th percentile | black, % | burnt, % |\n|---|---|---|---|---|---|---|---|")
for picture in sys.argv[1:]:
    print(row(picture))
