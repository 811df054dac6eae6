"""How far frames are from references: by formulas, by `sunfleck diff`, and by FLIP's authors."""

import re
import subprocess
import tempfile
import unittest
from math import inf, isnan, nan
from pathlib import Path

import numpy as np

from sunfleck_tools.analysis import read_picture
from sunfleck_tools.difference import mean_flip, relative_mse
from sunfleck_tools.frame import Frame

from .command import NO_PROGRAM, PROGRAM, run
from .files import frame_path, good_sequence, rewrite, write_frame

try:
    import flip_evaluator
except ImportError:
    flip_evaluator = None


class WithFolder(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = Path(scratch.name)

    def frame(self, name: str, *row: float) -> Frame:
        """A frame one row high, of greys."""
        path = write_frame(self.folder / name, {letter: np.array([row], np.float32) for letter in "RGB"})
        frame, _ = read_picture(path)
        return frame


class Measures(WithFolder):
    def test_are_what_their_formulas_say(self):
        found = relative_mse(self.frame("o.exr", 1, 2, 3, 6), self.frame("r.exr", 1, 2, 3, 4))
        self.assertAlmostEqual(found, 1 / 16.0625)

    def test_a_value_that_is_not_finite_spoils_the_picture(self):
        reference = self.frame("r.exr", 1, inf, 3, 4)
        self.assertEqual(relative_mse(self.frame("o.exr", 1, inf, 3, 4), reference), 0.0)
        for row in ((1, inf, nan, 4), (1, 2, 3, 4), (1, -inf, 3, 4)):
            self.assertTrue(isnan(relative_mse(self.frame("o.exr", *row), reference)), row)

    def test_black_is_not_far_from_black(self):
        black = self.frame("r.exr", 0, 0)
        self.assertEqual(relative_mse(black, black), 0.0)
        self.assertEqual(relative_mse(self.frame("o.exr", 0, 1), black), inf)

    @unittest.skipUnless(PROGRAM, NO_PROGRAM)
    def test_figures_are_those_of_the_program(self):
        folder = good_sequence(self.folder / "frames")
        pair = [frame_path(folder, 3), frame_path(folder, 4)]
        said = subprocess.run([PROGRAM, "diff", *map(str, pair)], check=True, capture_output=True, text=True).stdout
        theirs = float(re.search(r"^RGB .* relMSE (\S+)", said, re.MULTILINE)[1])
        ours = relative_mse(*(read_picture(path)[0] for path in pair))
        self.assertAlmostEqual(ours / theirs, 1.0, delta=1e-3)


class Commands(unittest.TestCase):
    def test_those_that_are_gone_name_their_successors(self):
        for name, successor in (("compare", "diff"), ("movie", "preview"), ("farm-simulation", "farm")):
            code, _, err = run(name, "out/")
            self.assertEqual(code, 2)
            self.assertRegex(err, rf"^error: `{name}` is gone: `sunfleck {successor} .*` does its work\n$")


@unittest.skipUnless(flip_evaluator, "flip-evaluator is not installed")
class Flip(WithFolder):
    def setUp(self):
        super().setUp()
        self.ours, self.theirs = (good_sequence(self.folder / name) for name in ("ours", "theirs"))
        rewrite(frame_path(self.ours, 7), lambda c: {**c, "G": c["G"] * np.float16(1.5)})
        # FLIP takes its time: two frames say as much as twelve.
        for number in (1, 2, 3, 4, 5, 8, 9, 10, 11, 12):
            frame_path(self.ours, number).unlink()
            frame_path(self.theirs, number).unlink()

    def test_is_that_of_the_authors_package_reading_files(self):
        pair = frame_path(self.theirs, 7), frame_path(self.ours, 7)
        expected = float(flip_evaluator.evaluate(*map(str, pair), "HDR")[1])
        reference, output = (read_picture(path)[0] for path in pair)
        self.assertGreater(expected, 0.01)
        self.assertAlmostEqual(mean_flip(output, reference), expected, places=5)
        self.assertEqual(mean_flip(output, output), 0.0)

    def test_is_a_limit(self):
        limits = ["--reference", self.theirs, "--max-relmse", "9"]
        code, out, _ = run("validate", self.ours, *limits, "--max-flip", "0.001")
        self.assertEqual(code, 1)
        self.assertRegex(out, r"error: frame 7: mean FLIP 0\.\d+, allowed 0\.001 \[reference\]")
        self.assertEqual(run("validate", self.ours, *limits, "--max-flip", "0.9")[0], 0)
