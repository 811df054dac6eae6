"""Properties of the meshes: run with `python3 -m unittest discover -s tools/leaves/tests -t tools/leaves`."""

import math
import os
import struct
import tempfile
import unittest
import zlib
from collections import Counter
from pathlib import Path

from bark import FURROWS_M
from floor import ground_height, laid_height, make_drifts, make_fern, make_ground
from leaf import NEAR, RELIEF, Pose, make_leaf
from make_leaves import (
    AGES,
    LIT_THROUGH,
    MORE_BEECHES,
    MORE_MAPLES,
    MORE_OAKS,
    leaves,
    make_meshes,
    make_textures,
)
from maps import blemished, leaf_maps
from mesh import Mesh, cross, subtract
from outlines import SPECIES, beech, maple, oak
from paint import FLOORS, paint_leaf, paint_light_through, paint_normals
from palettes import RAMPS
from trees import HABITS, make_tree
from triangulate import clip_ears, contains, distance_to_outline, doubled_area, triangulate

WOODS = Path(__file__).resolve().parents[3] / "scenes" / "woods"
LEAVES = {name: mesh for name, (mesh, _) in leaves().items()}


def blades():
    """Every species, and the other individuals of maple, oak and beech."""
    return [
        *(species() for species in SPECIES),
        *map(maple, MORE_MAPLES),
        *map(oak, MORE_OAKS),
        *map(beech, MORE_BEECHES),
    ]


def pixels(path: Path) -> list[tuple[bytes, bytes]]:
    """The chunks of a PNG file, unpacked: libraries may pack the same rows differently."""
    rest, chunks = path.read_bytes()[8:], []
    while rest:
        length, kind = struct.unpack(">I4s", rest[:8])
        chunks.append(
            (kind, zlib.decompress(rest[8 : 8 + length]) if kind == b"IDAT" else rest[8 : 8 + length])
        )
        rest = rest[12 + length :]
    return chunks


def triangles(mesh: Mesh):
    """Corner positions of every triangle."""
    for face in mesh.faces:
        for b, c in zip(face[1:], face[2:]):
            yield mesh.positions[face[0]], mesh.positions[b], mesh.positions[c]


class Triangulation(unittest.TestCase):
    def test_triangles_cover_the_polygon_once(self):
        for blade in blades():
            outline = blade.outline
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
        for name, mesh in LEAVES.items():
            for a, b, c in triangles(mesh):
                self.assertGreater(math.hypot(*cross(subtract(b, a), subtract(c, a))), 1e-7, name)

    def test_an_edge_has_one_face_on_either_side(self):
        for name, mesh in LEAVES.items():
            edges = Counter(e for face in mesh.faces for e in zip(face, face[1:] + face[:1]))
            self.assertEqual(max(edges.values()), 1, name)

    def test_leaves_are_about_a_unit_long_and_lie_flat(self):
        for name, mesh in LEAVES.items():
            length = max(p[2] for p in mesh.positions) - min(p[2] for p in mesh.positions)
            if "canopy" not in name:  # Those have no petiole.
                self.assertTrue(0.85 < length <= 1.0, f"{name}: {length}")
            up = sum(cross(subtract(b, a), subtract(c, a))[1] for a, b, c in triangles(mesh))
            self.assertGreater(up, 0.0, name)

    def test_texture_coordinates_stay_in_the_picture(self):
        for name, mesh in LEAVES.items():
            self.assertTrue(all(0.0 <= c <= 1.0 for uv in mesh.uvs for c in uv), name)


    def test_details_of_a_leaf_cover_about_the_same_area(self):
        # What a crown holds back of the sun shall not depend on how finely its leaves are cut.
        for species in SPECIES:
            name = species().name
            near, far, canopy = (
                sum(math.hypot(*cross(subtract(b, a), subtract(c, a))) / 2 for a, b, c in triangles(LEAVES[f"{name}_{detail}"]))
                for detail in ("near", "far", "canopy")
            )
            self.assertAlmostEqual(far / near, 1.0, delta=0.15, msg=name)
            self.assertAlmostEqual(canopy / near, 1.0, delta=0.35, msg=name)

    def test_a_near_leaf_rises_between_its_veins(self):
        flat = Pose(fold_rad=0.0, curl_rad=0.0, cup=0.0, ripple=0.0)
        for blade in (maple(), maple("b")):
            leaf = make_leaf(blade, NEAR, 0.0015, flat)
            size = 1.0 / (1.0 + blade.petiole_length)
            heights = [
                y / size for x, y, z in leaf.positions if z < 0.5 * size - 0.02
            ]  # Without the petiole.
            self.assertAlmostEqual(max(heights), RELIEF, places=12)
            self.assertLess(min(heights), 1e-12)
            self.assertGreater(sum(y < 0.1 * RELIEF for y in heights), 30)

    def test_a_hanging_leaf_hangs_by_its_petiole(self):
        for name, mesh in LEAVES.items():
            if name.endswith("far_hanging"):
                nearest = min(math.hypot(*p) for p in mesh.positions)
                self.assertLess(nearest, 0.03, name)
                self.assertLess(max(p[2] for p in mesh.positions), 0.06, name)


