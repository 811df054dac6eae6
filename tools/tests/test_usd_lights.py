"""Lights of stages, against what UsdLux says they emit."""

import math
import unittest
from pathlib import Path

import numpy as np
from PIL import Image
from pxr import Sdf, UsdGeom, UsdLux, UsdShade

from sunfleck_tools.exr.decode import decode
from sunfleck_tools.gltf.container import Container
from sunfleck_tools.gltf.lights import LUMENS_PER_WATT
from sunfleck_tools.gltf.scene import Gltf
from sunfleck_tools.srgb import linear_from_srgb
from sunfleck_tools.usd import import_usd

from .test_usd_export import needs_program
from .test_usd_import import ImportCase, program, quad
from .test_validation import run

CASES = Path(__file__).parent / "data/usd"


class LookCase(ImportCase):
    def case(self, name: str) -> Gltf:
        """One of the small stages in `data/usd`."""
        target = self.folder / "case.glb"
        self.imported = import_usd(CASES / f"{name}.usda", target)
        return Gltf(Container(target))

    def said(self) -> dict[str, str]:
        """What was lost, by id."""
        return {loss.kind: loss.sentence for loss in self.imported.lost}

    def picture(self, frame: int = 1, size: str = "160x90", samples: int = 16) -> np.ndarray:
        """The last stage as the renderer sees it, by the direct light of its own lights: rows of RGB."""
        glb = self.folder / ("case.glb" if (self.folder / "case.glb").exists() else "made.glb")
        out = self.folder / f"{glb.stem}_{frame}.exr"
        flags = f"--frames {frame} --size {size} --samples {samples} --threads 1 --default-light off --bounces 0"
        program("render", glb, *flags.split(), "--out", out)
        channels = decode(out)
        return np.stack([np.float64(channels[each]) for each in "RGB"], axis=-1)


def punctual(gltf: Gltf) -> dict[str, dict]:
    """Lights of KHR_lights_punctual by name."""
    return {
        light["name"]: light for light in gltf.document.raw["extensions"]["KHR_lights_punctual"]["lights"]
    }


def of_node(gltf: Gltf, name: str) -> dict:
    """`sunfleck_light` of a node."""
    return next(node.extras.raw for node in gltf.nodes if node.name == name)["sunfleck_light"]


