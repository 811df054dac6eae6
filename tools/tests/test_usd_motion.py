"""`import-usd`: what changes over time: points, faces, instances that come and go, and what a shutter reaches
outside the frames."""

import unittest
from pathlib import Path

import numpy as np
from pxr import Sdf, Usd, UsdGeom, Vt

from sunfleck_tools import SceneError
from sunfleck_tools.gltf.deformation import Bending
from sunfleck_tools.gltf.meshes import Meshes
from sunfleck_tools.gltf.scene import Gltf
from sunfleck_tools.usd import import_usd
from sunfleck_tools.usd.reading import bends
from sunfleck_tools.usd.reading.bends import read_bend

from .test_usd_export import inspect, needs_program
from .test_usd_import import QUAD, quad
from .test_usd_scenes import SceneCase


class MotionCase(SceneCase):
    def bent(self, gltf: Gltf, name: str, frame: float) -> np.ndarray:
        """Where the vertices of a node's mesh are in the world at a frame, sorted."""
        node, seconds = self.node(gltf, name), gltf.settings.seconds(np.array([frame]))
        mesh = Meshes(gltf, []).of(node)[1]
        points = np.concatenate(
            [Bending(gltf, node, mesh).positions(each, seconds)[0] for each in mesh.primitives]
        )
        world = node.world_from_node(seconds)[0]
        points = points @ world[:3, :3].T + world[:3, 3]
        return points[np.lexsort(np.round(points, 5).T)]

    def shown(self, gltf: Gltf, frame: float) -> list[str]:
        """Nodes with meshes that are seen at a frame."""
        return [
            each.name
            for each in gltf.nodes
            if each.source.member("mesh") is not None and self.is_seen(gltf, each.name, frame)
        ]

    def x_of(self, gltf: Gltf, frame: float) -> list[float]:
        """Where those are, along x."""
        seconds = gltf.settings.seconds(np.array([frame]))
        return [
            round(float(self.node(gltf, name).world_from_node(seconds)[0, 0, 3]), 4)
            for name in self.shown(gltf, frame)
        ]


