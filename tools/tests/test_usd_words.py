"""`import-usd`: words of a stage that were once passed over in silence.

What changes though it is read once is said. Colours by instance, RenderSettings, exposures and visibility by
purpose are honoured. Clips that are missing are said.
"""

import math
import unittest

import numpy as np
from PIL import Image
from pxr import Gf, Sdf, Usd, UsdGeom, UsdRender, UsdShade, Vt

from sunfleck_tools.gltf.scene import Gltf

from .test_usd_import import quad
from .test_usd_scenes import SceneCase

Types = Sdf.ValueTypeNames
SQUARE = [(0, 0), (1, 0), (1, 1), (0, 1)]
COLORS = [(1, 0, 0), (0, 1, 0), (0, 0, 1)]


class WordCase(SceneCase):
    def kinds(self, stage: Usd.Stage) -> list[tuple[str, str]]:
        """Ids of losses and where they are."""
        self.gltf = self.load(stage)
        return [(loss.kind, loss.place) for loss in self.imported.every]

    def picture_on(self, stage: Usd.Stage, node: str = "UsdUVTexture") -> UsdShade.Shader:
        """The texture of a square's material."""
        mesh = quad(stage, "/leaf")
        coordinates = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Types.TexCoord2fArray, "vertex")
        coordinates.Set(SQUARE)
        Image.fromarray(np.full((4, 4, 3), 128, np.uint8)).save(self.folder / "picture.png")
        picture = UsdShade.Shader.Define(stage, "/look/picture")
        picture.CreateIdAttr(node)
        picture.CreateInput("file", Types.Asset).Set("./picture.png")
        material = self.material(stage, "/look", (1, 1, 1))
        surface = UsdShade.Shader.Get(stage, "/look/surface")
        surface.GetInput("diffuseColor").ConnectToSource(picture.CreateOutput("rgb", Types.Float3))
        self.bind(mesh.GetPrim(), material)
        return picture


class Changing(WordCase):
    def test_texture_coordinates(self):
        stage = self.stage()
        self.picture_on(stage)
        attribute = stage.GetPrimAtPath("/leaf").GetAttribute("primvars:st")
        attribute.Set(SQUARE, 1)
        attribute.Set(SQUARE, 3)
        self.assertEqual(self.kinds(stage), [])
        attribute.Set([(x + 0.5, y) for x, y in SQUARE], 5)
        self.assertEqual(self.kinds(stage), [("usd-animated", "/leaf")])

    def test_inputs_of_textures(self):
        for name, kind, one, other in (
            ("scale", Types.Float4, (1, 1, 1, 1), (0.2, 0.2, 0.2, 1)),
            ("bias", Types.Float4, (0, 0, 0, 0), (0.1, 0, 0, 0)),
            ("wrapS", Types.Token, "clamp", "mirror"),
        ):
            stage = self.stage()
            given = self.picture_on(stage).CreateInput(name, kind)
            given.Set(one, 1)
            given.Set(other, 5)
            self.assertIn(("usd-material-animated", "/look/picture"), self.kinds(stage), name)

    def test_transforms_of_textures(self):
        for name, kind, one, other in (
            ("translation", Types.Float2, (0, 0), (0.5, 0)),
            ("rotation", Types.Float, 0, 90),
            ("scale", Types.Float2, (1, 1), (2, 2)),
        ):
            stage = self.stage()
            picture = self.picture_on(stage)
            mover = UsdShade.Shader.Define(stage, "/look/mover")
            mover.CreateIdAttr("UsdTransform2d")
            given = mover.CreateInput(name, kind)
            given.Set(one, 1)
            given.Set(other, 5)
            picture.CreateInput("st", Types.Float2).ConnectToSource(mover.CreateOutput("result", Types.Float2))
            self.assertEqual(self.kinds(stage), [("usd-material-animated", "/look/mover")], name)

    def test_normals_of_what_stays(self):
        stage = self.stage()
        mesh = quad(stage, "/a")
        mesh.SetNormalsInterpolation("vertex")
        mesh.CreateNormalsAttr().Set([(0, 0, 1)] * 4, 1)
        mesh.GetNormalsAttr().Set([(0, 1, 0)] * 4, 5)
        self.assertEqual(self.kinds(stage), [("usd-animated", "/a")])

    def test_faces_of_a_material(self):
        stage = self.stage()
        mesh = quad(stage, "/a")
        subset = UsdGeom.Subset.CreateGeomSubset(mesh, "part", "face", Vt.IntArray([0]), "materialBind")
        self.bind(subset.GetPrim(), self.material(stage, "/red", (1, 0, 0)))
        subset.GetIndicesAttr().Set([0], 1)
        subset.GetIndicesAttr().Set([], 5)
        self.assertEqual(self.kinds(stage), [("usd-animated", "/a/part")])

    def test_subsets_that_usd_passes_over(self):
        stage = self.stage()
        mesh = quad(stage, "/a")
        subset = UsdGeom.Subset.CreateGeomSubset(mesh, "part", "face", Vt.IntArray([0]), "region")
        self.bind(subset.GetPrim(), self.material(stage, "/red", (1, 0, 0)))
        self.assertEqual(self.kinds(stage), [("usd-composition", "/a/part")])

    def test_cameras(self):
        stage = self.stage()
        camera = UsdGeom.Camera.Define(stage, "/cam")
        camera.GetHorizontalApertureOffsetAttr().Set(0, 1)
        camera.GetHorizontalApertureOffsetAttr().Set(5, 5)
        camera.CreateStereoRoleAttr("left")
        self.assertEqual(self.kinds(stage), [("usd-camera-input", "/cam")] * 2)