class Sizes(LookCase):
    def test_a_scaled_sphere_is_a_larger_one(self):
        gltf = self.case("U2_scaled_sphere")
        for name in ("Radius2", "Radius1Scale2"):
            # Radiance 1 of a disc of radius 2.
            self.assertAlmostEqual(punctual(gltf)[name]["intensity"] / LUMENS_PER_WATT, 4 * math.pi, 6)
            self.assertAlmostEqual(of_node(gltf, name)["radius"], 2.0, 6)

    @needs_program
    def test_both_light_a_wall_alike(self):
        for name in ("U2_scaled_sphere", "U_cm_normalize"):
            self.case(name)
            picture = self.picture(samples=64)
            left, right = picture[:, :80].mean(), picture[:, 80:].mean()
            self.assertGreater(left, 1e-4)
            self.assertAlmostEqual(left / right, 1.0, delta=0.02)

    def test_a_normalised_light_is_divided_by_its_area_in_units_of_the_stage(self):
        gltf = self.case("U_cm_normalize")
        for name in ("SameRadiance", "SameRadianceNormalized"):
            # A square metre of radiance 1.
            self.assertAlmostEqual(of_node(gltf, name)["power_w"], math.pi, 6)

    def test_what_stands_above_a_light_scales_it(self):
        """In centimetres, below a node of scale 3 that grows to 6: power grows with the area unless
        it is normalised."""
        for is_normalized, expected in ((False, (1.0, 4.0)), (True, (1.0, 1.0))):
            stage = self.stage()
            UsdGeom.SetStageMetersPerUnit(stage, 0.01)
            above = UsdGeom.Xform.Define(stage, "/above").AddScaleOp()
            above.Set((3, 3, 3), 1)
            above.Set((6, 6, 6), 5)
            quad(stage, "/above/leaf")
            for kind in (UsdLux.SphereLight, UsdLux.DiskLight):
                light = kind.Define(stage, f"/above/{kind.__name__}")
                light.CreateRadiusAttr(10.0)
                light.CreateIntensityAttr(5.0)
                light.CreateNormalizeAttr(is_normalized)
            gltf = self.load(stage)
            times = gltf.settings.seconds(np.array([1, 5]))
            sphere_area, disc_area = 4 * math.pi * 30.0**2, math.pi * 30.0**2
            # Radiance times area times pi, in m2.
            sphere = math.pi * 5e-4 * (1 if is_normalized else sphere_area)
            disc = math.pi * 5e-4 * (1 if is_normalized else disc_area)
            for name, watts in (("SphereLight", sphere), ("DiskLight", disc)):
                control = gltf.control(name, "sunfleck_light.power_w")
                found = control.at(times)[:, 0] if control else np.full(2, self.watts(gltf, name))
                np.testing.assert_allclose(found, watts * np.array(expected), rtol=1e-5)
            radius = gltf.control("SphereLight", "sunfleck_light.radius").at(times)[:, 0]
            np.testing.assert_allclose(radius, [0.3, 0.6], rtol=1e-6)

    def watts(self, gltf: Gltf, name: str) -> float:
        lights = punctual(gltf)
        return (
            lights[name]["intensity"] / LUMENS_PER_WATT * 4 * math.pi
            if name in lights
            else of_node(gltf, name)["power_w"]
        )

    def test_instances_of_a_light_have_their_own_sizes(self):
        stage = self.stage()
        instancer = UsdGeom.PointInstancer.Define(stage, "/crowd")
        instancer.AddScaleOp().Set((2, 2, 2))
        lamp = UsdLux.SphereLight.Define(stage, "/crowd/lamp")
        lamp.CreateRadiusAttr(0.5)
        lamp.CreateIntensityAttr(2.0)
        instancer.CreatePrototypesRel().SetTargets(["/crowd/lamp"])
        instancer.CreateProtoIndicesAttr([0, 0])
        instancer.CreatePositionsAttr([(0, 0, 0), (3, 0, 0)])
        instancer.CreateScalesAttr([(1, 1, 1), (3, 3, 3)])
        lights = self.load(stage).document.raw["extensions"]["KHR_lights_punctual"]["lights"]
        found = [light["intensity"] / LUMENS_PER_WATT for light in lights]
        # Spheres of radius 1 and 3 m.
        np.testing.assert_allclose(found, [2 * math.pi, 18 * math.pi], rtol=1e-5)

    def test_a_stretched_sphere_and_a_cylinder_send_out_as_much(self):
        stage = self.stage()
        sphere = UsdLux.SphereLight.Define(stage, "/sphere")
        sphere.CreateRadiusAttr(1.0)
        sphere.CreateIntensityAttr(2.0)
        # As good as a disc with two sides, each of radius 1.
        sphere.AddScaleOp().Set((1, 1, 1e-4))
        cylinder = UsdLux.CylinderLight.Define(stage, "/cylinder")
        cylinder.CreateRadiusAttr(0.25)
        cylinder.CreateLengthAttr(4.0)
        cylinder.CreateIntensityAttr(3.0)
        lights = punctual(self.load(stage))
        # pi L A watts over 4 pi steradians.
        self.assertAlmostEqual(
            lights["sphere"]["intensity"] / LUMENS_PER_WATT / (2.0 * 2 * math.pi / 4), 1.0, delta=0.011
        )
        self.assertAlmostEqual(
            lights["cylinder"]["intensity"] / LUMENS_PER_WATT, 3.0 * (2 * math.pi * 0.25 * 4.0) / 4, 5
        )
        self.assertEqual({loss.kind: loss.count for loss in self.imported.lost}, {"usd-light-shape": 2})

    @needs_program
    def test_irradiance_below_a_sphere_in_centimetres(self):
        """A wall in the light of a sphere of radius 0.3 m, 2 m away: pi L (r / d)^2, of which a matte wall
        gives back albedo / pi."""
        stage = self.stage()
        UsdGeom.SetStageMetersPerUnit(stage, 0.01)
        wall = quad(stage, "/wall")
        wall.GetPointsAttr().Set([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)])
        wall.AddScaleOp().Set((1, 1, 1))
        material = UsdShade.Material.Define(stage, "/m")
        shader = UsdShade.Shader.Define(stage, "/m/s")
        shader.CreateIdAttr("UsdPreviewSurface")
        shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set((0.5, 0.5, 0.5))
        shader.CreateInput("ior", Sdf.ValueTypeNames.Float).Set(1.0)
        material.CreateSurfaceOutput().ConnectToSource(
            shader.CreateOutput("surface", Sdf.ValueTypeNames.Token)
        )
        UsdShade.MaterialBindingAPI.Apply(wall.GetPrim()).Bind(material)
        light = UsdLux.SphereLight.Define(stage, "/light")
        light.CreateRadiusAttr(15.0)
        light.CreateIntensityAttr(10.0)
        light.AddTranslateOp().Set((0, 0, 200))
        light.AddScaleOp().Set((2, 2, 2))
        camera = UsdGeom.Camera.Define(stage, "/camera")
        camera.CreateFocalLengthAttr(2000.0)
        camera.AddTranslateOp().Set((0, 0, 40))
        self.load(stage)
        expected = 0.5 / math.pi * math.pi * 10 * (0.3 / 2) ** 2
        found = self.picture(size="16x9", samples=1024)
        self.assertAlmostEqual(found.mean() / expected, 1.0, delta=0.02)


