"""The page that says what becomes of what a .blend can hold.

Run with the other tests here (test_addon.py says how).
"""

import re
import unittest
from pathlib import Path

from sunfleck.losses import LOSSES

PAGE = Path(__file__).parents[3] / "docs" / "blender-scenes.md"
# Beside ids, words that stand in the same letters.
PARTS = {
    "image-unreadable",
    "image-sequence",
    "texture-clip",
    "texture-filter",
    "depends-on-view",
    "depends-on-...",
    "depends-on-side",
    "unknown-node-...",
    "input-...",
    "more-than-all",
    "attribute-above-one",
    "mixed-shine",
    "through-by-a-mask",
    "transmission",
    "sheen",
    "thin-wall",
    "mean-colours",
    "nearly-...",
    "count-...",
}


class Page(unittest.TestCase):
    def test_every_loss_stands_there_and_no_other(self):
        told = set(re.findall(r"`([a-z]+(?:-[a-z.]+)*)`", PAGE.read_text()))
        self.assertEqual(told - PARTS - {"~/.cache/sunfleck/bakes"}, set(LOSSES))

    def test_it_has_sixty_rows(self):
        rows = [
            line
            for line in PAGE.read_text().splitlines()
            if line.startswith("| ") and not line.startswith("| in Blender")
        ]
        self.assertGreaterEqual(len(rows), 60)


if __name__ == "__main__":
    unittest.main()
