"""Materials and textures of stages: what the texels come to, and what is said where that cannot be."""

import io
import struct
import unittest
import zlib

import numpy as np
from PIL import Image
from pxr import Sdf, Usd, UsdGeom, UsdShade, Vt

from sunfleck_tools.exr.write import write_colors
from sunfleck_tools.gltf.scene import Gltf
from sunfleck_tools.usd.reading.texels import linear_from_srgb

from .test_usd_export import needs_program
from .test_usd_import import quad
from .test_usd_lights import LookCase

ORANGE = np.array([200, 100, 50]) / 255
TYPES = Sdf.ValueTypeNames


def texels(gltf: Gltf, info: dict) -> np.ndarray:
    """What a texture has, 0 to 1 as stored."""
    source = gltf.document.raw["textures"][info["index"]]["source"]
    data, start, length, _ = gltf.container.view(gltf.document.items("images")[source].need("bufferView"))
    return np.asarray(Image.open(io.BytesIO(bytes(data[start : start + length]))), float) / 255


class SurfaceCase(LookCase):
    def surface(
        self, stage: Usd.Stage, path: str = "/m", kind: str = "UsdPreviewSurface", **inputs
    ) -> UsdShade.Material:
        """A material; inputs are numbers, or (texture node, output)."""
        material = UsdShade.Material.Define(stage, path)
        shader = UsdShade.Shader.Define(stage, f"{path}/surface")
        shader.CreateIdAttr(kind)
        for name, value in inputs.items():
            is_color = "olor" in name or name == "normal"
            made = shader.CreateInput(name, TYPES.Color3f if is_color else TYPES.Float)
            if isinstance(value, tuple) and isinstance(value[0], UsdShade.Shader):
                made.ConnectToSource(
                    value[0].CreateOutput(value[1], TYPES.Float3 if value[1] == "rgb" else TYPES.Float)
                )
            else:
                made.Set(value)
        material.CreateSurfaceOutput().ConnectToSource(shader.CreateOutput("surface", TYPES.Token))
        return material

    def texture(self, stage: Usd.Stage, name: str, pixels: np.ndarray | None, **inputs) -> UsdShade.Shader:
        """A node that reads pixels (bytes), which are written as PNG beside the stage, or a
        file that is there."""
        path = f"/textures/{name.partition('.')[0].replace('<', '_').replace('>', '_')}"
        if pixels is not None:
            Image.fromarray(pixels).save(self.folder / name)
        shader = UsdShade.Shader.Define(stage, path)
        shader.CreateIdAttr("UsdUVTexture")
        shader.CreateInput("file", TYPES.Asset).Set(f"./{name}")
        for key, value in inputs.items():
            shader.CreateInput(key, TYPES.Token if isinstance(value, str) else TYPES.Float4).Set(value)
        return shader

    def shown(self, stage: Usd.Stage, material: UsdShade.Material, **kinds) -> dict:
        """The glTF material of a square that has it."""
        mesh = quad(stage, "/leaf")
        primvar = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", TYPES.TexCoord2fArray, "vertex")
        primvar.Set(Vt.Vec2fArray([(0, 0), (1, 0), (1, 1), (0, 1)]))
        UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(material)
        self.gltf = self.load(stage)
        return self.gltf.document.raw["materials"][0]