class Suns(LookCase):
    def test_irradiance(self):
        for angle, is_normalized, expected in (
            (1.0, False, 1000 * math.pi * math.sin(math.radians(0.5)) ** 2),
            (1.0, True, 1000.0),
            (0.0, False, 1000.0),
            # All that comes from the half space before the plane.
            (360.0, False, 1000 * math.pi),
        ):
            stage = self.stage()
            UsdGeom.SetStageMetersPerUnit(stage, 0.01)
            sun = UsdLux.DistantLight.Define(stage, "/sun")
            sun.CreateAngleAttr(angle)
            sun.CreateIntensityAttr(1000.0)
            sun.CreateNormalizeAttr(is_normalized)
            sun.AddScaleOp().Set((7, 7, 7))
            found = punctual(self.load(stage))["sun"]["intensity"] / LUMENS_PER_WATT
            self.assertAlmostEqual(found / expected, 1.0, 6)
            self.assertEqual("usd-light-shape" in self.said(), angle == 360)


class Kept(LookCase):
    @needs_program
    def test_suns_keep_their_discs_and_what_the_renderer_leaves_out_is_a_note(self):
        """Of a scene of our own there and back: UsdLux has no limb, glTF no mist."""
        source, stage, back = (self.folder / name for name in ("sun.ron", "sun.usda", "back.glb"))
        sun = "to_sun: (0, 0.2, -1), irradiance_w_per_m2: 3.0, angular_diameter_deg: 20, limb_darkening: 0.6"
        fog = "min_m: (-3, 0, -3), max_m: (3, 3, 3), density_per_m: 0.2, mist: (size_m: 2)"
        source.write_text(
            f'Scene(version: 1, meshes: {{ "q": Quad(size_m: 4) }}, objects: {{ "q": (mesh: "q") }}, '
            f'cameras: {{ "main": () }}, lights: {{ "sun": Sun({sun}) }}, fog: {{ "bank": ({fog}) }})'
        )
        code, _, err = run("export-usd", source, stage)
        self.assertEqual((code, err.count("mist is not carried by glTF")), (0, 1), err)
        import_usd(stage, back)
        self.assertEqual(of_node(Gltf(Container(back)), "sun")["limb_darkening"], 0.6)