class Outlines(unittest.TestCase):
    def test_outlines_do_not_cross_themselves(self):
        for blade in blades():
            edges = list(zip(blade.outline, blade.outline[1:] + blade.outline[:1]))
            for i, (a, b) in enumerate(edges):
                for c, d in edges[i + 2 : len(edges) - (i == 0)]:
                    apart = (
                        doubled_area(a, b, c) * doubled_area(a, b, d) >= 0
                        or doubled_area(c, d, a) * doubled_area(c, d, b) >= 0
                    )
                    self.assertTrue(apart, f"{blade.name}: {a}-{b} and {c}-{d}")

    def test_species_are_as_narrow_and_wide_as_they_should_be(self):
        areas = {}
        for species in SPECIES:
            outline = species().outline
            areas[species().name] = (
                sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(outline, outline[1:] + outline[:1])) / 2
            )
        self.assertEqual(
            sorted(areas, key=areas.get), ["willow", "oak", "beech", "birch", "maple", "aspen", "ginkgo"]
        )
        self.assertTrue(0.08 < areas["willow"] and areas["ginkgo"] < 1.2, areas)

    def test_veins_start_at_the_petiole_or_on_the_blade(self):
        for blade in blades():
            for vein in blade.veins:
                self.assertTrue(
                    vein[0] == (0, 0) or contains(blade.outline, vein[0]) or abs(vein[0][0]) < 1e-9,
                    blade.name,
                )


class Colours(unittest.TestCase):
    def test_ramps_change_without_a_jump_and_stay_colours(self):
        for name, ramp in RAMPS.items():
            colors = [ramp.at(-0.5 + i / 500) for i in range(1000)]
            self.assertTrue(all(0 <= c <= 255 for color in colors for c in color), name)
            self.assertLess(max(math.dist(a, b) for a, b in zip(colors, colors[1:])), 2.0, name)

    def test_leaves_turn_from_green_to_brown(self):
        for name, ramp in RAMPS.items():
            (r0, g0, b0), (r1, g1, b1) = ramp.at(0.0), ramp.at(1.0)
            self.assertTrue(g0 > r0 > b0, name)
            self.assertTrue(r1 > g1 > b1, name)

    def test_pictures_are_made_of_their_seed_alone(self):
        shared = leaf_maps(maple(), 48)
        age, ramp = AGES["maple"]["amber"], RAMPS["maple"]
        pictures = [
            paint(blemished(shared, seed), ramp, age)
            for seed in "aab"
            for paint in (paint_leaf, paint_light_through)
        ]
        self.assertEqual(pictures[0:2], pictures[2:4])
        self.assertNotEqual(pictures[0], pictures[4])
        for picture in pictures:
            self.assertEqual({len(row) for row in picture}, {3 * 48})