class Clips(WordCase):
    def clipped(self, clips: dict) -> list[tuple[str, str]]:
        (self.folder / "clip.001.usda").write_text(
            '#usda 1.0\nover "leaf"\n{\n    double3 xformOp:translate.timeSamples = { 1: (0, 0.1, 0) }\n}\n'
        )
        stage = self.stage()
        mesh = quad(stage, "/leaf")
        mesh.AddTranslateOp().Set((0, 0, 0))
        mesh.GetPrim().SetMetadata("clips", {"default": {"primPath": "/leaf", **clips}})
        return self.kinds(stage)

    def test_files_that_are_missing(self):
        times = {"active": Vt.Vec2dArray([(1, 0), (3, 1)]), "times": Vt.Vec2dArray([(1, 1), (5, 5)])}
        paths = [Sdf.AssetPath("./clip.001.usda"), Sdf.AssetPath("./nothere.usda")]
        missing = self.clipped({"assetPaths": Sdf.AssetPathArray(paths), **times})
        self.assertEqual(missing, [("usd-missing", "/leaf")])
        self.assertIn("nothere.usda", self.said()["usd-missing"])
        paths[1] = paths[0]
        self.assertEqual(self.clipped({"assetPaths": Sdf.AssetPathArray(paths), **times}), [])

    def test_files_of_a_template(self):
        template = {"templateAssetPath": "./clip.###.usda", "templateStartTime": 1.0, "templateStride": 1.0}
        self.assertEqual(self.clipped({**template, "templateEndTime": 1.0}), [])
        self.assertEqual(self.clipped({**template, "templateEndTime": 3.0}), [("usd-missing", "/leaf")] * 2)


