"""`import-usd`: what stands where, and whether it is seen: instances, visibility, purposes, solids,
subdivision surfaces."""

import unittest
from types import SimpleNamespace
from unittest import mock

import numpy as np
from pxr import Gf, Sdf, Tf, Usd, UsdGeom, UsdShade, Vt

from sunfleck_tools.errors import SceneError
from sunfleck_tools.gltf.container import Container
from sunfleck_tools.gltf.meshes import Meshes
from sunfleck_tools.gltf.nodes import Node
from sunfleck_tools.gltf.scene import Gltf
from sunfleck_tools.usd import ImportOptions, import_usd
from sunfleck_tools.usd.reading import census as census_module
from sunfleck_tools.usd.reading import convert, crowds
from sunfleck_tools.usd.reading.cages import MOST_OF_ONE
from sunfleck_tools.usd.reading.census import Census
from sunfleck_tools.usd.reading.losses import TooMuch
from sunfleck_tools.usd.reading.solids import SOLIDS

from .test_usd_export import inspect, needs_program
from .test_usd_import import quad
from .test_usd_lights import LookCase

RED, BLUE = (1, 0, 0), (0, 0, 1)


class SceneCase(LookCase):
    """Reads what was written."""

    def node(self, gltf: Gltf, name: str) -> Node:
        return next(node for node in gltf.nodes if node.name == name)

    def points(self, gltf: Gltf, name: str, frame: float = 1.0) -> np.ndarray:
        """Where the corners of a still node's mesh are in the world."""
        node = self.node(gltf, name)
        world = node.world_from_node(gltf.settings.seconds(np.array([frame])))[0]
        _, mesh = Meshes(gltf, []).of(node)
        return np.concatenate([each.positions for each in mesh.primitives]) @ world[:3, :3].T + world[:3, 3]

    def color(self, gltf: Gltf, name: str) -> list[float]:
        """Of the first material of a node's mesh."""
        _, mesh = Meshes(gltf, []).of(self.node(gltf, name))
        return gltf.document.raw["materials"][mesh.primitives[0].material]["pbrMetallicRoughness"]["baseColorFactor"][:3]

    def is_seen(self, gltf: Gltf, name: str, frame: float = 1.0) -> bool:
        """Whether a node and all above it are shown at a frame."""
        node, seconds = self.node(gltf, name), gltf.settings.seconds(np.array([frame]))
        while node is not None:
            still = (
                (node.source.raw.get("extensions") or {}).get("KHR_node_visibility", {}).get("visible", True)
            )
            control = gltf.controls.get(f"{node.name}.sunfleck_node.visible")
            if not (control.at(seconds)[0, 0] >= 0.5 if control else still):
                return False
            node = node.parent
        return True

    def material(self, stage: Usd.Stage, path: str, color: tuple) -> UsdShade.Material:
        material, shader = (
            UsdShade.Material.Define(stage, path),
            UsdShade.Shader.Define(stage, f"{path}/surface"),
        )
        shader.CreateIdAttr("UsdPreviewSurface")
        shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(color)
        material.CreateSurfaceOutput().ConnectToSource(
            shader.CreateOutput("surface", Sdf.ValueTypeNames.Token)
        )
        return material

    def bind(self, prim: Usd.Prim, material: UsdShade.Material) -> None:
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(material)


