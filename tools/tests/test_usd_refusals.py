"""Stages that nobody should write: `import-usd` says what is wrong with them, and where."""

import unittest

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade, Vt

from sunfleck_tools import SceneError
from sunfleck_tools.usd import export_usd, import_usd

from .test_usd_export import SAMPLES
from .test_usd_import import ImportCase, quad
from .test_validation import run


class Refusals(ImportCase):
    def test_what_does_not_hold_together(self):
        for text, said in (
            ('def Xform "b" (references = </b/c>)\n{\n    def Xform "c" (references = </b>)\n    {\n    '
             '}\n}\n', "Cycle"),
            ('def Xform "a" (sublayers = 3)\n', "is no stage"),
        ):
            path = self.folder / "bad.usda"
            path.write_text("#usda 1.0\n" + text)
            code, _, err = run("import-usd", path, self.folder / "out.glb")
            self.assertEqual(code, 3)
            self.assertIn(said, err)
            self.assertNotIn("Traceback", err)
            layer = Sdf.Layer.Find(str(path))
            del layer
        # As `sunfleck render` of a file that is not there.
        self.assertEqual(run("import-usd", self.folder / "none.usd", self.folder / "out.glb")[0], 4)
        self.assertEqual(run("import-usd", SAMPLES / "README.md", self.folder / "out.glb")[0], 3)

    def test_indices_that_point_nowhere(self):
        stage = self.stage()
        quad(stage, "/a").GetFaceVertexIndicesAttr().Set([0, 1, 2, 9])
        self.left_out(stage, "/a: is left out: faceVertexIndices go from 0 to 9, of 4 points")
        stage = self.stage()
        quad(stage, "/a").GetFaceVertexCountsAttr().Set([400])
        self.left_out(stage, "/a: is left out: faceVertexCounts ask for 400 corners")
        stage = self.stage()
        instancer = UsdGeom.PointInstancer.Define(stage, "/crowd")
        quad(stage, "/crowd/leaf")
        instancer.CreatePrototypesRel().SetTargets(["/crowd/leaf"])
        instancer.CreateProtoIndicesAttr([0, 5])
        instancer.CreatePositionsAttr([(0, 0, 0)] * 2)
        self.left_out(stage, "/crowd: is left out: protoIndices go from 0 to 5, of 1 prototypes")
        instancer.GetProtoIndicesAttr().Set([0, 0, 0])
        self.left_out(stage, "3 protoIndices")
        instancer.GetPrototypesRel().SetTargets(["/nothing"])
        self.left_out(stage, "there is no prototype /nothing")
        instancer.GetPrototypesRel().SetTargets(["/crowd"])
        self.left_out(stage, "instance of itself")

    def left_out(self, stage, said: str):
        """One prim is, for the reason said, and nothing else."""
        other = quad(stage, "/other").GetPrim()
        gltf = self.load(stage)
        self.assertEqual([(each.kind, each.count) for each in self.imported.lost], [("usd-prim", 1)])
        self.assertIn(said, str(self.imported.lost[0]))
        shown = [node.name for node in gltf.nodes if node.source.member("mesh") is not None]
        self.assertEqual(shown, ["other"])
        stage.RemovePrim(other.GetPath())

    def test_types_that_nobody_knows(self):
        stage = self.stage()
        stage.DefinePrim("/a", "Billboard")
        self.left_out(stage, "/a: is a `Billboard`, which USD does not know, and is passed over")
        stage = self.stage()
        stage.DefinePrim("/HoudiniLayerInfo", "HoudiniLayerInfo")
        stage.DefinePrim("/a", "Billboard")
        stage.SetMetadata("fallbackPrimTypes", {"Billboard": Vt.TokenArray(["Xform"])})
        quad(stage, "/a/quad")
        self.load(stage)
        self.assertEqual(self.imported.lost, [])

    def test_instancers_that_come_round(self):
        stage = self.stage()
        for name, other in (("a", "b"), ("b", "a")):
            instancer = UsdGeom.PointInstancer.Define(stage, f"/{name}")
            instancer.CreatePrototypesRel().SetTargets([f"/{other}"])
            instancer.CreateProtoIndicesAttr([0])
            instancer.CreatePositionsAttr([(0, 0, 0)])
        self.assertIn("come round", self.refused(stage))

    def test_numbers_that_are_none(self):
        stage = self.stage()
        quad(stage, "/a").GetPointsAttr().Set([(float("nan"), 0, 0)] * 4)
        self.left_out(stage, "/a: is left out: points are not all finite")
        stage = self.stage()
        quad(stage, "/a").AddTranslateOp().Set((float("inf"), 0, 0))
        self.left_out(stage, "/a: is left out: its place is not finite")
        # Twelve whole numbers are not four points.
        stage = self.stage()
        quad(stage, "/a").GetPrim().RemoveProperty("points")
        points = Sdf.AttributeSpec(
            stage.GetRootLayer().GetPrimAtPath("/a"), "points", Sdf.ValueTypeNames.IntArray
        )
        points.default = Vt.IntArray(12)
        self.left_out(stage, "/a: is left out: `points` holds other values than point3f[]")
        stage = self.stage()
        stage.SetEndTimeCode(1e12)
        quad(stage, "/a")
        self.load(stage)
        self.assertEqual(self.imported.frames, (1, 1))
        self.assertIn(
            "time codes 1 to 1e+12 are no range of 1 to 100000 frames", self.imported.lost[0].sentence
        )
        stage = self.stage()
        UsdGeom.Camera.Define(stage, "/camera").CreateFocalLengthAttr(0.0)
        self.left_out(stage, "/camera: is left out: a camera needs a focal length")

    def test_clocks_that_cannot_be(self):
        for rate, start, end, frames in ((24.0, 9, 2, (3, 7)), (24.0, -1e9, 1e9, (3, 7))):
            with self.subTest(rate=rate, start=start):
                stage = self.stage()
                stage.SetTimeCodesPerSecond(rate)
                stage.SetStartTimeCode(start)
                stage.SetEndTimeCode(end)
                place = quad(stage, "/a").AddTranslateOp()
                place.Set((1, 0, 0), 3)
                place.Set((2, 0, 0), 7)
                self.load(stage)
                self.assertEqual((self.imported.frames, self.imported.fps), (frames, 24))
                self.assertEqual({loss.kind for loss in self.imported.lost}, {"usd-clock"})

    def test_rates_and_units_that_are_none(self):
        stage = self.stage()
        stage.SetTimeCodesPerSecond(0)
        stage.SetMetadata("metersPerUnit", -1.0)
        quad(stage, "/a")
        self.load(stage)
        self.assertEqual(self.imported.fps, 24)
        said = {loss.kind: loss.sentence for loss in self.imported.lost}
        self.assertEqual(said["usd-clock"], "/: 0 time codes a second are no rate; 24 are taken")
        self.assertEqual(said["usd-unit"], "/: -1 metres are no unit; 0.01 are taken")

    def test_an_axis_that_points_up_and_is_none(self):
        stage = self.stage()
        stage.SetMetadata("upAxis", "X")
        quad(stage, "/a")
        self.load(stage)
        said = {loss.kind: loss.sentence for loss in self.imported.lost}
        self.assertEqual(said["usd-unit"], "/: up along X is neither Y nor Z; Y is taken")

    def test_samples_beneath_a_rate_of_none(self):
        """USD itself looks for them without end."""
        beneath = Usd.Stage.CreateNew(str(self.folder / "beneath.usda"))
        beneath.SetTimeCodesPerSecond(24)
        place = quad(beneath, "/a").AddTranslateOp()
        place.Set((1, 0, 0), 1)
        place.Set((2, 0, 0), 5)
        beneath.Save()
        stage = self.stage()
        stage.SetTimeCodesPerSecond(0)
        stage.GetRootLayer().subLayerPaths.append("beneath.usda")
        self.load(stage)
        self.assertEqual(self.imported.frames, (1, 5))
        self.assertEqual({loss.kind for loss in self.imported.lost}, {"usd-clock"})

    def test_textures_that_are_not_there(self):
        stage = self.stage()
        mesh = quad(stage, "/a")
        material = UsdShade.Material.Define(stage, "/m")
        shader, texture = UsdShade.Shader.Define(stage, "/m/s"), UsdShade.Shader.Define(stage, "/m/t")
        shader.CreateIdAttr("UsdPreviewSurface")
        texture.CreateIdAttr("UsdUVTexture")
        texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set("./no such.png")
        output = texture.CreateOutput("rgb", Sdf.ValueTypeNames.Float3)
        shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).ConnectToSource(output)
        material.CreateSurfaceOutput().ConnectToSource(
            shader.CreateOutput("surface", Sdf.ValueTypeNames.Token)
        )
        UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(material)
        material = self.load(stage).document.raw["materials"][0]
        np.testing.assert_allclose(
            material["pbrMetallicRoughness"]["baseColorFactor"], [0.18, 0.18, 0.18, 1.0]
        )
        self.assertEqual([loss.kind for loss in self.imported.lost], ["usd-texture"])
        self.assertIn(
            "/m/t: the texture `./no such.png` is left out: there is no such file",
            self.imported.lost[0].sentence,
        )

    def test_custom_data_of_any_type(self):
        for data in ("text", 3, {"sunfleck_material": "text", "KHR_materials_transmission": 3, "sunfleck_camera": Vt.DoubleArray([1.0, 2.0])},
                     {"sunfleck_material": {"transmission": "text", "mirror": Gf.Matrix4d(1)}, "sunfleck_light": "text"},
                     {"sunfleck_material": {"transmission": Vt.DoubleArray([0.5]), "mirror": Sdf.AssetPath("x")}}):  # fmt: skip
            stage = self.stage()
            stage.GetRootLayer().customLayerData = {"sunfleck": data}
            mesh, material = quad(stage, "/a"), UsdShade.Material.Define(stage, "/m")
            shader = UsdShade.Shader.Define(stage, "/m/s")
            shader.CreateIdAttr("UsdPreviewSurface")
            material.CreateSurfaceOutput().ConnectToSource(
                shader.CreateOutput("surface", Sdf.ValueTypeNames.Token)
            )
            UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(material)
            prims = [
                UsdGeom.Camera.Define(stage, "/camera"),
                UsdLux.SphereLight.Define(stage, "/lamp"),
                material,
            ]
            for prim in prims:
                prim.GetPrim().SetCustomDataByKey("sunfleck", data)
            try:
                self.load(stage)
            except SceneError as error:
                self.assertIn("does not fit its place", str(error))

    def test_flipped_bytes_raise_nothing_else(self):
        for ending in ("usdc", "usda"):
            whole = self.folder / f"whole.{ending}"
            export_usd(SAMPLES / "h_lights_nopointer.glb", whole)
            for number in range(40):
                generator, data = np.random.default_rng(number), bytearray(whole.read_bytes())
                for at in generator.integers(8, len(data), 2):
                    data[at] ^= int(generator.integers(1, 256))
                # USD would give the layer that is open already for a name that it knows.
                path = self.folder / f"flipped_{number}.{ending}"
                path.write_bytes(data)
                try:
                    import_usd(path, self.folder / "out.glb")
                except SceneError:
                    pass

    def test_an_empty_stage(self):
        self.load(self.stage())
        self.assertEqual([loss.kind for loss in self.imported.lost], ["usd-empty"])


if __name__ == "__main__":
    unittest.main()