class ColorsByInstance(WordCase):
    def crowd(self, stage: Usd.Stage, count: int = 3) -> UsdGeom.PointInstancer:
        crowd = UsdGeom.PointInstancer.Define(stage, "/crowd")
        self.leaf = quad(stage, "/crowd/p/leaf")
        UsdGeom.Xform.Define(stage, "/crowd/p")
        crowd.CreatePrototypesRel().SetTargets(["/crowd/p"])
        crowd.CreateProtoIndicesAttr([0] * count)
        crowd.CreatePositionsAttr([(x, 0, 0) for x in range(count)])
        return crowd

    def paint(self, crowd: UsdGeom.PointInstancer, colors, interpolation: str = "vertex") -> UsdGeom.Primvar:
        primvar = UsdGeom.PrimvarsAPI(crowd).CreatePrimvar("displayColor", Types.Color3fArray, interpolation)
        primvar.Set(colors)
        return primvar

    def colors(self, gltf: Gltf, count: int = 3) -> list[list[float]]:
        return [self.color(gltf, f"crowd.{number}") for number in range(count)]

    def test_each_leaf_its_color(self):
        for interpolation in ("vertex", "varying"):
            stage = self.stage()
            self.paint(self.crowd(stage), COLORS, interpolation)
            self.assertEqual(self.kinds(stage), [])
            np.testing.assert_allclose(self.colors(self.gltf), COLORS)

    def test_by_indices(self):
        stage = self.stage()
        self.paint(self.crowd(stage), COLORS[:2]).SetIndices([1, 0, 1])
        self.assertEqual(self.kinds(stage), [])
        np.testing.assert_allclose(self.colors(self.gltf), [COLORS[1], COLORS[0], COLORS[1]])

    def test_one_color_of_all_goes_on_to_what_is_below(self):
        stage = self.stage()
        self.paint(self.crowd(stage), COLORS[:1], "constant")
        self.assertEqual(self.kinds(stage), [])
        attributes = self.gltf.document.items("meshes")[0].items("primitives")[0].member("attributes")
        colors = self.gltf.accessors.floats(attributes.member("COLOR_0"), 3)
        np.testing.assert_allclose(colors, [COLORS[0]] * len(colors))

    def test_a_color_of_the_mesh_comes_first_and_so_does_a_material_that_reads_none(self):
        stage = self.stage()
        crowd = self.crowd(stage)
        self.paint(crowd, COLORS)
        self.leaf.CreateDisplayColorAttr([(0.5, 0.5, 0.5)])
        self.kinds(stage)
        np.testing.assert_allclose(self.colors(self.gltf), [(1, 1, 1)] * 3)
        stage = self.stage()
        self.paint(self.crowd(stage), COLORS)
        self.bind(self.leaf.GetPrim(), self.material(stage, "/red", (0.25, 0, 0)))
        self.kinds(stage)
        np.testing.assert_allclose(self.colors(self.gltf), [(0.25, 0, 0)] * 3)

    def test_a_material_that_reads_the_colors_of_meshes(self):
        stage = self.stage()
        self.paint(self.crowd(stage), COLORS)
        material = self.material(stage, "/look", (1, 1, 1))
        reader = UsdShade.Shader.Define(stage, "/look/reader")
        reader.CreateIdAttr("UsdPrimvarReader_float3")
        reader.CreateInput("varname", Types.String).Set("displayColor")
        surface = UsdShade.Shader.Get(stage, "/look/surface")
        surface.GetInput("diffuseColor").ConnectToSource(reader.CreateOutput("result", Types.Float3))
        self.bind(self.leaf.GetPrim(), material)
        self.assertEqual(self.kinds(stage), [])
        np.testing.assert_allclose(self.colors(self.gltf), COLORS)

    def test_prototypes_that_are_more_than_a_shape(self):
        stage = self.stage()
        self.paint(self.crowd(stage), COLORS)
        self.leaf.AddTranslateOp().Set((0, 1, 0))
        gltf = self.load(stage)
        found = [self.color(gltf, node.name) for node in gltf.nodes if node.source.member("mesh") is not None]
        np.testing.assert_allclose(found, COLORS)

    def test_what_does_not_fit_or_changes_is_said(self):
        stage = self.stage()
        self.paint(self.crowd(stage), COLORS[:2])
        self.assertEqual(self.kinds(stage), [("usd-primvar", "/crowd")])
        stage = self.stage()
        primvar = self.paint(self.crowd(stage), COLORS)
        primvar.Set(COLORS, 1)
        primvar.Set(COLORS[::-1], 5)
        stage.GetPrimAtPath("/crowd").GetAttribute("positions").Set([(x, 0, 0) for x in range(3)], 1)
        stage.GetPrimAtPath("/crowd").GetAttribute("positions").Set([(x, 1, 0) for x in range(3)], 5)
        self.assertEqual(self.kinds(stage), [("usd-material-animated", "/crowd")])
        stage = self.stage()
        hue = UsdGeom.PrimvarsAPI(self.crowd(stage)).CreatePrimvar("hue", Types.FloatArray, "vertex")
        hue.Set([0.1, 0.2, 0.3])
        self.assertEqual(self.kinds(stage), [("usd-primvar", "/crowd")])