class Inputs(LookCase):
    def test_a_temperature_that_is_none(self):
        gltf = self.case("T_temp_nan")
        self.assertIn("/World/L: its colorTemperature is not finite", self.said()["usd-light-value"])
        self.assertEqual(punctual(gltf)["World"]["color"], [1.0, 1.0, 1.0])

    def test_temperatures_tint(self):
        stage = self.stage()
        for name, kelvin in (("warm", 2000.0), ("cold", 1e9)):
            light = UsdLux.SphereLight.Define(stage, f"/{name}")
            light.CreateEnableColorTemperatureAttr(True)
            light.CreateColorTemperatureAttr(kelvin)
        lights = punctual(self.load(stage))
        expected = np.array(UsdLux.BlackbodyTemperatureAsRgb(2000.0))
        np.testing.assert_allclose(lights["warm"]["color"], expected / expected.max(), rtol=1e-6)
        self.assertGreater(lights["cold"]["color"][2], lights["cold"]["color"][0])
        self.assertIn("from 1000 to 10000 K", self.said()["usd-light-value"])

    def test_what_is_not_carried_is_said(self):
        gltf = self.case("E_rect_shaping_texture")
        counts = {loss.kind: loss.count for loss in self.imported.lost}
        # Its picture, its shadows, its cone.
        self.assertEqual(counts, {"usd-light-input": 3})
        # The mean of the picture: one colour in sRGB.
        encoded = np.array([200, 100, 50]) / 255
        mean = ((encoded + 0.055) / 1.055) ** 2.4
        ours = of_node(gltf, "L")
        np.testing.assert_allclose(np.array(ours["color"]) * ours["power_w"], 3 * math.pi * mean, rtol=1e-5)

    def test_numbers_that_are_none(self):
        stage = self.stage()
        light = UsdLux.RectLight.Define(stage, "/light")
        light.CreateIntensityAttr(float("nan"))
        light.CreateColorAttr((float("inf"), 1, -1))
        light.CreateWidthAttr(-1.0)
        ours = of_node(self.load(stage), "light")
        self.assertTrue(np.isfinite(ours["power_w"]))
        self.assertEqual({loss.kind for loss in self.imported.lost}, {"usd-light-value"})

    def test_a_light_without_a_size_keeps_its_power(self):
        stage = self.stage()
        light = UsdLux.SphereLight.Define(stage, "/light")
        light.CreateRadiusAttr(0.0)
        light.CreateIntensityAttr(4.0)
        light.CreateNormalizeAttr(True)
        found = punctual(self.load(stage))["light"]["intensity"] / LUMENS_PER_WATT
        self.assertAlmostEqual(found, 1.0, 5)

    def test_inputs_of_other_types_are_passed_over(self):
        for kind in ("SphereLight", "RectLight", "DistantLight", "DomeLight", "CylinderLight"):
            stage = self.stage()
            quad(stage, "/leaf")
            stage.DefinePrim("/light", kind)
            spec = stage.GetRootLayer().GetPrimAtPath("/light")
            names = (
                "intensity",
                "exposure",
                "color",
                "radius",
                "width",
                "angle",
                "length",
                "normalize",
                "shaping:cone:angle",
            )
            for name in names:
                Sdf.AttributeSpec(spec, f"inputs:{name}", Sdf.ValueTypeNames.String).default = "bright"
            self.load(stage)
            self.assertIn("usd-light-value", self.said(), kind)

    def test_a_spot_fades_over_the_angles_that_it_says(self):
        stage = self.stage()
        light = UsdLux.SphereLight.Define(stage, "/light")
        shaping = UsdLux.ShapingAPI.Apply(light.GetPrim())
        shaping.CreateShapingConeAngleAttr(40.0)
        shaping.CreateShapingConeSoftnessAttr(0.5)
        spot = punctual(self.load(stage))["light"]["spot"]
        outer = spot["outerConeAngle"]
        self.assertAlmostEqual(math.degrees(outer), 40.0, 5)
        # The renderer fades from cos(outer) + blend (1 - cos(outer)) on: here from 20 degrees.
        blend = 1 - spot["innerConeAngle"] / outer
        self.assertAlmostEqual(math.cos(outer) + blend * (1 - math.cos(outer)), math.cos(math.radians(20)), 5)

    @needs_program
    def test_a_light_that_is_invisible_does_not_shine(self):
        self.case("O_invisible_light")
        self.assertEqual(self.picture(size="32x18", samples=1).max(), 0)