class Bends(MotionCase):
    def test_several_in_one_place(self):
        gltf = self.case("W_two_deforming")
        for frame, top in ((1, 1.0), (2, 2.0), (2.5, 2.5), (3, 3.0)):
            for name, left, right in (("Body", -1, 1), ("Cloth", 2, 3)):
                points = self.bent(gltf, name, frame)
                np.testing.assert_allclose(
                    [points.min(axis=0), points.max(axis=0)], [[left, -1, 0], [right, top, 0]], atol=1e-6
                )
        self.assertEqual(self.imported.lost, [])

    def test_one_that_bends_beside_one_that_stays(self):
        stage = self.stage()
        UsdGeom.Xform.Define(stage, "/char")
        quad(stage, "/char/still")
        points = quad(stage, "/char/bends").GetPointsAttr()
        for code, height in ((1, 0), (5, 4)):
            points.Set(np.array(QUAD) + [0, 0, height], code)
        gltf = self.load(stage)
        self.assertEqual(len(self.shown(gltf, 1)), 2)
        np.testing.assert_allclose(self.bent(gltf, "bends", 3)[:, 2], 2.0, atol=1e-6)
        np.testing.assert_allclose(self.bent(gltf, "char", 3)[:, 2], 0.0, atol=1e-6)

    def test_subdivision_surfaces_and_solids_bend(self):
        stage = self.stage()
        mesh = quad(stage, "/a")
        mesh.CreateSubdivisionSchemeAttr("catmullClark")
        sphere = UsdGeom.Sphere.Define(stage, "/b")
        for code, size in ((1, 1.0), (5, 3.0)):
            mesh.GetPointsAttr().Set(np.array(QUAD) * size, code)
            sphere.CreateRadiusAttr().Set(size, code)
        gltf = self.load(stage)
        for frame, size in ((1, 1.0), (3, 2.0), (5, 3.0)):
            self.assertEqual(len(self.bent(gltf, "a", frame)), 25)
            np.testing.assert_allclose(self.bent(gltf, "a", frame).max(axis=0), [size, size, 0], atol=1e-5)
            np.testing.assert_allclose(np.linalg.norm(self.bent(gltf, "b", frame), axis=1), size, rtol=1e-5)

    def test_normals_turn_along(self):
        """A square that turns about x, as a cage and with normals of its own; between samples
        points go straight."""
        for scheme in ("catmullClark", "none"):
            stage = self.stage()
            mesh = quad(stage, "/a")
            mesh.CreateSubdivisionSchemeAttr(scheme)
            for code in range(1, 6):
                angle = np.radians(20 * (code - 1))
                turn = np.array(
                    [[1, 0, 0], [0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]]
                )
                mesh.GetPointsAttr().Set(
                    Vt.Vec3fArray.FromNumpy((np.array(QUAD) @ turn.T).astype(np.float32)), code
                )
                if scheme == "none":
                    mesh.CreateNormalsAttr().Set([tuple(turn[:, 2])] * 4, code)
            mesh.SetNormalsInterpolation("vertex")
            gltf = self.load(stage)
            node = self.node(gltf, "a")
            primitive = gltf.document.items("meshes")[node.source.raw["mesh"]].items("primitives")[0]
            lists = [primitive.member("attributes"), *primitive.items("targets")]
            rest, *targets = (gltf.accessors.floats(each.member("NORMAL"), 3) for each in lists)
            for frame in (1, 2, 3.5, 5):
                weights = node.weights.at(gltf.settings.seconds(np.array([frame])))[0]
                normals = rest + np.tensordot(weights, targets, 1)
                normals /= np.linalg.norm(normals, axis=1)[:, None]
                angle = np.radians(20 * (frame - 1))
                np.testing.assert_allclose(
                    normals, np.tile([0, -np.sin(angle), np.cos(angle)], (len(rest), 1)), atol=1e-3
                )

    def test_few_targets_where_few_do(self):
        random = np.random.default_rng(1)
        modes, codes = random.standard_normal((3, 50, 3)), np.arange(40.0)
        rest = random.standard_normal((50, 3))
        movement = np.einsum("cm,mpi->cpi", np.sin(codes[:, None] * [0.1, 0.2, 0.37]), modes)
        found = read_bend("/a", lambda code: rest + movement[int(code)], codes, rest)
        self.assertEqual(len(found.targets), 3)
        np.testing.assert_allclose(
            np.einsum("cm,mpi->cpi", found.weights, found.targets), movement, atol=1e-5
        )
        self.assertLessEqual(np.abs(found.weights).max(), 1 + 1e-9)

    def test_a_target_a_code_where_few_do_not(self):
        random = np.random.default_rng(2)
        rest, codes = random.standard_normal((50, 3)), np.arange(40.0)
        movement = random.standard_normal((40, 50, 3))
        # Whatever rests, or comes again, has no target of its own.
        movement[:10] = 0
        movement[30:] = movement[20:30]
        found = read_bend("/a", lambda code: rest + movement[int(code)], codes, rest)
        self.assertEqual(len(found.targets), 20)
        np.testing.assert_allclose(
            np.einsum("cm,mpi->cpi", found.weights, found.targets), movement, atol=1e-5
        )

    def test_what_is_too_much_is_left_out(self):
        stage = self.stage()
        quad(stage, "/a")
        points = quad(stage, "/b").GetPointsAttr()
        for code in (1, 5):
            points.Set(np.array(QUAD) * code, code)
        most, bends.MOST_VALUES = bends.MOST_VALUES, 20
        try:
            self.load(stage)
        finally:
            bends.MOST_VALUES = most
        self.assertIn(
            "/b: is left out: 4 points that change over 5 frames are too many", self.said()["usd-prim"]
        )