class Settings(WordCase):
    def test_camera_and_resolution(self):
        stage = self.stage()
        for name in ("cam", "other"):
            UsdGeom.Camera.Define(stage, f"/{name}").GetPrim()
        settings = UsdRender.Settings.Define(stage, "/Render/rs")
        settings.CreateCameraRel().SetTargets(["/other"])
        settings.CreateResolutionAttr(Gf.Vec2i(685, 500))
        settings.CreateDisableMotionBlurAttr(True)
        self.assertEqual(self.kinds(stage), [])
        found = self.gltf.document.raw["scenes"][0]["extras"]["sunfleck"]
        self.assertEqual((found["camera"], found["resolution"], found["shutter"]), ("other", [685, 500], 0.0))
        # Of another shape than the camera's: USD would show more, here its height is kept.
        settings.GetResolutionAttr().Set(Gf.Vec2i(500, 500))
        self.assertEqual(self.kinds(stage), [("usd-render-settings", "/Render/rs")])

    def test_a_product_comes_first_and_what_is_not_carried_is_said(self):
        stage = self.stage()
        UsdGeom.Camera.Define(stage, "/cam")
        settings = UsdRender.Settings.Define(stage, "/rs")
        settings.CreateResolutionAttr(Gf.Vec2i(640, 480))
        product = UsdRender.Product.Define(stage, "/product")
        product.CreateResolutionAttr(Gf.Vec2i(320, 240))
        settings.CreateProductsRel().SetTargets(["/product"])
        settings.CreatePixelAspectRatioAttr(2.0)
        settings.CreateDataWindowNDCAttr(Gf.Vec4f(0, 0, 0.5, 1))
        settings.CreateCameraRel().SetTargets(["/nobody"])
        found = self.kinds(stage)
        self.assertEqual(found, [("usd-missing", "/rs")] + [("usd-render-settings", "/rs")] * 2)
        self.assertEqual(self.gltf.document.raw["scenes"][0]["extras"]["sunfleck"]["resolution"], [320, 240])

    def test_exposure(self):
        stage = self.stage()
        camera = UsdGeom.Camera.Define(stage, "/cam")
        camera.CreateExposureAttr(3.0)
        self.assertEqual(self.kinds(stage), [("usd-camera-input", "/cam")])
        extras = self.gltf.document.raw["scenes"][0]["extras"]["sunfleck"]
        self.assertTrue(math.isclose(extras["exposure"], 3.0))
        camera.GetExposureAttr().Set(0.0)
        self.assertEqual(self.kinds(stage), [])

    def test_blur(self):
        stage = self.stage()
        motion = UsdGeom.MotionAPI.Apply(quad(stage, "/leaf").GetPrim())
        motion.CreateMotionBlurScaleAttr(0.5)
        self.assertEqual(self.kinds(stage), [("usd-motion", "/leaf")])


class VisibilityByPurpose(WordCase):
    def test_render_visibility(self):
        for purpose, word, is_seen in (
            ("render", "invisible", False), ("render", "inherited", True), ("default", "invisible", True),
        ):  # fmt: skip
            stage = self.stage()
            UsdGeom.Xform.Define(stage, "/v")
            mesh = quad(stage, "/v/leaf")
            mesh.CreatePurposeAttr(purpose)
            UsdGeom.VisibilityAPI.Apply(stage.GetPrimAtPath("/v")).CreateRenderVisibilityAttr(word)
            gltf = self.load(stage)
            self.assertEqual("meshes" in gltf.document.raw, is_seen, (purpose, word))


class Tiles(WordCase):
    def test_tiling_of_materialx(self):
        stage = self.stage()
        picture = self.picture_on(stage, "ND_tiledimage_color3")
        picture.CreateInput("uvtiling", Types.Float2).Set((2, 3))
        picture.CreateInput("uvoffset", Types.Float2).Set((0.25, 0))
        self.assertEqual(self.kinds(stage), [])
        (material,) = self.gltf.document.raw["materials"]
        moved = material["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]["KHR_texture_transform"]
        self.assertEqual((moved["scale"], moved["offset"]), ([2.0, 3.0], [-0.25, -2.0]))

    def test_nodes_and_inputs_that_are_passed_over(self):
        stage = self.stage()
        picture = self.picture_on(stage)
        mover = UsdShade.Shader.Define(stage, "/look/mover")
        mover.CreateIdAttr("ND_place2d_vector2")
        picture.CreateInput("st", Types.Float2).ConnectToSource(mover.CreateOutput("out", Types.Float2))
        picture.CreateInput("gain", Types.Float).Set(2.0)
        self.assertEqual(self.kinds(stage), [("usd-material-input", "/look/picture")] * 2)


if __name__ == "__main__":
    unittest.main()