class Instances(SceneCase):
    def test_each_has_its_own_material(self):
        gltf = self.case("P_instances_two_materials")
        self.assertEqual([self.color(gltf, name) for name in ("Left", "Right")], [list(RED), list(BLUE)])
        # What is the same is stored once: points and triangles.
        self.assertEqual(
            len({str(mesh["primitives"][0]["attributes"]) for mesh in gltf.document.raw["meshes"]}), 1
        )
        self.assertEqual(self.imported.lost, [])

    def test_those_that_look_alike_are_one_mesh(self):
        stage = self.stage()
        stage.CreateClassPrim("/_leaf")
        quad(stage, "/_leaf/mesh")
        red, blue = self.material(stage, "/red", RED), self.material(stage, "/blue", BLUE)
        for index, material in enumerate((red, blue, red, blue)):
            prim = UsdGeom.Xform.Define(stage, f"/leaf{index}").GetPrim()
            prim.GetInherits().AddInherit("/_leaf")
            prim.SetInstanceable(True)
            self.bind(prim, material)
        gltf = self.load(stage)
        self.assertEqual(len(gltf.document.raw["meshes"]), 2)
        self.assertEqual(
            [self.color(gltf, f"leaf{index}") for index in range(4)], [list(RED), list(BLUE)] * 2
        )

    def test_subsets_and_colours_of_instances(self):
        stage = self.stage()
        stage.CreateClassPrim("/_leaf")
        quad(stage, "/_leaf/mesh")
        for index, color in enumerate((RED, BLUE)):
            prim = UsdGeom.Xform.Define(stage, f"/leaf{index}").GetPrim()
            prim.GetInherits().AddInherit("/_leaf")
            prim.SetInstanceable(True)
            UsdGeom.PrimvarsAPI(prim).CreatePrimvar(
                "displayColor", Sdf.ValueTypeNames.Color3fArray, "constant"
            ).Set([color])
        gltf = self.load(stage)
        for index, color in enumerate((RED, BLUE)):
            _, mesh = Meshes(gltf, []).of(self.node(gltf, f"leaf{index}"))
            np.testing.assert_allclose(mesh.primitives[0].colors[:, :3], [color] * 4)

    def test_prototypes_below_an_over_or_a_class(self):
        for specifier in (Sdf.SpecifierOver, Sdf.SpecifierClass):
            stage = self.stage()
            instancer = UsdGeom.PointInstancer.Define(stage, "/crowd")
            quad(stage, "/hidden/leaf/mesh")
            stage.GetPrimAtPath("/hidden").SetSpecifier(specifier)
            instancer.CreatePrototypesRel().SetTargets(["/hidden/leaf"])
            instancer.CreateProtoIndicesAttr([0, 0])
            instancer.CreatePositionsAttr([(0, 0, 0), (3, 0, 0)])
            gltf = self.load(stage)
            shown = [node for node in gltf.nodes if node.source.member("mesh") is not None]
            self.assertEqual(len(shown), 2, specifier)


class Crowds(SceneCase):
    """Instancers in instancers."""

    def nested(self, *numbers: int) -> Usd.Stage:
        """Instancers each in the one before, of so many instances a unit apart; the last
        of them of a quad."""
        stage, path = self.stage(), ""
        for level, number in enumerate(numbers):
            path += f"/crowd{level}"
            prototype = f"{path}/crowd{level + 1}" if level + 1 < len(numbers) else f"{path}/leaf"
            instancer = UsdGeom.PointInstancer.Define(stage, path)
            instancer.CreatePrototypesRel().SetTargets([prototype])
            instancer.CreateProtoIndicesAttr(Vt.IntArray([0] * number))
            instancer.CreatePositionsAttr([(10.0**level * index, 0, 0) for index in range(number)])
        quad(stage, f"{path}/leaf")
        return stage

    def test_each_instance_is_there(self):
        gltf = self.load(self.nested(2, 3))
        shown = [node for node in gltf.nodes if node.source.member("mesh") is not None]
        places = [node.world_from_node(np.zeros(1))[0][0, 3] for node in shown]
        self.assertEqual(sorted(places), [0, 1, 10, 11, 20, 21])

    def test_more_than_a_file_holds_are_refused_before_any_is_made(self):
        path = self.folder / "many.usda"
        stage = self.nested(100, 100, 101)
        stage.GetRootLayer().Export(str(path))
        with mock.patch.object(convert, "read_crowd") as made, self.assertRaises(SceneError) as caught:
            import_usd(path, self.folder / "many.glb")
        made.assert_not_called()
        self.assertIn("/crowd0: with it there are 1020100 instances", str(caught.exception))
        self.assertIn("--mask", str(caught.exception))

    def test_are_counted_when_most_are_there(self):
        stage = self.nested(2, 2)
        indices = UsdGeom.PointInstancer.Get(stage, "/crowd0").GetProtoIndicesAttr()
        indices.Set([0] * 5, 3)
        census = Census(SimpleNamespace(first=1.0))
        with mock.patch.object(census_module, "MOST_INSTANCES", 15):
            census.add(stage.GetPrimAtPath("/crowd0"))
            with self.assertRaisesRegex(TooMuch, "17 instances"):
                census.add(stage.GetPrimAtPath("/crowd0/crowd1"))

    def test_many_places_over_time_are_refused(self):
        stage = self.nested(2)
        positions = UsdGeom.PointInstancer.Get(stage, "/crowd0").GetPositionsAttr()
        for code in (1, 5):
            positions.Set([(code, 0, 0)] * 2, code)
        with (
            mock.patch.object(crowds, "MOST_MOMENTS", 9),
            self.assertRaisesRegex(SceneError, "/crowd0: 2 instances .* --frames"),
        ):
            self.load(stage)