class MeshLights(LookCase):
    def test_a_mesh_is_seen_to_shine(self):
        gltf = self.case("F_mesh_light")
        self.assertIn("indirect light alone", self.said()["usd-mesh-light"])
        material = gltf.document.raw["materials"][0]
        strength = material["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"]
        np.testing.assert_allclose(np.array(material["emissiveFactor"]) * strength, [50.0] * 3)

    @needs_program
    def test_as_bright_as_its_radiance(self):
        self.case("F_mesh_light")
        self.assertAlmostEqual(self.picture(size="32x18", samples=1)[8:10, 15:17].mean(), 50.0, 3)

    def test_normalised_by_its_area(self):
        stage = self.stage()
        mesh = quad(stage, "/mesh")
        mesh.AddScaleOp().Set((2, 3, 1))
        api = UsdLux.MeshLightAPI.Apply(mesh.GetPrim())
        UsdLux.LightAPI(api).CreateIntensityAttr(3.0)
        UsdLux.LightAPI(api).CreateNormalizeAttr(True)
        material = self.load(stage).document.raw["materials"][0]
        np.testing.assert_allclose(material["emissiveFactor"], [0.5] * 3)


class Blenders(LookCase):
    def test_watts_are_the_same_in_any_unit(self):
        """As Blender 5.3 writes a point of 100 W and a rectangle of 50 W: intensities do not follow the unit."""
        for unit in (1.0, 0.01, 0.0254):
            stage = self.stage()
            stage.GetRootLayer().documentation = "Blender v5.3.0"
            UsdGeom.SetStageMetersPerUnit(stage, unit)
            UsdGeom.Xform.Define(stage, "/root").AddScaleOp().Set((1 / unit,) * 3)
            point = UsdLux.SphereLight.Define(stage, "/root/point")
            point.CreateRadiusAttr(0.1)
            area = UsdLux.RectLight.Define(stage, "/root/area")
            for light, intensity in ((point, 31.830988), (area, 15.915494)):
                light.CreateNormalizeAttr(True)
                light.CreateIntensityAttr(intensity)
            gltf = self.load(stage)
            power = 4 * math.pi * punctual(gltf)["point"]["intensity"] / LUMENS_PER_WATT
            self.assertAlmostEqual(power, 100.0, 3)
            self.assertAlmostEqual(of_node(gltf, "area")["power_w"], 50.0, 3)