class Connections(LookCase):
    def test_interfaces_and_texts_name_files(self):
        for name in ("Q_interface_file", "Q2_string_file"):
            gltf = self.case(name)
            pbr = gltf.document.raw["materials"][0]["pbrMetallicRoughness"]
            np.testing.assert_allclose(texels(gltf, pbr["baseColorTexture"])[0, 0], ORANGE)
            self.assertEqual(self.imported.lost, [])

    def test_node_graphs_are_followed(self):
        stage = self.stage()
        graph = UsdShade.NodeGraph.Define(stage, "/m/graph")
        graph.CreateInput("tint", TYPES.Color3f).Set((0.1, 0.2, 0.3))
        out = graph.CreateOutput("out", TYPES.Color3f)
        out.ConnectToSource(graph.GetInput("tint"))
        material, shader = UsdShade.Material.Define(stage, "/m"), UsdShade.Shader.Define(stage, "/m/s")
        shader.CreateIdAttr("UsdPreviewSurface")
        shader.CreateInput("diffuseColor", TYPES.Color3f).ConnectToSource(out)
        material.CreateSurfaceOutput().ConnectToSource(shader.CreateOutput("surface", TYPES.Token))
        mesh = quad(stage, "/leaf")
        UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(material)
        found = self.load(stage).document.raw["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"]
        np.testing.assert_allclose(found, [0.1, 0.2, 0.3, 1.0], rtol=1e-6)

    def test_bindings_by_purpose(self):
        found = self.case("S_binding_full").document.raw["materials"][0]
        self.assertEqual(found["pbrMetallicRoughness"]["baseColorFactor"], [1.0, 0.0, 0.0, 1.0])

    def test_a_binding_to_nothing_is_said(self):
        stage = self.stage()
        for path in ("/group", "/group/by_parent", "/by_itself"):
            stage.DefinePrim(path, "Xform") if path == "/group" else quad(stage, path)
        for path in ("/group", "/by_itself"):
            rel = UsdShade.MaterialBindingAPI.Apply(stage.GetPrimAtPath(path)).GetDirectBindingRel()
            (rel or stage.GetPrimAtPath(path).CreateRelationship("material:binding")).SetTargets(["/gone"])
        self.load(stage)
        (loss,) = self.imported.lost
        self.assertEqual((loss.kind, loss.count), ("usd-missing", 2))
        self.assertIn("is bound to /gone, which is no material", loss.sentence)

    def test_a_surface_that_is_known_goes_before_one_that_is_not(self):
        stage = self.stage()
        mesh = quad(stage, "/leaf")
        for name, purpose, kind in (
            ("fine", "full", "someones_surface"),
            ("rough", "preview", "UsdPreviewSurface"),
        ):
            material = UsdShade.Material.Define(stage, f"/{name}")
            shader = UsdShade.Shader.Define(stage, f"/{name}/s")
            shader.CreateIdAttr(kind)
            material.CreateSurfaceOutput().ConnectToSource(shader.CreateOutput("surface", TYPES.Token))
            UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(material, materialPurpose=purpose)
        self.assertEqual(self.load(stage).document.raw["materials"][0]["name"], "rough")

    def test_a_collection_binds(self):
        stage = self.stage()
        world = UsdGeom.Xform.Define(stage, "/world").GetPrim()
        quad(stage, "/world/leaf")
        material = UsdShade.Material.Define(stage, "/m")
        shader = UsdShade.Shader.Define(stage, "/m/s")
        shader.CreateIdAttr("UsdPreviewSurface")
        material.CreateSurfaceOutput().ConnectToSource(shader.CreateOutput("surface", TYPES.Token))
        collection = Usd.CollectionAPI.Apply(world, "leaves")
        collection.IncludePath("/world/leaf")
        UsdShade.MaterialBindingAPI.Apply(world).Bind(collection, material)
        self.assertEqual(self.load(stage).document.raw["materials"][0]["name"], "m")