class Faces(MotionCase):
    def test_that_change_take_turns(self):
        gltf = self.case("W2_varying_points")
        self.assertEqual([len(self.shown(gltf, frame)) for frame in (1, 1.5, 2, 3)], [1, 1, 1, 1])
        for frame, corners, top in ((1, 3, 1), (1.5, 3, 1), (2, 4, 3), (3, 4, 3)):
            points = self.bent(gltf, self.shown(gltf, frame)[0], frame)
            self.assertEqual((len(points), points[:, 1].max()), (corners, top))
        self.assertEqual(self.imported.lost, [])

    def test_that_change_right_after_the_last_frame(self):
        stage = self.stage()
        stage.SetEndTimeCode(1)
        mesh = quad(stage, "/a")
        for code, count in ((1, 4), (2, 3)):
            mesh.GetPointsAttr().Set(QUAD[:count], code)
            mesh.GetFaceVertexCountsAttr().Set([count], code)
            mesh.GetFaceVertexIndicesAttr().Set(list(range(count)), code)
        gltf = self.load(stage)
        self.assertEqual(len(self.bent(gltf, self.shown(gltf, 1)[0], 1)), 4)
        self.assertEqual(self.imported.lost, [])

    def test_the_same_points_with_other_faces(self):
        """Points are then mixed between samples, as USD does, and faces are not."""
        stage = self.stage()
        mesh = quad(stage, "/a")
        counts, corners = mesh.GetFaceVertexCountsAttr(), mesh.GetFaceVertexIndicesAttr()
        for code, faces in ((1, [0, 1, 2]), (3, [0, 2, 3])):
            counts.Set([3], code)
            corners.Set(faces, code)
            mesh.GetPointsAttr().Set(np.array(QUAD) + [0, 0, code], code)
        gltf = self.load(stage)
        for frame, height, x in ((1, 1, 1), (2, 2, 1), (2.9, None, 1), (3, 3, 0), (5, 3, 0)):
            name = self.shown(gltf, frame)[0]
            points = self.bent(gltf, name, frame)
            # (1, 0) is a corner of the first triangle alone.
            self.assertEqual(bool((np.abs(points[:, :2] - [1, 0]) < 1e-6).all(axis=1).any()), bool(x))
            if height is not None:
                np.testing.assert_allclose(points[:, 2], height, atol=1e-6)

    def test_that_move_by_velocities(self):
        stage = self.stage()
        stage.SetTimeCodesPerSecond(8)
        mesh = quad(stage, "/a")
        for code, count in ((1, 4), (2, 3), (3, 4)):
            mesh.GetPointsAttr().Set(QUAD[:count], code)
            mesh.GetFaceVertexCountsAttr().Set([count], code)
            mesh.GetFaceVertexIndicesAttr().Set(list(range(count)), code)
            mesh.CreateVelocitiesAttr().Set([(0, 0, 8)] * count, code)
        gltf = self.load(stage)
        for frame, count in ((1, 4), (1.5, 4), (2, 3), (2.5, 3), (3, 4)):
            points = self.bent(gltf, self.shown(gltf, frame)[0], frame)
            self.assertEqual(len(points), count)
            # 8 units a second are 1 a frame.
            np.testing.assert_allclose(points[:, 2], frame % 1, atol=1e-5, err_msg=str(frame))

    def test_that_move_by_velocities_from_the_only_sample(self):
        stage = self.stage()
        stage.SetTimeCodesPerSecond(8)
        mesh = quad(stage, "/a")
        mesh.GetPointsAttr().Set(QUAD, 1)
        mesh.CreateVelocitiesAttr().Set([(0, 0, 8)] * 4, 1)
        gltf = self.load(stage)
        for frame in (1, 1.5, 3, 5):
            points = self.bent(gltf, self.shown(gltf, frame)[0], frame)
            np.testing.assert_allclose(points[:, 2], frame - 1, atol=1e-5, err_msg=str(frame))

    def test_a_time_that_cannot_be_read_is_left_out(self):
        stage = self.stage()
        mesh = quad(stage, "/a")
        for code, corners in ((1, [0, 1, 2, 3]), (2, [0, 1, 2, 9]), (4, [3, 2, 1, 0])):
            mesh.GetFaceVertexIndicesAttr().Set(corners, code)
        gltf = self.load(stage)
        self.assertEqual([len(self.shown(gltf, frame)) for frame in (1, 2, 3, 4)], [1, 0, 0, 1])
        self.assertIn("from 0 to 9", self.said()["usd-prim"])