class Units(SceneCase):
    def test_a_unit_in_single_precision(self):
        """Binary files of some exporters have it so; text files cannot."""
        path = self.folder / "single.usdc"
        stage = self.stage()
        quad(stage, "/a")
        UsdGeom.SetStageMetersPerUnit(stage, 0.5)
        stage.GetRootLayer().Export(str(path))
        with mock.patch.object(
            UsdGeom,
            "GetStageMetersPerUnit",
            side_effect=Tf.ErrorException("does not match retrieved type float"),
        ):
            import_usd(path, self.folder / "single.glb")
        np.testing.assert_allclose(
            Container(self.folder / "single.glb").document.raw["nodes"][0]["scale"], [0.5] * 3
        )


class Visibility(SceneCase):
    def compare(self, stage: Usd.Stage, names: list[str], frames: list[float]) -> Gltf:
        """Every node is as seen as its prim is by USD's own rules."""
        gltf = self.load(stage)
        for frame in frames:
            for name in names:
                prim = next(each for each in stage.Traverse() if each.GetName() == name)
                expected = UsdGeom.Imageable(prim).ComputeVisibility(frame) != UsdGeom.Tokens.invisible
                self.assertEqual(self.is_seen(gltf, name, frame), expected, f"{name} at frame {frame}")
        return gltf

    def test_of_scopes(self):
        stage = self.stage()
        UsdGeom.Scope.Define(stage, "/hidden").CreateVisibilityAttr("invisible")
        blinking = UsdGeom.Scope.Define(stage, "/blinking").CreateVisibilityAttr()
        for code, value in ((1, "inherited"), (2, "invisible"), (4, "inherited")):
            blinking.Set(value, code)
        for name in ("hidden/a", "blinking/b", "c"):
            quad(stage, f"/{name}")
        quad(stage, "/hidden/d").CreateVisibilityAttr("inherited")
        gltf = self.compare(stage, list("abcd"), [1, 2, 3, 4, 5])
        self.assertEqual(
            [self.is_seen(gltf, "b", frame) for frame in (1, 2, 3.5, 4)], [True, False, False, True]
        )
        self.assertFalse(self.is_seen(gltf, "d"))

    def test_of_what_resets_its_place(self):
        """`!resetXformStack!` leaves the parents' places, and not their visibility."""
        stage = self.stage()
        parent = UsdGeom.Xform.Define(stage, "/parent")
        parent.AddTranslateOp().Set((5, 0, 0))
        shown = parent.CreateVisibilityAttr()
        shown.Set("invisible", 1)
        shown.Set("inherited", 3)
        for name in ("here", "there"):
            child = quad(stage, f"/parent/{name}")
            child.AddTranslateOp().Set((0, 2, 0))
        UsdGeom.Xformable(child).SetResetXformStack(True)
        gltf = self.compare(stage, ["here", "there"], [1, 2, 3, 5])
        np.testing.assert_allclose(self.points(gltf, "here").min(axis=0), [5, 2, 0])
        np.testing.assert_allclose(self.points(gltf, "there").min(axis=0), [0, 2, 0])

    def test_what_resets_its_place_stands_in_the_stages_axes(self):
        stage = self.stage()
        UsdGeom.SetStageUpAxis(stage, "Z")
        UsdGeom.SetStageMetersPerUnit(stage, 0.5)
        # A name that the node of the axes has too.
        UsdGeom.Xform.Define(stage, "/stage").AddTranslateOp().Set((7, 7, 7))
        child = quad(stage, "/stage/child")
        child.AddTranslateOp().Set((0, 0, 2))
        UsdGeom.Xformable(child).SetResetXformStack(True)
        np.testing.assert_allclose(
            self.points(self.load(stage), "child").min(axis=0), [0, 1, -0.5], atol=1e-6
        )

    def test_of_a_prototype(self):
        stage = self.stage()
        instancer = UsdGeom.PointInstancer.Define(stage, "/crowd")
        quad(stage, "/crowd/seen")
        quad(stage, "/crowd/unseen").CreateVisibilityAttr("invisible")
        instancer.CreatePrototypesRel().SetTargets(["/crowd/seen", "/crowd/unseen"])
        instancer.CreateProtoIndicesAttr([0, 1])
        instancer.CreatePositionsAttr([(0, 0, 0), (1, 0, 0)])
        gltf = self.load(stage)
        names = [node.name for node in gltf.nodes if node.source.member("mesh") is not None]
        self.assertEqual([self.is_seen(gltf, name) for name in names], [True, False])

    @needs_program
    def test_the_renderer_agrees(self):
        stage = self.stage()
        shown = UsdGeom.Scope.Define(stage, "/scope").CreateVisibilityAttr()
        shown.Set("invisible", 1)
        shown.Set("inherited", 3)
        quad(stage, "/scope/leaf")
        self.load(stage)
        found = inspect(self.folder / "made.glb", [1, 2, 3])
        self.assertEqual(
            [found[frame]["nodes"]["leaf"]["visible"] for frame in (1, 2, 3)], [False, False, True]
        )


