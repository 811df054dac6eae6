"""`import-usd`: what many meshes and many frames cost, in work and not by the clock."""

import sys
import unittest
from unittest import mock

import numpy as np

from sunfleck_tools.gltf.container import Container
from sunfleck_tools.usd import import_usd
from sunfleck_tools.usd.reading import bends
from sunfleck_tools.usd.reading.bends import SAMPLED, read_bend
from sunfleck_tools.usd.reading.subdivision import Refinement

from .many_meshes import Many, make_stage
from .test_usd_import import ImportCase

MOST_CALLS = 400
"""Of functions for a mesh, Python's and those in C: at about a microsecond each, 10,000 meshes
take less than 10 s."""


class Costs(ImportCase):
    def calls(self, many: Many) -> int:
        """How many functions are called to import a stage."""
        path = self.folder / f"many_{many.meshes}.usdc"
        make_stage(path, many)
        found = 0

        def count(frame, event, argument):
            nonlocal found
            found += event in ("call", "c_call")

        sys.setprofile(count)
        try:
            self.imported = import_usd(path, path.with_suffix(".glb"))
        finally:
            sys.setprofile(None)
        return found

    def test_a_mesh_more_costs_as_much_as_the_one_before(self):
        few, more, most = (self.calls(Many(count)) for count in (50, 100, 200))
        self.assertLess((most - more) / 100, MOST_CALLS)
        self.assertLess(most - more, 2 * (more - few) * 1.1)
        self.assertEqual(self.imported.counts["meshes"], 200)
        self.assertEqual(self.imported.counts["materials"], 5)

    def test_cages_that_are_the_same_are_refined_once(self):
        with mock.patch.object(
            Refinement, "__init__", autospec=True, side_effect=Refinement.__init__
        ) as made:
            self.calls(Many(20, scheme=None))
        self.assertEqual(made.call_count, 2)
        document = Container(self.folder / "many_20.glb").document.raw
        self.assertEqual(
            {document["accessors"][mesh["primitives"][0]["indices"]]["count"] for mesh in document["meshes"]},
            {9 * 16 * 6},
        )

    def test_decompositions_do_not_grow_with_the_points(self):
        random, codes = np.random.default_rng(0), np.arange(300.0)
        modes, rest = random.standard_normal((4, 3000, 3)), random.standard_normal((3000, 3))
        weights = random.standard_normal((300, 4))
        crumpled = random.standard_normal((300, 30, 3))
        cases = (
            (lambda code: rest + np.tensordot(weights[int(code)], modes, 1), 4, 1),
            # That nothing less than a target each would do is known from the sample alone.
            (lambda code: rest + np.tile(crumpled[int(code)], (100, 1)), 90, 1),
            (lambda code: rest + np.random.default_rng(int(code)).standard_normal(rest.shape), 300, 0),
        )
        for points_at, expected, passes in cases:
            with (
                mock.patch.object(np.linalg, "svd", side_effect=np.linalg.svd) as svd,
                mock.patch.object(bends, "_targets", side_effect=bends._targets) as targets,
            ):
                found = read_bend("/a", points_at, codes, rest)
            self.assertEqual(len(found.targets), expected)
            self.assertEqual([call.args[0].shape for call in svd.call_args_list], [(300, SAMPLED)])
            self.assertEqual(targets.call_count, passes)
            for code in (0.0, 150.0, 299.0):
                moved = np.tensordot(found.weights[int(code)], found.targets, 1)
                np.testing.assert_allclose(moved, points_at(code) - rest, atol=1e-4)


if __name__ == "__main__":
    unittest.main()