class Instances(MotionCase):
    def crowd(self, stage: Usd.Stage) -> UsdGeom.PointInstancer:
        instancer = UsdGeom.PointInstancer.Define(stage, "/crowd")
        for name in "pq":
            quad(stage, f"/crowd/{name}")
        instancer.CreatePrototypesRel().SetTargets(["/crowd/p", "/crowd/q"])
        return instancer

    def test_that_are_masked_for_a_while(self):
        gltf = self.case("H_instancer_anim_vis")
        for frame, expected in ((1, [-2, 0, 2]), (4.9, [-2, 0, 2]), (5, [-2, 2]), (10, [-2, 2])):
            self.assertEqual(self.x_of(gltf, frame), expected)

    def test_that_come_later(self):
        gltf = self.case("H2_instancer_velocities")
        for frame, expected in ((1, [-2, 0]), (4, [-2, 0]), (5, [-2, 0, 2]), (10, [-2, 0, 2])):
            self.assertEqual(self.x_of(gltf, frame), expected)
        self.assertEqual(self.imported.lost, [])

    @needs_program
    def test_the_renderer_agrees(self):
        for name, counts in (
            ("H_instancer_anim_vis", {1: 3, 4: 3, 5: 2}),
            ("H2_instancer_velocities", {1: 2, 4: 2, 5: 3}),
        ):
            self.case(name)
            for frame, found in inspect(self.folder / "case.glb", list(counts)).items():
                seen = [
                    key for key, node in found["nodes"].items() if key.startswith("PI.") and node["visible"]
                ]
                self.assertEqual(len(seen), counts[frame], f"{name}, frame {frame}")

    def test_particles_are_told_apart_by_their_ids(self):
        """One dies as another is born: there are as many, in the same places of the arrays."""
        stage = self.stage()
        instancer = self.crowd(stage)
        for code, ids, xs in ((1, [7, 8], [0, 10]), (3, [8, 9], [12, 20]), (5, [9], [22])):
            instancer.CreateIdsAttr().Set(ids, code)
            instancer.CreateProtoIndicesAttr().Set([0] * len(ids), code)
            instancer.CreatePositionsAttr().Set([(x, 0, 0) for x in xs], code)
        gltf = self.load(stage)
        at = {frame: dict(zip(self.shown(gltf, frame), self.x_of(gltf, frame))) for frame in (1, 2, 3, 5)}
        # Between two samples with other ids nobody is where another will be.
        self.assertEqual(at[1], {"crowd.7": 0, "crowd.8": 10})
        self.assertEqual(set(at[2]), {"crowd.7", "crowd.8"})
        self.assertEqual((at[2]["crowd.7"], at[3]), (0, {"crowd.8": 12, "crowd.9": 20}))
        self.assertEqual(at[5], {"crowd.9": 22})
        ids = {
            node.name: node.extras.raw.get("leaf_id") for node in gltf.nodes if node.name.startswith("crowd.")
        }
        self.assertEqual(ids, {"crowd.7": 7, "crowd.8": 8, "crowd.9": 9})

    def test_that_change_their_prototype(self):
        stage = self.stage()
        instancer = self.crowd(stage)
        quad(stage, "/crowd/q").GetPointsAttr().Set(np.array(QUAD) * 2)
        instancer.CreatePositionsAttr([(0, 0, 0)])
        for code, number in ((1, 0), (3, 1), (4, 0)):
            instancer.CreateProtoIndicesAttr().Set([number], code)
        gltf = self.load(stage)
        sizes = [
            [self.bent(gltf, name, frame).max() for name in self.shown(gltf, frame)]
            for frame in (1, 2, 3, 3.5, 4, 5)
        ]
        self.assertEqual(sizes, [[1], [1], [2], [2], [1], [1]])

    def test_velocities_carry_between_samples(self):
        stage = self.stage()
        stage.SetTimeCodesPerSecond(10)
        instancer = self.crowd(stage)
        instancer.CreateProtoIndicesAttr([0])
        for code, x in ((1, 0), (5, 100)):
            instancer.CreatePositionsAttr().Set([(x, 0, 0)], code)
            instancer.CreateVelocitiesAttr().Set([(10, 0, 0)], code)
        gltf = self.load(stage)
        self.assertEqual([self.x_of(gltf, frame) for frame in (1, 2, 4, 5)], [[0], [1], [3], [100]])

    def test_velocities_carry_on_from_the_only_sample(self):
        stage = self.stage()
        stage.SetTimeCodesPerSecond(10)
        instancer = self.crowd(stage)
        instancer.CreateProtoIndicesAttr([0])
        instancer.CreatePositionsAttr().Set([(0, 0, 0)], 1)
        instancer.CreateVelocitiesAttr().Set([(10, 0, 0)], 1)
        gltf = self.load(stage)
        self.assertEqual([self.x_of(gltf, frame) for frame in (1, 2, 4, 5)], [[0], [1], [3], [4]])

    def test_a_prototype_that_is_missing_leaves_the_others(self):
        stage = self.stage()
        instancer = self.crowd(stage)
        instancer.GetPrototypesRel().SetTargets(["/crowd/p", "/nothing"])
        instancer.CreatePositionsAttr([(0, 0, 0), (1, 0, 0), (2, 0, 0)])
        instancer.CreateProtoIndicesAttr([0, 1, 0])
        self.assertEqual(self.x_of(self.load(stage), 1), [0, 2])
        self.assertIn("there is no prototype /nothing", self.said()["usd-missing"])

    def test_arrays_that_do_not_fit_for_a_while(self):
        stage = self.stage()
        instancer = self.crowd(stage)
        instancer.CreatePositionsAttr([(0, 0, 0), (1, 0, 0)])
        for code, numbers in ((1, [0, 0]), (3, [0, 0, 0]), (4, [0, 0])):
            instancer.CreateProtoIndicesAttr().Set(numbers, code)
        gltf = self.load(stage)
        self.assertEqual([len(self.shown(gltf, frame)) for frame in (1, 2, 3, 4)], [2, 2, 0, 2])
        self.assertIn("3 protoIndices, which its positions", self.said()["usd-instances"])