class Packing(SurfaceCase):
    def test_separate_maps(self):
        for name, roughness, metallic in (
            ("A_separate_rough_metal", 1.0, 0.0),
            ("A2_metal_map_only", 0.9, 0.0),
            ("A3_rough_map_metal_const", 0.2, 1.0),
        ):
            gltf = self.case(name)
            pbr = gltf.document.raw["materials"][0]["pbrMetallicRoughness"]
            texel = texels(gltf, pbr["metallicRoughnessTexture"])[3, 3]
            self.assertAlmostEqual(texel[1] * pbr["roughnessFactor"], roughness, 2)
            self.assertAlmostEqual(texel[2] * pbr["metallicFactor"], metallic, 2)
            self.assertEqual(self.imported.lost, [])

    @needs_program
    def test_a_black_map_is_no_metal(self):
        """Matte, but for the coat's few percent: 0.8 / pi of 3 W/m2."""
        self.case("A_separate_rough_metal")
        centre = self.picture(size="32x18", samples=4)[8:10, 15:17].mean(axis=(0, 1))
        np.testing.assert_allclose(centre, np.array([0.8, 0.4, 0.1]) * 3 / np.pi, rtol=0.1, atol=0.03)

    def test_maps_of_different_sizes(self):
        stage = self.stage()
        rough = self.texture(stage, "rough.png", np.full((4, 8), 51, np.uint8))
        metal = self.texture(stage, "metal.png", np.full((16, 2), 102, np.uint8))
        pbr = self.shown(stage, self.surface(stage, roughness=(rough, "r"), metallic=(metal, "r")))["pbrMetallicRoughness"]
        found = texels(self.gltf, pbr["metallicRoughnessTexture"])
        self.assertEqual(found.shape[:2], (16, 8))
        np.testing.assert_allclose(found[..., 1:], np.broadcast_to([0.2, 0.4], (16, 8, 2)), atol=1e-6)

    def test_maps_that_lie_elsewhere_have_their_mean(self):
        stage = self.stage()
        rough = self.texture(stage, "rough.png", np.full((4, 4), 51, np.uint8))
        metal = self.texture(stage, "metal.png", np.uint8([[0, 204]]), wrapS="clamp")
        pbr = self.shown(stage, self.surface(stage, roughness=(rough, "r"), metallic=(metal, "r")))["pbrMetallicRoughness"]
        self.assertAlmostEqual(
            pbr["metallicFactor"] * texels(self.gltf, pbr["metallicRoughnessTexture"])[0, 0, 2], 0.4, 5
        )
        self.assertIn("lies elsewhere", self.said()["usd-texture-packing"])

    def test_opacity_from_another_texture(self):
        stage = self.stage()
        leaf = self.texture(stage, "leaf.png", np.full((2, 2, 3), (200, 100, 50), np.uint8))
        cut = self.texture(stage, "cut.png", np.uint8([[0, 255], [255, 0]]))
        found = self.shown(
            stage, self.surface(stage, diffuseColor=(leaf, "rgb"), opacity=(cut, "r"), opacityThreshold=0.5)
        )
        self.assertEqual((found["alphaMode"], found["alphaCutoff"]), ("MASK", 0.5))
        baked = texels(self.gltf, found["pbrMetallicRoughness"]["baseColorTexture"])
        np.testing.assert_allclose(baked[..., :3], np.broadcast_to(ORANGE, (2, 2, 3)), atol=1e-6)
        np.testing.assert_allclose(baked[..., 3], [[0, 1], [1, 0]])

    def test_opacity_over_one_colour(self):
        stage = self.stage()
        cut = self.texture(stage, "cut.png", np.uint8([[0, 255]]))
        found = self.shown(stage, self.surface(stage, diffuseColor=(0.1, 0.2, 0.3), opacity=(cut, "r")))
        np.testing.assert_allclose(
            found["pbrMetallicRoughness"]["baseColorFactor"], [0.1, 0.2, 0.3, 1.0], rtol=1e-6
        )
        baked = texels(self.gltf, found["pbrMetallicRoughness"]["baseColorTexture"])
        np.testing.assert_allclose(baked, [[[1, 1, 1, 0], [1, 1, 1, 1]]])
        self.assertEqual(found["alphaMode"], "BLEND")

    def test_an_alpha_that_nobody_asks_for_does_not_count(self):
        stage = self.stage()
        leaf = self.texture(stage, "leaf.png", np.full((2, 2, 4), (200, 100, 50, 0), np.uint8))
        found = self.shown(stage, self.surface(stage, diffuseColor=(leaf, "rgb"), opacity=0.5))
        baked = texels(self.gltf, found["pbrMetallicRoughness"]["baseColorTexture"])
        self.assertEqual(baked.shape, (2, 2, 3))
        self.assertEqual(found["pbrMetallicRoughness"]["baseColorFactor"][3], 0.5)

    def test_coats(self):
        stage = self.stage()
        coat = self.texture(stage, "coat.png", np.full((2, 2), 102, np.uint8))
        material = self.shown(stage, self.surface(stage, clearcoat=(coat, "r"), clearcoatRoughness=0.25))
        found = material["extensions"]["KHR_materials_clearcoat"]
        texel = texels(self.gltf, found["clearcoatTexture"])[0, 0]
        self.assertAlmostEqual(found["clearcoatFactor"] * texel[0], 0.4, 6)
        self.assertAlmostEqual(found["clearcoatRoughnessFactor"] * texel[1], 0.25, 6)