class Relief(unittest.TestCase):
    def test_normals_are_unit_vectors_and_face_out_of_the_picture(self):
        size = 48
        rows = paint_normals(leaf_maps(maple(), 2 * size))
        self.assertEqual({len(row) for row in rows}, {3 * size})
        for row in rows:
            for x in range(size):
                normal = [value / 127.5 - 1 for value in row[3 * x : 3 * x + 3]]
                self.assertAlmostEqual(math.hypot(*normal), 1.0, delta=0.02)
                self.assertGreater(normal[2], 0.5)

    def test_the_midrib_lies_in_a_furrow(self):
        # Both its sides face it; beside the leaf all is flat.
        half = 24
        rows = paint_normals(leaf_maps(maple(), 4 * half))
        left, right = (
            sum(row[3 * x] for row in rows[half // 2 : half] for x in (at, at + 1)) / half
            for at in (half - 2, half)
        )
        self.assertGreater(left, 135)
        self.assertLess(right, 120)
        self.assertEqual(tuple(rows[0][0:3]), (128, 128, 255))


class Plants(unittest.TestCase):
    def test_trees_face_outward_and_stand_on_the_ground(self):
        for name, habit in HABITS.items():
            tree = make_tree("test", habit)
            volume = sum(sum(x * n for x, n in zip(a, cross(b, c))) for a, b, c in triangles(tree.wood))
            self.assertGreater(volume, 0.0, name)
            self.assertTrue(
                all(math.isfinite(x) for p in tree.wood.positions + tree.twigs.positions for x in p), name
            )
            for face in tree.twigs.faces if habit.twig_sides == 3 else []:  # A strip faces both ways.
                # Seen from the middle of its own twig, which has six points, every face is turned away.
                first = min(face) // 6 * 6
                middle = [sum(p[k] for p in tree.twigs.positions[first : first + 6]) / 6 for k in range(3)]
                a, b, c, d = (tree.twigs.positions[i] for i in face)
                normal = cross(subtract(c, a), subtract(d, b))
                self.assertGreater(
                    sum(n * (a[k] + c[k] - 2 * middle[k]) for k, n in enumerate(normal)), 0.0, name
                )
            self.assertLess(min(p[1] for p in tree.wood.positions), 0.0, name)
            self.assertGreater(min(p[1] for p in tree.twigs.positions), 0.0, name)
            self.assertAlmostEqual(
                max(p[1] for p in tree.wood.positions) / habit.height_m, 1.0, delta=0.3, msg=name
            )

    def test_twigs_have_room_for_ten_thousand_leaves(self):
        # Half a metre of twig for a dozen leaves.
        for name in ("oak", "maple", "beech", "birch"):
            habit = HABITS[name]
            length = habit.limbs * habit.branches * habit.twigs * habit.twig_length_m * 0.9
            self.assertGreater(length / 0.5 * 40, 10_000, name)

    def test_another_seed_is_another_tree(self):
        one, same, other = (make_tree(seed, HABITS["sapling"]).wood.positions for seed in "aab")
        self.assertEqual(one, same)
        self.assertNotEqual(one, other)

    def test_the_ground_faces_up_and_its_pieces_meet(self):
        here, beyond = (
            make_ground(-6.0, 6.0, 3.0, -6.0, 3.0, 2.0),
            make_ground(-6.0, 6.0, -6.0, -12.0, 3.0, 2.0),
        )
        for a, b, c in [*triangles(here), *triangles(beyond)]:
            self.assertGreater(cross(subtract(b, a), subtract(c, a))[1], 0.0)
        self.assertEqual(len(set(here.positions) & set(beyond.positions)), 5)
        self.assertTrue(all(p[1] == ground_height(p[0], p[2]) for p in here.positions))

    def test_drifts_lie_on_the_ground_as_it_is_laid_and_end_below_it(self):
        drifts = make_drifts(-9.0, 9.0, 9.0, -12.0, 0.5)
        ground = {(p[0], p[2]): p[1] for p in make_ground(-9.0, 9.0, 9.0, -12.0, 3.0, 2.6).positions}
        for (x, z), height in ground.items():
            self.assertAlmostEqual(laid_height(x, z), height)
        above = [p[1] - laid_height(p[0], p[2]) for p in drifts.positions]
        self.assertLess(max(above), 0.2)
        self.assertLess(min(above), 0.0)
        self.assertLess(len(drifts.faces), 0.7 * 36 * 42)

    def test_ferns_rise_from_where_they_stand(self):
        fern = make_fern("test", 7, 1.0, 12)
        self.assertEqual(fern.triangle_count(), 7 * 12 * 2 * 2)
        self.assertTrue(all(math.hypot(p[0], p[2]) < 1.6 for p in fern.positions))


class Files(unittest.TestCase):
    def test_the_meshes_in_the_scene_are_the_ones_made_here(self):
        committed = WOODS / "meshes"
        with tempfile.TemporaryDirectory() as folder:
            make_meshes(Path(folder))
            made = {path.name: path.read_text() for path in Path(folder).glob("*.obj")}
        self.assertEqual(made, {path.name: path.read_text() for path in committed.glob("*.obj")})

    def test_the_textures_in_the_scene_are_the_ones_made_here(self):
        # Every texture that is no leaf's, and those of one species; with SUNFLECK_LONG=1 all,
        # which takes minutes.
        only = [""] if os.environ.get("SUNFLECK_LONG") else ["willow", "litter", "soil", "bark"]
        committed = {path.name: pixels(path) for path in (WOODS / "textures").glob("*.png")}
        with tempfile.TemporaryDirectory() as folder:
            for name in only:
                make_textures(Path(folder), name)
            made = {path.name: pixels(path) for path in Path(folder).glob("*.png")}
        self.assertGreaterEqual(len(made), 7)
        for name, picture in made.items():
            self.assertEqual(picture, committed.get(name), name)

    def test_no_other_textures_are_in_the_scene(self):
        names = {f"{species}_{kind}" for species, ages in AGES.items() for kind in ["relief", *ages]}
        names |= {f"{species}_{age}_through" for species, ages in LIT_THROUGH.items() for age in ages}
        names |= {*FLOORS, *(f"bark_{kind}{part}" for kind in FURROWS_M for part in ("", "_relief"))}
        self.assertEqual(names, {path.stem for path in (WOODS / "textures").glob("*.png")})


if __name__ == "__main__":
    unittest.main()