class Shutters(MotionCase):
    def test_samples_a_frame_outside_the_range_count(self):
        stage = self.stage()
        stage.SetStartTimeCode(3)
        moves = quad(stage, "/a").AddTranslateOp()
        points = quad(stage, "/b").GetPointsAttr()
        instancer = UsdGeom.PointInstancer.Define(stage, "/crowd")
        quad(stage, "/crowd/p")
        instancer.CreatePrototypesRel().SetTargets(["/crowd/p"])
        instancer.CreateProtoIndicesAttr([0])
        for code in (0, 3, 5, 8):
            # As fast as code squared.
            moves.Set((code**2, 0, 0), code)
            points.Set(np.array(QUAD) + [code**2, 0, 0], code)
            instancer.CreatePositionsAttr().Set([(code**2, 0, 0)], code)
        gltf = self.load(stage)
        self.assertEqual((gltf.settings.first, gltf.settings.last), (3, 5))
        for frame, expected in ((2.5, 9 - 0.5 * 3), (3, 9), (5, 25), (5.5, 25 + 0.5 * 13)):
            seconds = gltf.settings.seconds(np.array([frame]))
            for name in ("a", "crowd.0"):
                self.assertAlmostEqual(self.node(gltf, name).world_from_node(seconds)[0, 0, 3], expected, 4)
            self.assertAlmostEqual(self.bent(gltf, "b", frame)[:, 0].min(), expected, 4)

    def test_no_time_comes_before_zero(self):
        stage = self.stage()
        stage.SetStartTimeCode(0)
        moves = quad(stage, "/a").AddTranslateOp()
        for code in (-4, 0, 5):
            moves.Set((code, 0, 0), code)
        times = self.node(self.load(stage), "a").curves["translation"].times_s
        self.assertEqual(float(times[0]), 0.0)

    def test_visibility_just_after_the_last_frame(self):
        stage = self.stage()
        shown = quad(stage, "/a").CreateVisibilityAttr()
        shown.Set("inherited", 1)
        shown.Set("invisible", 5.5)
        gltf = self.load(stage)
        self.assertEqual([self.is_seen(gltf, "a", frame) for frame in (1, 5, 5.6)], [True, True, False])