class Purposes(SceneCase):
    def shown(self, *purposes: str) -> set[str]:
        stage = self.stage()
        parent = UsdGeom.Xform.Define(stage, "/parent")
        parent.CreatePurposeAttr("proxy")
        for name, purpose in (
            ("parent/inherits", None),
            ("parent/own", "default"),
            ("a", None),
            ("b", "render"),
            ("c", "guide"),
        ):
            mesh = quad(stage, f"/{name}")
            mesh.AddTranslateOp().Set((1, 0, 0))
            if purpose:
                mesh.CreatePurposeAttr(purpose)
        stage.GetRootLayer().Save()
        target = self.folder / "purposes.glb"
        self.imported = import_usd(stage.GetRootLayer().realPath, target, ImportOptions(purposes=purposes))
        return {node.name for node in Gltf(Container(target)).nodes if node.source.member("mesh") is not None}

    def test_default_and_render(self):
        self.assertEqual(self.shown("render"), {"own", "a", "b"})
        self.assertEqual([(loss.kind, loss.count) for loss in self.imported.lost], [("usd-purpose", 2)])
        self.assertEqual(self.shown("proxy"), {"own", "a", "inherits"})
        self.assertEqual(self.shown("render", "proxy", "guide"), {"own", "a", "b", "c", "inherits"})
        self.assertEqual(self.imported.lost, [])

    def test_the_guide_in_a_box_of_fog_of_ours_is_no_loss_in_any_stage(self):
        stage = self.stage()
        fog = UsdGeom.Xform.Define(stage, "/haze").GetPrim()
        fog.CreateAttribute("userProperties:sunfleck_fog_volume:density", Sdf.ValueTypeNames.Double).Set(0.1)
        quad(stage, "/haze/haze_bounds").CreatePurposeAttr("guide")
        quad(stage, "/leaf")
        stage.GetRootLayer().Save()
        self.assertEqual(import_usd(stage.GetRootLayer().realPath, self.folder / "fog.glb").lost, [])

    def test_the_case(self):
        gltf = self.case("M_purpose")
        self.assertEqual(len(gltf.document.raw["meshes"]), 1)
        self.assertIn("/World/Proxy: is of purpose `proxy`", self.said()["usd-purpose"])


