"""Every instance of every scene at every frame, in the file where Blender's dependency graph has it.

Run with the other tests here (test_addon.py says how). What it prints are the largest distances, metres.
"""

import subprocess
import tempfile
import time
import unittest
from pathlib import Path

import bpy
import leaf_scenes
import numpy
import stages
import sunfleck
import truth
from sunfleck import export
from sunfleck.evaluated.readback import File
from test_addon import PROGRAM, inspect

# Metres; exact counts.
PLACES = 1e-4
BLURRED = 1e-3


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = Path(folder.name) / "scene.glb"
        sunfleck.register()
        self.addCleanup(sunfleck.unregister)

    def exported(self, scene, path=None):
        export.export(scene, path or self.path)
        return File(path or self.path)

    def compare(self, name, scene, bar=PLACES, subframe=0.0):
        frames = list(range(scene.frame_start, scene.frame_end + 1))
        file = self.exported(scene)
        expected = truth.of(scene, frames)
        found = truth.of_file(file, frames)
        counts = [len(expected[frame]) for frame in frames]
        self.assertEqual([len(found[frame]) for frame in frames], counts, name)
        worst = max(truth.farthest(found[frame], expected[frame]) for frame in frames)
        print(f"{name}: {min(counts)} to {max(counts)} instances, {worst:.1e} m off")
        self.assertLessEqual(worst, bar, name)
        return file, counts


class Leaves(Case):
    """The scenes of falling leaves."""

    def check(self, name):
        file, counts = self.compare(name, leaf_scenes.build(name))
        return counts

    def test_particles(self):
        counts = self.check("particles")
        self.assertEqual((counts[0], counts[-1]), (45, 62))

    def test_nodes(self):
        self.check("nodes")

    def test_nodes_born(self):
        counts = self.check("nodes_born")
        self.assertLess(counts[0], counts[-1])

    def test_simulation(self):
        self.check("simulation")

    def test_simulation_emits(self):
        counts = self.check("simulation_emits")
        self.assertLess(counts[0], counts[-1])


class Stages(Case):
    """Everything else that moves, shows or hides."""


def staged(build):
    def test(self):
        scene = stages.stage()
        build(scene)
        self.compare(build.__name__, scene)

    return test


for _name, _build in stages.STAGES.items():
    setattr(Stages, f"test_{_name}", staged(_build))


if __name__ == "__main__":
    unittest.main()
