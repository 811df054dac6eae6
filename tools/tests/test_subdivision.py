"""Subdivision surfaces against what is known of them: limits, splines, planes, creases, and that
weights add up to 1."""

import unittest

import numpy as np

from sunfleck_tools.usd.reading.normals import smooth_normals
from sunfleck_tools.usd.reading.subdivision import Cage, refined

CUBE = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
CUBE_FACES = [0, 1, 3, 2, 4, 6, 7, 5, 0, 4, 5, 1, 2, 3, 7, 6, 0, 2, 6, 4, 1, 5, 7, 3]
TOP = [(1, 3), (3, 7), (7, 5), (5, 1)]
TETRAHEDRON = np.array([(1, 1, 1), (-1, -1, 1), (-1, 1, -1), (1, -1, -1)], float)


def cage(corners, count=4, creases=(), sharpness=10.0, sharp_vertices=(), **rules) -> Cage:
    """Faces of as many corners each."""
    corners = np.array(corners)
    at_vertex = np.zeros(corners.max() + 1)
    at_vertex[list(sharp_vertices)] = np.inf
    ends = np.array(creases, np.int64).reshape(-1, 2)
    return Cage(
        np.full(len(corners) // count, count),
        corners,
        ends,
        np.full(len(ends), sharpness),
        at_vertex,
        **rules,
    )


def smooth(faces: Cage, values: np.ndarray, levels: int) -> np.ndarray:
    """Values of the vertices of a level."""
    for level in refined(faces, levels):
        values = level.smooth(values)
    return values


def grid(size: int) -> np.ndarray:
    """Corners of size x size quads."""
    at = np.arange((size + 1) ** 2).reshape(size + 1, size + 1)
    return np.stack([at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]], axis=-1).ravel()


class Limits(unittest.TestCase):
    def test_corners_of_a_cube_go_half_way_in(self):
        # (9 v + 4 (its neighbours) + (the corners opposite in its faces)) / 24 (Halstead, Kass and
        # DeRose 1993) = (9 + 4 - 1) / 24.
        np.testing.assert_allclose(smooth(cage(CUBE_FACES), CUBE, 7)[:8], 0.5 * CUBE, atol=1e-5)

    def test_corners_of_a_tetrahedron_by_loops_rule(self):
        # n beta = 9/16: the limit has 1 / (1 + 8/3 * 9/16) = 2/5 of a vertex and 3/5 of its
        # neighbours' mean, -v/3.
        found = smooth(cage([0, 1, 2, 0, 3, 1, 0, 2, 3, 1, 3, 2], 3, is_loop=True), TETRAHEDRON, 7)
        np.testing.assert_allclose(found[:4], 0.2 * TETRAHEDRON, atol=1e-5)

    def test_a_grid_is_a_uniform_cubic_spline(self):
        """Control points k**3 - k stand for the cubic x**3 at their knots: B-spline values
        (a + 4 b + c) / 6."""
        x = np.repeat(np.arange(9.0), 9)
        heights = smooth(cage(grid(8)), np.stack([x, x**3 - x], axis=1), 3)
        inside = (heights[:, 0] > 3) & (heights[:, 0] < 5)
        # A level's own control points, at its distance, stand for it likewise.
        expected = heights[inside, 0] ** 3 - heights[inside, 0] / 8**2
        np.testing.assert_allclose(heights[inside, 1], expected, atol=1e-9)

    def test_open_edges_are_cubic_splines_and_corners_stay(self):
        points = np.stack([np.repeat(np.arange(5.0), 5), np.tile(np.arange(5.0), 5)], axis=1)
        edge = points[:, 0] == 0
        values = np.where(edge, points[:, 1] ** 3 - points[:, 1], 77.0)
        faces = cage(grid(4))
        found = smooth(
            faces.with_sharp_vertices(faces.faces_at_vertex == 1), np.column_stack([points, values]), 2
        )
        at = (found[:, 0] == 0) & (found[:, 1] > 1.5) & (found[:, 1] < 2.5)
        np.testing.assert_allclose(found[at, 2], found[at, 1] ** 3 - found[at, 1] / 4**2, atol=1e-9)
        np.testing.assert_allclose(found[[0, 4, 20, 24], :2], points[[0, 4, 20, 24]], atol=1e-12)


