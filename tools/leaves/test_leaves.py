"""Properties of the meshes: run with `python3 -m unittest discover -s tools/leaves`."""

import math
import tempfile
import unittest
from collections import Counter
from pathlib import Path

from leaf import make_leaf
from make_leaves import POSES, TOLERANCES, make_meshes
from mesh import Mesh, cross, subtract
from outlines import SPECIES
from plants import make_ground, make_tree
from triangulate import clip_ears, contains, distance_to_outline, doubled_area, triangulate


def all_leaves():
    """Every species at every level of detail."""
    for species in SPECIES:
        blade = species()
        for detail, tolerances in TOLERANCES.items():
            yield f"{blade.name}_{detail.suffix}", make_leaf(blade, detail, tolerances[blade.name], POSES[blade.name])


def triangles(mesh: Mesh):
    """Corner positions of every triangle."""
    for face in mesh.faces:
        for b, c in zip(face[1:], face[2:]):
            yield mesh.positions[face[0]], mesh.positions[b], mesh.positions[c]


class Triangulation(unittest.TestCase):
    def test_triangles_cover_the_polygon_once(self):
        for species in SPECIES:
            outline = species().outline
            area = sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(outline, outline[1:] + outline[:1]))
            areas = [doubled_area(*(outline[i] for i in t)) for t in clip_ears(outline)]
            self.assertTrue(all(a > 0 for a in areas))
            self.assertAlmostEqual(sum(areas), area, places=12)

    def test_interior_points_become_vertices(self):
        square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
        points, faces = triangulate(square, [(0.25, 0.5), (0.75, 0.5)])
        self.assertEqual(len(points), 6)
        self.assertEqual(len(faces), 6)  # Euler: 2 * 6 - 2 - 4
        self.assertAlmostEqual(sum(doubled_area(*(points[i] for i in f)) for f in faces), 2.0, places=9)

    def test_a_self_crossing_outline_is_refused(self):
        with self.assertRaises(ValueError):
            clip_ears([(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)])

    def test_inside_and_distance_of_a_square(self):
        square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
        self.assertTrue(contains(square, (0.5, 0.25)))
        self.assertFalse(contains(square, (1.5, 0.25)))
        self.assertAlmostEqual(distance_to_outline((0.5, 0.25), square), 0.25)


class Leaves(unittest.TestCase):
    def test_no_triangle_is_degenerate(self):
        for name, mesh in all_leaves():
            for a, b, c in triangles(mesh):
                self.assertGreater(math.hypot(*cross(subtract(b, a), subtract(c, a))), 1e-7, name)

    def test_an_edge_has_one_face_on_either_side(self):
        for name, mesh in all_leaves():
            edges = Counter(e for face in mesh.faces for e in zip(face, face[1:] + face[:1]))
            self.assertEqual(max(edges.values()), 1, name)

    def test_leaves_are_about_a_unit_long_and_lie_flat(self):
        for name, mesh in all_leaves():
            length = max(p[2] for p in mesh.positions) - min(p[2] for p in mesh.positions)
            if "canopy" not in name:  # Those have no petiole.
                self.assertTrue(0.85 < length <= 1.0, f"{name}: {length}")
            up = sum(cross(subtract(b, a), subtract(c, a))[1] for a, b, c in triangles(mesh))
            self.assertGreater(up, 0.0, name)

    def test_texture_coordinates_stay_in_the_picture(self):
        for name, mesh in all_leaves():
            self.assertTrue(all(0.0 <= c <= 1.0 for uv in mesh.uvs for c in uv), name)


class Plants(unittest.TestCase):
    def test_trees_face_outward(self):
        volume = sum(sum(x * n for x, n in zip(a, cross(b, c))) for a, b, c in triangles(make_tree("test", 10.0, 0.3, 4)))
        self.assertGreater(volume, 0.0)

    def test_the_ground_faces_up(self):
        for a, b, c in triangles(make_ground(10.0, 5.0, -5.0, 4, 4, 2.0)):
            self.assertGreater(cross(subtract(b, a), subtract(c, a))[1], 0.0)


class Files(unittest.TestCase):
    def test_the_meshes_in_the_scene_are_the_ones_made_here(self):
        committed = Path(__file__).resolve().parents[2] / "scenes" / "falling_leaves" / "meshes"
        with tempfile.TemporaryDirectory() as folder:
            make_meshes(Path(folder))
            made = {path.name: path.read_text() for path in Path(folder).glob("*.obj")}
        self.assertEqual(made, {path.name: path.read_text() for path in committed.glob("*.obj")})


if __name__ == "__main__":
    unittest.main()