class Solids(SceneCase):
    def test_have_their_size_and_face_outwards(self):
        # Volumes of the sizes that the schemas have by default, and for planes nothing.
        volumes = {"Cube": 8, "Sphere": 4 / 3 * np.pi, "Cylinder": 2 * np.pi, "Cylinder_1": 2 * np.pi, "Cone": 2 / 3 * np.pi, "Plane": 0,
                   "Capsule": np.pi * (0.25 + 1 / 6), "Capsule_1": np.pi * (0.25 + 1 / 6)}  # fmt: skip
        self.assertEqual(volumes.keys(), set(SOLIDS))
        for kind, volume in volumes.items():
            for axis in "XYZ" if kind not in ("Cube", "Sphere") else "X":
                stage = self.stage()
                prim = stage.DefinePrim("/a", kind)
                if prim.GetAttribute("axis"):
                    prim.GetAttribute("axis").Set(axis)
                gltf = self.load(stage)
                _, mesh = Meshes(gltf, []).of(gltf.nodes[0])
                primitive = mesh.primitives[0]
                a, b, c = (
                    primitive.positions[primitive.triangles[:, corner]].astype(float) for corner in range(3)
                )
                self.assertLessEqual(abs((a * np.cross(b, c)).sum() / 6 - volume), 0.012 * volume, kind)
                facing = np.einsum(
                    "fi,fi->f", np.cross(b - a, c - a), primitive.normals[primitive.triangles[:, 0]]
                )
                self.assertGreater(facing.min(), 0, kind)
                if kind != "Plane":
                    extent = np.array(
                        UsdGeom.Boundable.ComputeExtentFromPlugins(UsdGeom.Boundable(prim), Usd.TimeCode(1))
                    )
                    np.testing.assert_allclose(
                        [primitive.positions.min(axis=0), primitive.positions.max(axis=0)], extent, atol=3e-3
                    )

    def test_a_plane_lies_as_the_schema_says(self):
        for axis, size in (("X", [0, 3, 2]), ("Y", [2, 0, 3]), ("Z", [2, 3, 0])):
            stage = self.stage()
            plane = UsdGeom.Plane.Define(stage, "/a")
            plane.CreateWidthAttr(2.0)
            plane.CreateLengthAttr(3.0)
            plane.CreateAxisAttr(axis)
            gltf = self.load(stage)
            np.testing.assert_allclose(np.ptp(self.points(gltf, "a"), axis=0), size, atol=1e-6)
            _, mesh = Meshes(gltf, []).of(gltf.nodes[0])
            np.testing.assert_allclose(
                mesh.primitives[0].normals, np.tile(np.eye(3)["XYZ".index(axis)], (4, 1))
            )

    def test_curves_and_points_are_said(self):
        stage = self.stage()
        quad(stage, "/a")
        UsdGeom.BasisCurves.Define(stage, "/curves")
        UsdGeom.Points.Define(stage, "/points")
        self.load(stage)
        self.assertEqual([(loss.kind, loss.count) for loss in self.imported.lost], [("usd-shape", 2)])

    def test_words_that_change_a_picture_are_said(self):
        stage = self.stage()
        UsdGeom.Xform.Define(stage, "/a")
        # Of a mesh that is one node with what it is in, too.
        UsdGeom.MotionAPI.Apply(quad(stage, "/a/quad").GetPrim()).CreateMotionBlurScaleAttr(2.0)
        model = UsdGeom.ModelAPI.Apply(stage.GetPrimAtPath("/a"))
        for mode, kinds in (("default", {"usd-motion": 1}), ("cards", {"usd-motion": 1, "usd-shape": 1})):
            model.CreateModelDrawModeAttr(mode)
            self.load(stage)
            self.assertEqual({loss.kind: loss.count for loss in self.imported.lost}, kinds)