class Creases(unittest.TestCase):
    def test_all_edges_sharp_is_the_cube_itself(self):
        edges = [(a, b) for a in range(8) for b in range(a) if np.abs(CUBE[a] - CUBE[b]).sum() == 2]
        found = smooth(cage(CUBE_FACES, creases=edges), CUBE, 2)
        np.testing.assert_allclose(np.abs(found).max(axis=1), 1.0, atol=1e-12)
        self.assertEqual(len(found), 98)

    def test_a_sharp_ring_stays_in_its_plane(self):
        found = smooth(cage(CUBE_FACES, creases=TOP), CUBE, 3)
        np.testing.assert_allclose(found[[1, 3, 5, 7], 2], 1.0, atol=1e-12)
        # The ring alone is the spline of four points, whose limit is (a + 4 b + c) / 6: 4/6 of a corner.
        np.testing.assert_allclose(
            smooth(cage(CUBE_FACES, creases=TOP), CUBE, 8)[1, :2], [-2 / 3, -2 / 3], atol=1e-4
        )

    def test_sharpness_ends(self):
        """One level sharp, then smooth: what sharpness 1 gives is the smooth surface of the cage that one
        sharp level gives."""
        once = refined(cage(CUBE_FACES, creases=TOP, sharpness=10), 1)[0]
        fine = once.finer
        blunt = Cage(
            fine.counts, fine.corners, np.zeros((0, 2), np.int64), np.zeros(0), np.zeros(fine.vertices)
        )
        expected = smooth(blunt, once.smooth(CUBE), 2)
        np.testing.assert_allclose(
            smooth(cage(CUBE_FACES, creases=TOP, sharpness=1), CUBE, 3), expected, atol=1e-12
        )

    def test_half_sharp_lies_half_way(self):
        sharp, half, blunt = (
            smooth(cage(CUBE_FACES, creases=TOP, sharpness=each), CUBE, 1) for each in (1, 0.5, 0)
        )
        np.testing.assert_allclose(half, 0.5 * (sharp + blunt), atol=1e-12)
        self.assertGreater(np.abs(sharp - blunt).max(), 0.1)

    def test_a_sharp_vertex_stays(self):
        np.testing.assert_array_equal(smooth(cage(CUBE_FACES, sharp_vertices=[5]), CUBE, 3)[5], CUBE[5])


class Properties(unittest.TestCase):
    CAGES = (cage(CUBE_FACES), cage(CUBE_FACES, creases=TOP, sharpness=1.7), cage(grid(3)), cage([0, 1, 2, 0, 2, 3], 3, is_loop=True),
             cage([0, 1, 2, 0, 2, 3], 3), cage([0, 1, 2, 0, 2, 3], 3, smooth_triangles=True), cage([0, 1, 2, 3, 4], 5),
             cage([0, 1, 2, 0, 1, 3, 0, 1, 4], 3, creases=[(0, 2)], sharpness=0.3))  # fmt: skip

    def test_weights_add_up_to_one(self):
        """So places move as the cage does, and a plane stays one."""
        for faces in self.CAGES:
            for level in refined(faces, 2):
                np.testing.assert_allclose(level.smooth(np.ones((level.cage.vertices, 1))), 1.0, atol=1e-12)
                np.testing.assert_allclose(level.linear(np.ones((level.cage.vertices, 1))), 1.0, atol=1e-12)

    def test_faces_keep_their_side(self):
        flat = np.column_stack([np.repeat(np.arange(4.0), 4), np.tile(np.arange(4.0), 4), np.zeros(16)])
        for faces, points in (
            (cage(grid(3)), flat),
            (cage([0, 1, 2, 0, 2, 3], 3, is_loop=True), flat[[0, 4, 5, 1]]),
        ):
            levels = refined(faces, 2)
            for level in levels:
                points = level.smooth(points)
            finest = levels[-1].finer
            self.assertEqual(len(finest.counts), len(faces.counts) * 16)
            normals = smooth_normals(finest, points)
            np.testing.assert_allclose(np.abs(normals[:, 2]), 1.0)
            self.assertEqual(len(np.unique(normals[:, 2] > 0)), 1)

    def test_normals_are_split_by_sharp_edges_alone(self):
        for creases, expected in (((), 98), (TOP, 98 + 16)):
            levels, points = refined(cage(CUBE_FACES, creases=creases), 2), CUBE
            for level in levels:
                points = level.smooth(points)
            finest = levels[-1].finer
            rows = np.column_stack([finest.corners, np.round(smooth_normals(finest, points), 9)])
            self.assertEqual(len(np.unique(rows, axis=0)), expected)


if __name__ == "__main__":
    unittest.main()
