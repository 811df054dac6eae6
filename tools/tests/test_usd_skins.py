"""`import-usd`: skeletons of UsdSkel. They are skins of glTF where those say the same, and points that bend
where they do not."""

import unittest

import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdSkel, Vt

from sunfleck_tools.gltf.scene import Gltf

from .test_usd_import import QUAD, quad
from .test_usd_motion import MotionCase

JOINTS = ["upper", "upper/lower"]
FRAMES = (1.0, 2.0, 3.0, 5.0)


def shift(x: float, y: float, z: float) -> Gf.Matrix4d:
    return Gf.Matrix4d().SetTranslate((x, y, z))


class Skins(MotionCase):
    """A square on an arm of two joints; arm and square stand in places of their own, and
    were bound in others."""

    def armed(self) -> Usd.Stage:
        stage = self.stage()
        root = UsdSkel.Root.Define(stage, "/root")
        root.AddTranslateOp().Set((0, 0, 3))
        skeleton = UsdSkel.Skeleton.Define(stage, "/root/bones")
        skeleton.AddRotateYOp().Set(30)
        skeleton.CreateJointsAttr(JOINTS)
        skeleton.CreateBindTransformsAttr(Vt.Matrix4dArray([shift(0, 1, 0), shift(0.5, 1, 0)]))
        skeleton.CreateRestTransformsAttr(Vt.Matrix4dArray([shift(0, 1, 0), shift(0.5, 0, 0)]))
        animation = UsdSkel.Animation.Define(stage, "/root/bones/motion")
        animation.CreateJointsAttr(JOINTS)
        animation.CreateTranslationsAttr([Gf.Vec3f(0, 1, 0), Gf.Vec3f(0.5, 0, 0)])
        animation.CreateScalesAttr([Gf.Vec3h(1), Gf.Vec3h(1)])
        turns = animation.CreateRotationsAttr()
        for code in range(1, 6):
            turns.Set(
                [
                    Gf.Quatf(Gf.Rotation(axis, by * code).GetQuat())
                    for axis, by in (((0, 0, 1), 10), ((0, 1, 0), 20))
                ],
                code,
            )
        UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().SetTargets(
            [animation.GetPath()]
        )
        self.tie(stage, "/root/leaf", [0, 0, 1, 0, 1, 0, 0, 1], [1, 0, 0.75, 0.25, 1, 0, 0.5, 0.5])
        return stage

    def tie(self, stage: Usd.Stage, path: str, joints: list[int], weights: list[float]) -> UsdSkel.BindingAPI:
        """A square, by two joints a point."""
        mesh = quad(stage, path)
        mesh.AddTranslateOp().Set((7, 8, 9))
        binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
        binding.CreateSkeletonRel().SetTargets(["/root/bones"])
        binding.CreateJointIndicesPrimvar(False, 2).Set(joints)
        binding.CreateJointWeightsPrimvar(False, 2).Set(weights)
        binding.CreateGeomBindTransformAttr(shift(0, 0.25, 0.5))
        return binding

    def by_usd(self, stage: Usd.Stage, path: str, frame: float) -> np.ndarray:
        """Where USD has the points in the world, sorted."""
        baked = Usd.Stage.Open(stage.Flatten())
        UsdSkel.BakeSkinning(UsdSkel.Root.Get(baked, "/root"), Gf.Interval(1, 5))
        mesh = UsdGeom.Mesh.Get(baked, path)
        world = np.array(mesh.ComputeLocalToWorldTransform(frame))
        points = np.array(mesh.GetPointsAttr().Get(frame)) @ world[:3, :3] + world[3, :3]
        return points[np.lexsort(np.round(points, 5).T)]

    def skinned(self, gltf: Gltf, frame: float) -> np.ndarray:
        """Vertices of the one mesh on joints: those are in the world, whatever its node's place."""
        node = next(each for each in gltf.nodes if each.source.member("skin") is not None)
        points = self.bent(gltf, node.name, frame)
        world = node.world_from_node(gltf.settings.seconds(np.array([frame])))[0]
        points = (points - world[:3, 3]) @ np.linalg.inv(world[:3, :3]).T
        return points[np.lexsort(np.round(points, 5).T)]

    def assert_follows(self, stage: Usd.Stage, gltf: Gltf) -> None:
        for frame in FRAMES:
            np.testing.assert_allclose(
                self.skinned(gltf, frame), self.by_usd(stage, "/root/leaf", frame), atol=2e-5
            )

    def test_joints_stay_joints(self):
        stage = self.armed()
        gltf = self.load(stage)
        self.assertEqual(len(gltf.document.raw["skins"]), 1)
        self.assertNotIn("targets", gltf.document.raw["meshes"][0]["primitives"][0])
        self.assertEqual(self.imported.lost, [])
        self.assert_follows(stage, gltf)

    def test_a_mesh_may_number_the_joints_in_its_own_way(self):
        stage = self.armed()
        binding = UsdSkel.BindingAPI(stage.GetPrimAtPath("/root/leaf"))
        binding.CreateJointsAttr(JOINTS[::-1])
        gltf = self.load(stage)
        self.assert_follows(stage, gltf)

    def test_more_than_four_joints_a_point(self):
        stage = self.armed()
        binding = UsdSkel.BindingAPI(stage.GetPrimAtPath("/root/leaf"))
        binding.CreateJointIndicesPrimvar(False, 5).Set([0, 1, 0, 1, 1] * 4)
        binding.CreateJointWeightsPrimvar(False, 5).Set([0.2] * 20)
        primitive = self.load(stage).document.raw["meshes"][0]["primitives"][0]
        self.assertIn("JOINTS_1", primitive["attributes"])

    def test_several_on_one_skeleton(self):
        stage = self.armed()
        self.tie(stage, "/root/other", [0, 1] * 4, [0.5] * 8)
        document = self.load(stage).document.raw
        self.assertEqual([node.get("skin") for node in document["nodes"] if "mesh" in node], [0, 0])

    def test_what_skins_cannot_say_bends(self):
        """Cages that bend before they are refined, blends of dual quaternions, weights that
        are not 1 together."""
        for name in ("refined", "quaternions", "heavy", "instancer"):
            with self.subTest(name):
                stage = self.armed()
                mesh = UsdGeom.Mesh.Get(stage, "/root/leaf")
                if name == "refined":
                    mesh.CreateSubdivisionSchemeAttr("catmullClark")
                elif name == "quaternions":
                    UsdSkel.BindingAPI(mesh).CreateSkinningMethodAttr("dualQuaternion")
                elif name == "heavy":
                    UsdSkel.BindingAPI(mesh).GetJointWeightsPrimvar().Set([0.75] * 8)
                else:
                    UsdGeom.PointInstancer.Define(stage, "/crowd")
                gltf = self.load(stage)
                self.assertNotIn("skins", gltf.document.raw)
                self.assertIn("targets", gltf.document.raw["meshes"][0]["primitives"][0])
                if name != "refined":
                    np.testing.assert_allclose(
                        self.bent(gltf, "leaf", 3), self.by_usd(stage, "/root/leaf", 3), atol=1e-5
                    )

    def test_a_square_that_joints_leave_alone_is_where_it_was_bound(self):
        stage = self.armed()
        stage.GetPrimAtPath("/root/bones").RemoveProperty("skel:animationSource")
        turn = Gf.Matrix4d().SetRotate(Gf.Rotation((0, 1, 0), 30)) * shift(0, 0, 3)
        expected = np.array([turn.Transform(Gf.Vec3d(*point) + Gf.Vec3d(0, 0.25, 0.5)) for point in QUAD])
        found = self.skinned(self.load(stage), 1)
        np.testing.assert_allclose(found, expected[np.lexsort(np.round(expected, 5).T)], atol=1e-5)


if __name__ == "__main__":
    unittest.main()