class Subdivision(SceneCase):
    def cube(self, stage: Usd.Stage, path: str = "/cube") -> UsdGeom.Mesh:
        mesh = UsdGeom.Mesh.Define(stage, path)
        mesh.CreatePointsAttr([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        mesh.CreateFaceVertexCountsAttr([4] * 6)
        mesh.CreateFaceVertexIndicesAttr(
            [0, 1, 3, 2, 4, 6, 7, 5, 0, 4, 5, 1, 2, 3, 7, 6, 0, 2, 6, 4, 1, 5, 7, 3]
        )
        return mesh

    def primitive(self, gltf: Gltf):
        return (
            Meshes(gltf, [])
            .of(next(node for node in gltf.nodes if node.source.member("mesh") is not None))[1]
            .primitives[0]
        )

    def test_what_says_nothing_is_one(self):
        """USD's scheme is catmullClark unless another is said; a square's edges stay, by `edgeAndCorner`."""
        gltf = self.case("D_subdiv_unauthored")
        found = self.primitive(gltf)
        self.assertEqual(len(found.triangles), 32)
        np.testing.assert_allclose(
            [found.positions.min(axis=0), found.positions.max(axis=0)], [[-1, -1, 0], [1, 1, 0]]
        )
        np.testing.assert_allclose(found.normals, np.tile([0, 0, 1], (25, 1)))
        # Coordinates of points go the way of the points: u = (x + 1) / 2, v from the top.
        expected = 0.5 * (found.positions[:, :2] * [1, -1] + 1)
        np.testing.assert_allclose(found.uvs[0], expected, atol=1e-6)
        self.assertEqual(self.imported.lost, [])

    def test_a_cube_becomes_round(self):
        stage = self.stage()
        self.cube(stage)
        found = self.primitive(self.load(stage))
        self.assertEqual((len(found.positions), len(found.triangles)), (98, 192))
        radii = np.linalg.norm(found.positions, axis=1)
        # Between the limits of the middles of its faces and of its corners.
        self.assertTrue((radii > 0.83).all() and (radii < 1.1).all())
        outwards = np.einsum("vi,vi->v", found.normals, found.positions) / radii
        self.assertGreater(outwards.min(), 0.97)

    def test_schemes(self):
        for scheme, triangles, size in (
            ("none", 12, 1.0),
            ("bilinear", 192, 1.0),
            ("catmullClark", 192, None),
        ):
            stage = self.stage()
            self.cube(stage).CreateSubdivisionSchemeAttr(scheme)
            found = self.primitive(self.load(stage))
            self.assertEqual(len(found.triangles), triangles)
            if size is not None:
                np.testing.assert_allclose(np.abs(found.positions).max(axis=1), size)
        stage = self.stage()
        self.cube(stage).CreateSubdivisionSchemeAttr("loop")
        quad(stage, "/b")
        self.load(stage)
        self.assertIn("one of triangles", self.said()["usd-prim"])

    def test_creases(self):
        stage = self.stage()
        mesh = self.cube(stage)
        mesh.CreateCreaseIndicesAttr([1, 3, 7, 5, 1])
        mesh.CreateCreaseLengthsAttr([5])
        mesh.CreateCreaseSharpnessesAttr([10.0])
        mesh.CreateCornerIndicesAttr([0])
        mesh.CreateCornerSharpnessesAttr([10.0])
        found = self.primitive(self.load(stage))
        # The ring stays in its plane, and the corner in its place.
        self.assertEqual(int((found.positions[:, 2] == 1.0).sum()), 2 * 16 + 9)
        self.assertTrue((found.positions == [-1, -1, -1]).all(axis=1).any())

    def test_holes_and_subsets_are_those_of_the_cage(self):
        stage = self.stage()
        mesh = self.cube(stage)
        mesh.CreateHoleIndicesAttr([0])
        red = self.material(stage, "/red", RED)
        subset = UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).CreateMaterialBindSubset(
            "one", Vt.IntArray([1, 2])
        )
        self.bind(subset.GetPrim(), red)
        _, found = Meshes(gltf := self.load(stage), []).of(self.node(gltf, "cube"))
        self.assertEqual(sorted(len(each.triangles) for each in found.primitives), [2 * 32, 3 * 32])

    def test_coordinates_of_corners(self):
        """One square a face: by all rules for seams but `none` its corners stay, and always the middle of a
        face is that of its square."""
        for rule in ("none", "cornersOnly", "cornersPlus1", "cornersPlus2", "boundaries", "all"):
            stage = self.stage()
            mesh = self.cube(stage)
            mesh.CreateFaceVaryingLinearInterpolationAttr(rule)
            primvar = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
                "st", Sdf.ValueTypeNames.TexCoord2dArray, "faceVarying"
            )
            squares = np.array([(0, 0), (1, 0), (1, 1), (0, 1)]) + np.repeat(np.arange(6), 4).reshape(
                6, 4, 1
            ) * [2, 0]
            primvar.Set(Vt.Vec2dArray.FromNumpy(squares.reshape(-1, 2).astype(float)))
            found = self.primitive(self.load(stage))
            corners = {(u, v) for u, v in np.round(found.uvs[0], 6).tolist()}
            self.assertEqual((0.0, 0.0) in corners, rule != "none", rule)
            self.assertIn((0.5, 0.5), corners)

    def test_coordinates_are_read_in_every_precision(self):
        for kind in (
            "TexCoord2fArray",
            "TexCoord2dArray",
            "TexCoord2hArray",
            "Float2Array",
            "Double2Array",
            "Half2Array",
            "TexCoord3fArray",
        ):
            stage = self.stage()
            mesh = quad(stage, "/a")
            primvar = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
                "st", getattr(Sdf.ValueTypeNames, kind), "vertex"
            )
            values = [(0, 0), (0.5, 0), (0.5, 0.25), (0, 0.25)]
            primvar.Set([Gf.Vec3f(*each, 9) if "3" in kind else each for each in values])
            found = self.primitive(self.load(stage))
            self.assertEqual(
                {tuple(uv) for uv in found.uvs[0].tolist()}, {(u, 1 - v) for u, v in values}, kind
            )

    def test_values_that_do_not_fit_are_said(self):
        stage = self.stage()
        UsdGeom.PrimvarsAPI(quad(stage, "/a")).CreatePrimvar(
            "st", Sdf.ValueTypeNames.TexCoord2fArray, "vertex"
        ).Set([(0, 0)] * 3)
        self.assertEqual(self.primitive(self.load(stage)).uvs, {})
        self.assertIn("3 values of interpolation `vertex`", self.said()["usd-primvar"])

    def test_too_many_faces_are_refined_less(self):
        stage = self.stage()
        size = int((MOST_OF_ONE // 4) ** 0.5) - 100
        at = np.arange((size + 1) ** 2).reshape(size + 1, size + 1)
        corners = np.stack([at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]], axis=-1).ravel()
        mesh = UsdGeom.Mesh.Define(stage, "/a")
        mesh.CreateFaceVertexCountsAttr(Vt.IntArray(size * size, 4))
        mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(corners.astype(np.int32)))
        # Without points nothing is drawn; how many faces there are counts.
        self.cube(stage, "/b")
        found = Meshes(gltf := self.load(stage), []).of(self.node(gltf, "b"))[1].primitives[0]
        self.assertEqual(len(found.triangles), 48)
        self.assertIn("is refined once", self.said()["usd-subdivision"])


if __name__ == "__main__":
    unittest.main()

    def test_caps_of_differing_radii_are_tangent(self):
        stage = self.stage()
        prim = UsdGeom.Capsule_1.Define(stage, "/a")
        for attribute, value in (("RadiusTop", 0.5), ("RadiusBottom", 2.0), ("Height", 3.0)):
            getattr(prim, f"Create{attribute}Attr")(value)
        gltf = self.load(stage)
        _, mesh = Meshes(gltf, []).of(gltf.nodes[0])
        extent = np.array(UsdGeom.Boundable.ComputeExtentFromPlugins(UsdGeom.Boundable(prim.GetPrim()), Usd.TimeCode(1)))
        heights = mesh.primitives[0].positions[:, 2]
        np.testing.assert_allclose([heights.min(), heights.max()], extent[:, 2], atol=3e-3)
