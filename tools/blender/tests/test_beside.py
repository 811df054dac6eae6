"""Small scenes of every kind beside Cycles, with no bounces: the ratio of the means.

Run with the other tests here (test_addon.py says how). Prints the table that stands in
docs/blender-scenes.md.
"""

import os
import sys
import tempfile
import time
import unittest
from pathlib import Path

import beside_scenes
import sunfleck
from test_addon import PROGRAM

sys.path.append(str(Path(__file__).parents[2]))

from sunfleck_tools.peers import beside

# Enough for a fifth of the bars, and of random walks for a third.
SAMPLES, CYCLES_SAMPLES = 32, 32
WALKS, CYCLES_WALKS = 64, 64
# Of each way in which light goes on: leaves, shine, light through a leaf, fog, and past what is not seen.
BOUNCED = ("leaves, particles", "coloured metal", "translucent leaf", "fog box", "unseen things")


class Beside(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        os.environ["SUNFLECK_BAKES"] = folder.name
        self.addCleanup(os.environ.pop, "SUNFLECK_BAKES")
        sunfleck.register()
        self.addCleanup(sunfleck.unregister)

    def test_means(self):
        for name, (build, bar) in beside_scenes.SCENES.items():
            if os.environ.get("SUNFLECK_BESIDE", "") not in name:
                continue
            with self.subTest(name):
                begun = time.perf_counter()
                scene, frame = build()
                size = (scene.render.resolution_x, scene.render.resolution_y)
                wish = beside.Wish(PROGRAM, frame, size, SAMPLES, CYCLES_SAMPLES)
                ours, theirs, findings = beside.pictures(scene, wish, self.folder)
                ratio = ours.mean() / theirs.mean()
                said = " ".join(finding.id for finding in findings)
                print(
                    f"{name:28} {theirs.mean():9.5f} {ratio:9.5f} {time.perf_counter() - begun:6.1f} s  "
                    f"{said}",
                    flush=True,
                )
                self.assertLess(abs(ratio - 1.0), bar, name)


    def test_random_walks_bounce_as_in_cycles(self):
        """Our other way to light of further orders; the grid is compared with it in docs/blender-scenes.md."""
        for name in BOUNCED:
            if os.environ.get("SUNFLECK_BESIDE", "") not in name:
                continue
            with self.subTest(name):
                scene, frame = beside_scenes.SCENES[name][0]()
                size = (scene.render.resolution_x, scene.render.resolution_y)
                wish = beside.Wish(PROGRAM, frame, size, WALKS, CYCLES_WALKS, bounces=2)
                beside.exported(scene, wish, self.folder)
                ours = beside.ours(scene, wish, self.folder, "paths")
                ratio = ours.mean() / beside.theirs(scene, wish, self.folder).mean()
                print(f"{name:28} walks {ratio:9.5f}", flush=True)
                self.assertLess(abs(ratio - 1.0), beside_scenes.EXACT_BAR, name)


if __name__ == "__main__":
    unittest.main()