class Texels(SurfaceCase):
    def color(self, **inputs) -> np.ndarray:
        """Linear base colour of a texture of (200, 100, 50)."""
        stage = self.stage()
        leaf = self.texture(stage, "leaf.png", np.full((2, 2, 3), (200, 100, 50), np.uint8), **inputs)
        pbr = self.shown(stage, self.surface(stage, diffuseColor=(leaf, "rgb")))["pbrMetallicRoughness"]
        return linear_from_srgb(texels(self.gltf, pbr["baseColorTexture"])[0, 0]) * pbr["baseColorFactor"][:3]

    def test_spaces_scale_and_bias(self):
        linear = linear_from_srgb(ORANGE)
        half = (0.5, 0.5, 0.5, 1.0)
        for inputs, expected in (
            ({}, linear),
            ({"sourceColorSpace": "sRGB", "scale": half}, 0.5 * linear),
            ({"sourceColorSpace": "raw"}, ORANGE),
            ({"sourceColorSpace": "raw", "scale": half, "bias": (0.2, 0.2, 0.2, 0.0)}, 0.5 * ORANGE + 0.2),
        ):
            np.testing.assert_allclose(self.color(**inputs), expected, atol=4e-3)
            self.assertEqual(self.imported.lost, [])
        np.testing.assert_allclose(
            self.color(scale=(2.0, 2.0, 2.0, 1.0)), np.minimum(2 * linear, 1), atol=4e-3
        )
        self.assertIn("clipped", self.said()["usd-texture-range"])

    def test_a_space_that_is_not_known(self):
        np.testing.assert_allclose(self.color(sourceColorSpace="ACEScg"), ORANGE, atol=4e-3)
        self.assertIn("`ACEScg` is not known", self.said()["usd-material-input"])

    @needs_program
    def test_bias_and_raw_as_rendered(self):
        """Of 3 W/m2 head on a matte wall of colour c gives back 3 c / pi, and its coat of roughness 0.5 F /
        (4 pi a^2), a = 0.25."""
        self.case("B_bias_raw")
        centre = self.picture(size="160x90", samples=16)[44:46, 79:81].mean(axis=(0, 1))
        coat = 3 * 0.04 / (4 * np.pi * 0.0625)
        np.testing.assert_allclose(centre - coat, (0.5 * ORANGE + 0.2) * 3 / np.pi, rtol=0.05)

    def test_other_formats(self):
        gltf = self.case("C_tga")
        found = texels(gltf, gltf.document.raw["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"])
        np.testing.assert_allclose(found[4, 4], ORANGE)
        for ending in ("webp", "tif", "bmp"):
            stage = self.stage()
            Image.fromarray(np.full((4, 4, 3), (200, 100, 50), np.uint8)).save(
                self.folder / f"leaf.{ending}", lossless=True
            )
            leaf = self.texture(stage, f"leaf.{ending}", None)
            pbr = self.shown(stage, self.surface(stage, diffuseColor=(leaf, "rgb")))["pbrMetallicRoughness"]
            np.testing.assert_allclose(texels(self.gltf, pbr["baseColorTexture"])[0, 0, :3], ORANGE)

    def test_linear_light(self):
        """OpenEXR is linear: colours to sRGB, what is brighter than 1 clipped; emission keeps
        how bright it is."""
        stage = self.stage()
        write_colors(self.folder / "light.exr", np.full((2, 2, 3), (0.25, 0.5, 4.0), np.float32))
        light = self.texture(stage, "light.exr", None)
        found = self.shown(
            stage, self.surface(stage, diffuseColor=(light, "rgb"), emissiveColor=(light, "rgb"))
        )
        base = texels(self.gltf, found["pbrMetallicRoughness"]["baseColorTexture"])[0, 0]
        np.testing.assert_allclose(linear_from_srgb(base), [0.25, 0.5, 1.0], atol=4e-3)
        strength = found["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"]
        emission = (
            linear_from_srgb(texels(self.gltf, found["emissiveTexture"])[0, 0])
            * found["emissiveFactor"]
            * strength
        )
        np.testing.assert_allclose(emission, [0.25, 0.5, 4.0], atol=0.016)
        self.assertEqual(set(self.said()), {"usd-texture-range"})

    def test_a_missing_file_has_its_fallback(self):
        found = self.case("C_missing").document.raw["materials"][0]
        self.assertEqual(found["pbrMetallicRoughness"]["baseColorFactor"], [1.0, 0.0, 0.0, 1.0])
        self.assertIn("there is no such file", self.said()["usd-texture"])

    def test_damaged_files_are_left_out(self):
        good = io.BytesIO()
        Image.fromarray(np.random.default_rng(1).integers(0, 255, (64, 64, 3), np.uint8)).save(good, "PNG")
        jpeg = io.BytesIO()
        Image.fromarray(np.random.default_rng(1).integers(0, 255, (64, 64, 3), np.uint8)).save(jpeg, "JPEG")
        claims = struct.pack(">IIBBBBB", 100_000, 100_000, 8, 2, 0, 0, 0)
        chunk = (
            struct.pack(">I", len(claims))
            + b"IHDR"
            + claims
            + struct.pack(">I", zlib.crc32(b"IHDR" + claims))
        )
        for data, said in (
            (b"", "is none of OpenEXR"),
            (b"no picture", "is none of OpenEXR"),
            (good.getvalue()[:2000], "damaged"),
            (jpeg.getvalue()[:900], "damaged"),
            (b"\x89PNG\r\n\x1a\n" + chunk + good.getvalue()[33:], "claims"),
            (b"\x76\x2f\x31\x01" + bytes(40), "damaged OpenEXR"),
        ):
            (self.folder / "bad.png").write_bytes(data)
            stage = self.stage()
            leaf = self.texture(stage, "bad.png", None)
            pbr = self.shown(stage, self.surface(stage, diffuseColor=(leaf, "rgb")))["pbrMetallicRoughness"]
            self.assertNotIn("baseColorTexture", pbr)
            self.assertIn(said, self.said()["usd-texture"])

    def test_normal_maps(self):
        texel = (64, 192, 255)
        usual = {"scale": (2.0, 2.0, 2.0, 1.0), "bias": (-1.0, -1.0, -1.0, 0.0), "sourceColorSpace": "raw"}
        flipped = {**usual, "scale": (2.0, -2.0, 2.0, 1.0), "bias": (-1.0, 1.0, -1.0, 0.0)}
        for inputs, expected, kinds in (
            (usual, (64, 192, 255), set()),
            ({}, (64, 192, 255), {"usd-normal-map"}),
            # Green counted from the other side.
            (flipped, (64, 63, 255), set()),
        ):
            stage = self.stage()
            bumps = self.texture(stage, "bumps.png", np.full((2, 2, 3), texel, np.uint8), **inputs)
            found = self.shown(stage, self.surface(stage, normal=(bumps, "rgb")))
            np.testing.assert_allclose(
                texels(self.gltf, found["normalTexture"])[0, 0] * 255, expected, atol=0.51
            )
            self.assertEqual(set(self.said()), kinds)

    def test_black_around_a_texture_is_said(self):
        stage = self.stage()
        leaf = self.texture(stage, "leaf.png", np.full((2, 2, 3), 255, np.uint8), wrapS="black")
        self.shown(stage, self.surface(stage, diffuseColor=(leaf, "rgb")))
        self.assertEqual(set(self.said()), {"usd-texture-wrap"})