class Domes(LookCase):
    def test_the_second_schema_and_its_pole(self):
        """A dome whose pole is z in a stage whose up is z is upright as it is; longitude 0 points to -y
        there, +z in glTF."""
        stage = self.stage()
        UsdGeom.SetStageUpAxis(stage, "Z")
        quad(stage, "/a")
        Image.new("RGB", (4, 2), "white").save(self.folder / "sky.png")
        dome = UsdLux.DomeLight_1.Define(stage, "/dome")
        dome.CreateTextureFileAttr("./sky.png")
        dome.CreateIntensityAttr(2.0)
        sky = self.load(stage).extras.raw["sunfleck_env"]
        # +z of the picture's middle is +z in glTF, and half a turn from the sky's own -z.
        self.assertAlmostEqual(abs(sky["rotation"]), math.pi, 6)
        self.assertEqual(sky["strength"], [2.0] * 3)
        self.assertEqual(self.imported.lost, [])

    def test_a_tilted_dome_has_the_mean_of_its_picture(self):
        """Blender writes a plain sky as a picture of one texel, in a stage whose up is z."""
        for colors, is_lost in (([(51, 128, 255)], False), ([(255, 255, 255), (0, 0, 0)], True)):
            stage = self.stage()
            UsdGeom.SetStageUpAxis(stage, "Z")
            quad(stage, "/a")
            picture = Image.new("RGB", (1, len(colors)))
            picture.putdata(colors)
            picture.save(self.folder / "sky.png")
            dome = UsdLux.DomeLight.Define(stage, "/dome")
            dome.CreateTextureFileAttr("./sky.png")
            dome.CreateIntensityAttr(2.0)
            sky = self.load(stage).extras.raw["sunfleck_env"]
            mean = np.mean([linear_from_srgb(np.array(color) / 255) for color in colors], axis=0)
            np.testing.assert_allclose(sky["color"], 2.0 * mean, rtol=1e-5)
            self.assertEqual("usd-dome-picture" in self.said(), is_lost)

    def sky(self, name: str, form: str) -> dict:
        """`sunfleck_env` of a dome with a picture that is not carried."""
        stage = self.stage()
        quad(stage, "/a")
        dome = UsdLux.DomeLight.Define(stage, "/dome")
        dome.CreateTextureFileAttr(f"./{name}")
        dome.CreateTextureFormatAttr(form)
        return self.load(stage).extras.raw["sunfleck_env"]

    def test_means_of_balls_and_crosses_are_over_the_sphere(self):
        """Of light from the half in front, and of a cross whose faces are white."""
        y, x = (np.mgrid[:128, :128] + 0.5) / 64 - 1
        for form, lit, mean in (
            ("angular", np.hypot(x, y) < 0.5, 0.5),
            ("mirroredBall", np.hypot(x, y) < math.sqrt(0.5), 0.5),
            ("cubeMapVerticalCross", (abs(x) < 1 / 3) | (abs(y + 0.25) < 0.25), 1.0),
        ):
            Image.fromarray(np.uint8(lit) * 255).convert("RGB").save(self.folder / "sky.png")
            np.testing.assert_allclose(self.sky("sky.png", form)["color"], [mean] * 3, atol=0.01)
            self.assertIn("its mean is", self.said()["usd-dome-picture"])

    def test_a_picture_that_cannot_be_read_has_no_mean(self):
        (self.folder / "sky.png").write_bytes(b"no picture")
        self.assertEqual(self.sky("sky.png", "angular")["color"], [1.0] * 3)
        self.assertIn("the sky has its colour alone", self.said()["usd-texture"])
        self.assertNotIn("usd-dome-picture", self.said())

    def test_texels_that_are_not_finite_have_a_finite_mean(self):
        Image.fromarray(np.array([[1.0, math.nan, math.inf, -math.inf]], np.float32)).save(self.folder / "sky.tif")
        self.assertTrue(np.isfinite(self.sky("sky.tif", "angular")["color"]).all())

    def test_one_sky_is_all_there_is(self):
        stage = self.stage()
        quad(stage, "/a")
        for name, value in (("first", 1.0), ("second", 2.0)):
            UsdLux.DomeLight.Define(stage, f"/{name}").CreateIntensityAttr(value)
        self.assertEqual(self.load(stage).extras.raw["sunfleck_env"]["color"], [1.0] * 3)
        self.assertIn("/second", self.said()["usd-dome-second"])


if __name__ == "__main__":
    unittest.main()