class Hostile(MotionCase):
    def test_one_bad_mesh(self):
        gltf = self.case("R_one_bad_mesh")
        self.assertEqual(set(self.said()), {"usd-prim"})
        self.assertIn(
            "/World/Quad: is left out: faceVertexIndices go from 0 to 9, of 4 points", self.said()["usd-prim"]
        )
        self.assertEqual({node.name for node in gltf.nodes}, {"World", "Sun", "Cam"})

    def test_numbers_that_are_none_at_a_time(self):
        """In points, places, instances and visibility; and samples at times that are none."""
        nan = float("nan")
        stage = self.stage()
        quad(stage, "/good")
        bad = quad(stage, "/points").GetPointsAttr()
        bad.Set(QUAD, 1)
        bad.Set([(nan, 0, 0)] * 4, 3)
        place = quad(stage, "/place").AddTranslateOp()
        place.Set((0, 0, 0), 1)
        place.Set((nan, 0, 0), 3)
        crease = quad(stage, "/crease")
        crease.CreateSubdivisionSchemeAttr("catmullClark")
        crease.CreateCreaseIndicesAttr([0, 1])
        crease.CreateCreaseLengthsAttr([2])
        crease.CreateCreaseSharpnessesAttr([nan])
        UsdGeom.Sphere.Define(stage, "/sphere").CreateRadiusAttr(nan)
        instancer = UsdGeom.PointInstancer.Define(stage, "/crowd")
        quad(stage, "/crowd/p")
        instancer.CreatePrototypesRel().SetTargets(["/crowd/p"])
        instancer.CreateProtoIndicesAttr([0])
        instancer.CreatePositionsAttr().Set([(0, 0, 0)], 1)
        instancer.CreatePositionsAttr().Set([(nan, 0, 0)], 3)
        gltf = self.load(stage)
        self.assertTrue({"good", "crease"} <= set(self.shown(gltf, 1)))
        self.assertEqual({loss.kind: loss.count for loss in self.imported.lost}["usd-prim"], 3)

    def test_times_that_are_none(self):
        for time in ("nan", "inf", "-inf", "1e300"):
            path = self.folder / f"time_{time}.usda"
            path.write_text(f"""#usda 1.0
(
    startTimeCode = 1
    endTimeCode = 3
)
def Mesh "a"
{{
    int[] faceVertexCounts.timeSamples = {{ 1: [3], {time}: [3] }}
    int[] faceVertexIndices = [0, 1, 2]
    point3f[] points.timeSamples = {{ 1: [(0,0,0),(1,0,0),(0,1,0)], {time}: [(0,0,0),(1,0,0),(0,2,0)] }}
    double3 xformOp:translate.timeSamples = {{ 1: (0,0,0), {time}: (1,0,0) }}
    token visibility.timeSamples = {{ 1: "inherited", {time}: "invisible" }}
    uniform token[] xformOpOrder = ["xformOp:translate"]
}}
""")
            self.read_or_refuse(path)

    def read_or_refuse(self, path: Path) -> None:
        """Nothing but a `SceneError` comes of a file."""
        try:
            import_usd(path, self.folder / "out.glb")
        except SceneError:
            pass

    def test_a_temperature_that_is_none(self):
        self.case("T_temp_nan")
        self.assertTrue(self.imported.lost)

    def test_attributes_of_other_types(self):
        for name, kind, value in (("points", "String", "text"), ("faceVertexCounts", "FloatArray", Vt.FloatArray([1.5])),
                                  ("visibility", "Int", 3), ("purpose", "Double", 1.0), ("subdivisionScheme", "Bool", True),
                                  ("creaseIndices", "TokenArray", Vt.TokenArray(["a"])), ("orientation", "Float", 1.0)):  # fmt: skip
            stage = self.stage()
            quad(stage, "/good")
            spec = Sdf.CreatePrimInLayer(stage.GetRootLayer(), "/bad")
            spec.specifier, spec.typeName = Sdf.SpecifierDef, "Mesh"
            Sdf.AttributeSpec(spec, name, getattr(Sdf.ValueTypeNames, kind)).default = value
            self.assertIn("good", self.shown(self.load(stage), 1), name)


if __name__ == "__main__":
    unittest.main()