class Tiles(SurfaceCase):
    def sampled(self, gltf: Gltf, st: tuple[float, float]) -> np.ndarray:
        """What the texture has at coordinates of the stage, by KHR_texture_transform, nearest texel."""
        info = gltf.document.raw["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]
        moved = info["extensions"]["KHR_texture_transform"]
        uv = np.array(moved["scale"]) * [st[0], 1 - st[1]] + moved["offset"]
        picture = texels(gltf, info)
        x, y = (uv * picture.shape[1::-1]).astype(int)
        return np.round(picture[y, x] * 255)

    def test_two_side_by_side(self):
        gltf = self.case("C_udim")
        np.testing.assert_allclose(self.sampled(gltf, (0.5, 0.5)), [200, 100, 50])
        np.testing.assert_allclose(self.sampled(gltf, (1.5, 0.5)), [50, 100, 200])

    def test_rows_count_from_below(self):
        stage = self.stage()
        for tile, value in ((1001, 10), (1011, 20), (1012, 30)):
            Image.fromarray(np.full((4, 4, 3), value, np.uint8)).save(self.folder / f"tile.{tile}.png")
        tiles = self.texture(stage, "tile.<UDIM>.png", None)
        self.shown(stage, self.surface(stage, diffuseColor=(tiles, "rgb")))
        for st, value in (((0.5, 0.5), 10), ((0.5, 1.5), 20), ((1.5, 1.5), 30)):
            np.testing.assert_allclose(self.sampled(self.gltf, st), [value] * 3)

    def test_none_at_all(self):
        stage = self.stage()
        tiles = self.texture(stage, "tile.<UDIM>.png", None)
        self.shown(stage, self.surface(stage, diffuseColor=(tiles, "rgb")))
        self.assertIn("has no tiles", self.said()["usd-texture"])


class Reflection(SurfaceCase):
    def test_what_is_reflected_may_be_said_outright(self):
        found = self.case("Y_spec").document.raw["materials"][0]
        extensions = found["extensions"]
        # Index 0 of the extension: F0 is the specular colour itself.
        self.assertEqual(extensions["KHR_materials_ior"]["ior"], 0.0)
        self.assertEqual(extensions["KHR_materials_specular"]["specularColorFactor"], [1.0, 0.0, 0.0])
        self.assertEqual(found["pbrMetallicRoughness"]["metallicFactor"], 0.0)

    @needs_program
    def test_it_shines_red(self):
        """GGX of roughness 0.5 head on: D F G / 4 = F / (4 pi a^2), a = 0.25, times 3 W/m2."""
        self.case("Y_spec")
        centre = self.picture(size="160x90", samples=16)[44:46, 79:81].mean(axis=(0, 1))
        self.assertAlmostEqual(centre[0] / (3 / (4 * np.pi * 0.0625)), 1.0, delta=0.02)
        self.assertLess(centre[1:].max(), 1e-3 * centre[0])

    def test_displacement_is_said(self):
        stage = self.stage()
        self.shown(stage, self.surface(stage, displacement=0.1))
        self.assertIn("displacement is not carried", self.said()["usd-material-input"])


class Values(SurfaceCase):
    def test_what_is_no_number_has_its_default(self):
        stage = self.stage()
        material = self.surface(stage)
        spec = stage.GetRootLayer().GetPrimAtPath("/m/surface")
        for name in ("diffuseColor", "roughness", "opacity"):
            Sdf.AttributeSpec(spec, f"inputs:{name}", TYPES.String).default = "green"
        pbr = self.shown(stage, material)["pbrMetallicRoughness"]
        np.testing.assert_allclose(pbr["baseColorFactor"], [0.18, 0.18, 0.18, 1.0])
        self.assertEqual(pbr["roughnessFactor"], 0.5)
        self.assertEqual({loss.kind: loss.count for loss in self.imported.lost}, {"usd-material-value": 3})

    def test_what_is_out_of_range_is_put_into_it_and_said(self):
        stage = self.stage()
        colors = {"diffuseColor": (-1, 0.5, 5), "emissiveColor": (-1, 0, 2)}
        found = self.shown(stage, self.surface(stage, **colors, roughness=3.0, metallic=-0.5))
        pbr = found["pbrMetallicRoughness"]
        np.testing.assert_allclose(pbr["baseColorFactor"], [0, 0.5, 1, 1])
        self.assertEqual((pbr["roughnessFactor"], pbr["metallicFactor"]), (1, 0))
        self.assertEqual([(loss.kind, loss.count) for loss in self.imported.lost], [("usd-material-value", 4)])

    def test_textures_are_placed_by_numbers_alone(self):
        stage = self.stage()
        leaf = self.texture(stage, "leaf.png", np.full((2, 2, 3), 255, np.uint8))
        move = UsdShade.Shader.Define(stage, "/move")
        move.CreateIdAttr("UsdTransform2d")
        move.CreateInput("rotation", TYPES.Float).Set(float("nan"))
        leaf.CreateInput("st", TYPES.Float2).ConnectToSource(move.CreateOutput("result", TYPES.Float2))
        found = self.shown(stage, self.surface(stage, diffuseColor=(leaf, "rgb")))
        self.assertNotIn("extensions", found["pbrMetallicRoughness"]["baseColorTexture"])
        self.assertIn("no numbers", self.said()["usd-material-input"])


class OtherSurfaces(SurfaceCase):
    def test_known_by_name(self):
        for kind, inputs, expected in (
            ("ND_standard_surface_surfaceshader", {"base": 0.5, "base_color": (0.8, 0.4, 0.2), "metalness": 1.0, "specular_roughness": 0.3},
             ([0.4, 0.2, 0.1], 1.0, 0.3)),
            ("arnold:standard_surface", {"base_color": (0.8, 0.4, 0.2)}, ([0.8, 0.4, 0.2], 0.0, 0.2)),
            ("ND_open_pbr_surface_surfaceshader", {"base_color": (0.8, 0.4, 0.2), "base_metalness": 0.5}, ([0.8, 0.4, 0.2], 0.5, 0.3)),
            ("ND_gltf_pbr_surfaceshader", {"base_color": (0.8, 0.4, 0.2), "metallic": 0.25, "roughness": 0.75}, ([0.8, 0.4, 0.2], 0.25, 0.75)),
        ):  # fmt: skip
            stage = self.stage()
            pbr = self.shown(stage, self.surface(stage, kind=kind, **inputs))["pbrMetallicRoughness"]
            np.testing.assert_allclose(pbr["baseColorFactor"][:3], expected[0], rtol=1e-6)
            np.testing.assert_allclose(
                [pbr["metallicFactor"], pbr["roughnessFactor"]], expected[1:], rtol=1e-6
            )
            self.assertEqual(set(self.said()), {"usd-material-approximated"})

    def test_not_known(self):
        stage = self.stage()
        pbr = self.shown(stage, self.surface(stage, kind="someones_surface"))["pbrMetallicRoughness"]
        self.assertEqual(pbr["baseColorFactor"], [0.18, 0.18, 0.18, 1.0])
        self.assertIn("`someones_surface`", self.said()["usd-material"])


class Colors(SurfaceCase):
    def colors(self, gltf: Gltf) -> np.ndarray:
        """COLOR_0 of the only mesh."""
        number = gltf.document.raw["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"]
        accessor = gltf.document.items("accessors")[number]
        width = {"VEC3": 3, "VEC4": 4}[accessor.text_at("type")]
        data, start, length, _ = gltf.container.view(accessor.need("bufferView"))
        return np.frombuffer(bytes(data[start : start + length]), np.float32).reshape(-1, width)

    def test_a_mesh_without_a_material_has_its_own(self):
        gltf = self.case("L_displayOpacity")
        np.testing.assert_allclose(self.colors(gltf), [[1, 0, 0, 0.3]] * 4, rtol=1e-6)
        material = gltf.document.raw["materials"][0]
        self.assertEqual(
            (material["alphaMode"], material["pbrMetallicRoughness"]["metallicFactor"]), ("BLEND", 0.0)
        )

    def test_none_at_all_is_grey(self):
        stage = self.stage()
        quad(stage, "/leaf")
        material = self.load(stage).document.raw["materials"][0]
        self.assertEqual(material["pbrMetallicRoughness"]["baseColorFactor"], [0.18, 0.18, 0.18, 1.0])

    def test_what_is_no_share_is_clipped_and_said(self):
        stage = self.stage()
        quad(stage, "/leaf").CreateDisplayColorAttr([(1.5, -0.2, 0.3)])
        gltf = self.load(stage)
        np.testing.assert_allclose(self.colors(gltf), [[1, 0, 0.3]] * 4, rtol=1e-6)
        self.assertIn("its displayColor goes from -0.2 to 1.5", self.said()["usd-material-value"])

    def test_a_face_in_two_subsets_is_drawn_once(self):
        stage = self.stage()
        mesh = quad(stage, "/leaf")
        for name in "ab":
            api = UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim())
            subset = api.CreateMaterialBindSubset(name, [0])
            UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(self.surface(stage, f"/{name}"))
        gltf = self.load(stage)
        self.assertEqual(len(gltf.document.raw["meshes"][0]["primitives"]), 1)
        self.assertIn("/leaf/b: has faces of a subset before it", self.said()["usd-primvar"])

    def test_subsets_show_them_as_their_materials_say(self):
        stage = self.stage()
        mesh = quad(stage, "/leaf")
        mesh.CreateDisplayColorAttr([(0.1, 0.2, 0.3)])
        faces = len(mesh.GetFaceVertexCountsAttr().Get())
        subset = UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).CreateMaterialBindSubset(
            "all", list(range(faces))
        )
        painted = self.surface(stage, diffuseColor=(0.5, 0.5, 0.5))
        UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(painted)
        attributes = self.load(stage).document.raw["meshes"][0]["primitives"][0]["attributes"]
        self.assertNotIn("COLOR_0", attributes)

    def test_a_material_may_read_them(self):
        stage = self.stage()
        reader = UsdShade.Shader.Define(stage, "/reader")
        reader.CreateIdAttr("UsdPrimvarReader_float3")
        reader.CreateInput("varname", TYPES.String).Set("displayColor")
        material = UsdShade.Material.Define(stage, "/m")
        shader = UsdShade.Shader.Define(stage, "/m/s")
        shader.CreateIdAttr("UsdPreviewSurface")
        shader.CreateInput("diffuseColor", TYPES.Color3f).ConnectToSource(
            reader.CreateOutput("result", TYPES.Float3)
        )
        material.CreateSurfaceOutput().ConnectToSource(shader.CreateOutput("surface", TYPES.Token))
        mesh = quad(stage, "/leaf")
        mesh.CreateDisplayColorAttr([(0.1, 0.2, 0.3)])
        UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(material)
        gltf = self.load(stage)
        np.testing.assert_allclose(self.colors(gltf), [[0.1, 0.2, 0.3]] * 4, rtol=1e-6)
        base = gltf.document.raw["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"]
        self.assertEqual(base, [1.0] * 4)
        self.assertEqual(self.imported.lost, [])


class Changes(SurfaceCase):
    def test_a_colour_that_changes_is_animated(self):
        gltf = self.case("K_animated_material")
        channels = gltf.document.raw["animations"][0]["channels"]
        pointers = [
            channel["target"]["extensions"]["KHR_animation_pointer"]["pointer"] for channel in channels
        ]
        self.assertEqual(pointers, ["/materials/0/pbrMetallicRoughness/baseColorFactor"])
        self.assertEqual(self.imported.lost, [])

    @needs_program
    def test_as_rendered(self):
        self.case("K_animated_material")
        pictures = {
            frame: self.picture(frame, "32x18", 4)[8:10, 15:17].mean(axis=(0, 1)) for frame in (1, 10)
        }
        self.assertGreater(pictures[1][0], 4 * pictures[1][2])
        self.assertGreater(pictures[10][2], 4 * pictures[10][0])

    def test_emission_that_changes(self):
        stage = self.stage()
        material = self.surface(stage, emissiveColor=(0.0, 0.0, 0.0))
        shader = UsdShade.Shader(stage.GetPrimAtPath("/m/surface"))
        for code, value in ((1, 0.0), (5, 8.0)):
            shader.GetInput("emissiveColor").Set((value, value, value), code)
        found = self.shown(stage, material)
        self.assertEqual(found["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"], 8.0)
        channel = self.gltf.document.raw["animations"][0]["channels"][0]
        self.assertEqual(
            channel["target"]["extensions"]["KHR_animation_pointer"]["pointer"], "/materials/0/emissiveFactor"
        )

    def test_what_cannot_change_is_said(self):
        stage = self.stage()
        material = self.surface(stage, ior=1.4)
        for code, value in ((1, 1.4), (5, 1.6)):
            UsdShade.Shader(stage.GetPrimAtPath("/m/surface")).GetInput("ior").Set(value, code)
        self.shown(stage, material)
        self.assertIn("ior that changes over time", self.said()["usd-material-input"])


if __name__ == "__main__":
    unittest.main()
