"""`import-usd`: there and back again, what other programs write, and what nobody should."""

import subprocess
import unittest
from pathlib import Path

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade, UsdSkel, Vt

from sunfleck_tools import SceneError
from sunfleck_tools.exr.decode import decode
from sunfleck_tools.gltf.container import Container
from sunfleck_tools.gltf.deformation import Bending
from sunfleck_tools.gltf.meshes import Meshes
from sunfleck_tools.gltf.scene import Gltf
from sunfleck_tools.usd import ExportOptions, export_usd, import_usd
from sunfleck_tools.usd.materials import NOT_CARRIED
from sunfleck_tools.usd.reading.triangles import triangulate

from .files import marked_sky
from .test_usd_export import PROGRAM, SAMPLES, Case, inspect, needs_program

CLEARING = Path(__file__).parent / "data/clearing.ron"
ROUTES = [
    ExportOptions(for_blender, point_instancer)
    for for_blender in (False, True)
    for point_instancer in (False, True)
]
QUAD = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]


def program(*command: object) -> None:
    """Runs sunfleck."""
    subprocess.run([PROGRAM, *map(str, command)], check=True, capture_output=True)


def quad(stage: Usd.Stage, path: str) -> UsdGeom.Mesh:
    """A square."""
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr(QUAD)
    mesh.CreateFaceVertexCountsAttr([4])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    mesh.CreateSubdivisionSchemeAttr("none")
    return mesh


class ImportCase(Case):
    def stage(self) -> Usd.Stage:
        """A stage that is saved by `load`."""
        stage = Usd.Stage.CreateNew(str(self.folder / f"made_{len(list(self.folder.iterdir()))}.usda"))
        UsdGeom.SetStageMetersPerUnit(stage, 1.0)
        UsdGeom.SetStageUpAxis(stage, "Y")
        stage.SetStartTimeCode(1)
        stage.SetEndTimeCode(5)
        return stage

    def load(self, stage: Usd.Stage) -> Gltf:
        stage.GetRootLayer().Save()
        target = self.folder / "made.glb"
        self.imported = import_usd(stage.GetRootLayer().realPath, target)
        return Gltf(Container(target))

    def refused(self, stage: Usd.Stage) -> str:
        with self.assertRaises(SceneError) as caught:
            self.load(stage)
        return str(caught.exception)


class ThereAndBack(Case):
    @needs_program
    def test_everything_is_where_and_as_bright_as_it_was(self):
        for name in (
            "a_leaves40_scene",
            "d_skin",
            "h_cameras",
            "h_lights_nopointer",
            "h_transforms_scene",
            "i_conventions_nopointer",
        ):
            source = SAMPLES / f"{name}.glb"
            expected = inspect(source, [1.0, 2.5, 17.0, 24.0])
            for number, options in enumerate(ROUTES):
                stage, back = self.folder / f"{name}_{number}.usdc", self.folder / "back.glb"
                export_usd(source, stage, options)
                import_usd(stage, back)
                found = inspect(back, list(expected))
                for frame, truth in expected.items():
                    self.compare(truth, found[frame], f"{name}, {options}, frame {frame}")

    @needs_program
    def test_the_picture_is_the_same(self):
        glb, back = self.folder / "leaves.glb", self.folder / "back.glb"
        program("export", CLEARING, glb, "--frames", "24-24", "--fps", 24)
        expected = self.picture(glb)
        for options in ROUTES:
            stage = self.folder / f"leaves_{options.for_blender}_{options.point_instancer}.usdc"
            export_usd(glb, stage, options)
            import_usd(stage, back)
            self.assertLess(np.abs(self.picture(back) - expected).mean(), 1e-3 * expected.mean())

    @needs_program
    def test_the_picture_of_a_dome_is_the_sky(self):
        """As the dome alone has it: without what the renderer's own words say of the sky."""
        marked_sky(self.folder / "marked.exr")
        source, glb, back = (self.folder / name for name in ("sky.ron", "sky.glb", "back.glb"))
        camera = '"main": (position_m: (0, 0.5, 0), look_at_m: (1, 0.6, 0.3), fov_deg: 60)'
        sky = 'image: "marked.exr", rotation_deg: 20, strength_w_per_m2_sr: (2, 1, 0.5), lights: Surfaces'
        ground = 'meshes: { "ground": Quad(size_m: 4) }, objects: { "ground": (mesh: "ground") }'
        source.write_text(f"Scene(version: 1, {ground}, cameras: {{ {camera} }}, sky: Image({sky}))")
        program("export", source, glb, "--frames", "24-24")
        stage = self.export(glb)
        world = stage.GetPrimAtPath("/World")
        for name in [name for name in world.GetPropertyNames() if "sunfleck_env" in name]:
            world.RemoveProperty(name)
        stage.GetRootLayer().Save()
        import_usd(stage.GetRootLayer().realPath, back)
        expected, found = self.picture(glb, 0), self.picture(back, 0)
        self.assertGreater(np.ptp(expected[0]), 0.3)
        # Seen exactly; what falls from it on the ground is sampled.
        self.assertLess(np.abs(found - expected)[:, :10].max(), 1e-3)
        np.testing.assert_allclose(found.mean(axis=(1, 2)), expected.mean(axis=(1, 2)), rtol=0.02)

    def picture(self, path: Path, bounces: int | str = "all") -> np.ndarray:
        """A small frame: leaves with textures and light through them, a sun, fog and a sky."""
        out = self.folder / f"{path.stem}.exr"
        flags = f"--frames 24 --size 48x27 --samples 4 --threads 1 --bounces {bounces}"
        program("render", path, *flags.split(), "--out", out)
        channels = decode(out)
        return np.float32([channels[each] for each in "RGB"])

    def compare(self, truth: dict, found: dict, what: str):
        for key, node in truth["nodes"].items():
            # Nodes that only carry values are made anew; a skin's place does not count.
            if not key.startswith("ctl_") and key in found["nodes"] and node["visible"]:
                self.near(found["nodes"][key]["world"], node["world"], f"{what}: {key}")
        shown = [key for key in truth["nodes"] if not key.startswith("ctl_")]
        self.assertGreaterEqual(len([key for key in shown if key in found["nodes"]]), 0.9 * len(shown), what)
        for key, camera in truth["cameras"].items():
            self.near(found["cameras"][key]["projection"], camera["projection"], f"{what}: {key}")
        self.assertEqual(truth["lights"].keys(), found["lights"].keys(), what)
        for key, light in truth["lights"].items():
            self.assertEqual(light["kind"], found["lights"][key]["kind"])
            for field, value in light.items():
                if field not in ("kind", "world", "visible_to_camera"):
                    self.near(found["lights"][key][field], value, f"{what}: {field} of {key}")

    def near(self, found, expected, what: str):
        found, expected = np.ravel(found), np.ravel(expected)
        self.assertLessEqual(np.abs(found - expected).max(), 1e-5 * max(1.0, np.abs(expected).max()), what)

    @needs_program
    def test_materials_come_back(self):
        clearing = self.folder / "clearing.glb"
        program("export", CLEARING, clearing)
        for source in (
            clearing,
            *(
                SAMPLES / f"{name}.glb"
                for name in ("b_leafcards", "g_pbr", "f_plain", "i_conventions_nopointer")
            ),
        ):
            stage, back = self.folder / f"{source.stem}.usdz", self.folder / "back.glb"
            export_usd(source, stage)
            import_usd(stage, back)
            old, new = (self.materials(path) for path in (source, back))
            for material in new:
                self.assertIn(material, old, source.stem)

    def materials(self, path: Path) -> list[tuple]:
        """What must be the same of materials, to five digits."""
        found = []
        for source in Container(path).document.raw.get("materials", []):
            pbr, mode = source.get("pbrMetallicRoughness", {}), source.get("alphaMode", "OPAQUE")
            alpha = 4 if mode != "OPAQUE" else 3
            extras = source.get("extras", {})
            found.append(
                (
                    np.round(pbr.get("baseColorFactor", [1.0] * 4)[:alpha], 5).tolist(),
                    np.round([pbr.get("roughnessFactor", 1.0), pbr.get("metallicFactor", 1.0)], 5).tolist(),
                    mode,
                    round(source.get("alphaCutoff", 0.5), 5) if mode == "MASK" else None,
                    ["baseColorTexture" in pbr, "metallicRoughnessTexture" in pbr, "normalTexture" in source],
                    np.round(source.get("emissiveFactor", [0.0] * 3), 5).tolist(),
                    [str(extras.get(name)) for name in ("sunfleck_leaf", "sunfleck_material")],
                    [str(source.get("extensions", {}).get(name)) for name in NOT_CARRIED],
                )
            )
        return found

    def test_what_bends_still_does(self):
        for name in ("c_morph", "d_skin"):
            stage, back = self.folder / f"{name}.usdc", self.folder / "back.glb"
            export_usd(SAMPLES / f"{name}.glb", stage)
            import_usd(stage, back)
            old, new = (self.extents(Gltf(Container(path))) for path in (SAMPLES / f"{name}.glb", back))
            self.assertEqual(len(old), len(new))
            for before, after in zip(old, new):
                np.testing.assert_allclose(before, after, atol=1e-5)

    def extents(self, gltf: Gltf) -> list[np.ndarray]:
        """The box of each mesh that bends, at every fifth frame."""
        found = []
        times = gltf.settings.seconds(np.arange(1, 48, 5))
        meshes = Meshes(gltf, [])
        for node in gltf.nodes:
            if meshes.of(node) is None:
                continue
            mesh = meshes.of(node)[1]
            bending = Bending(gltf, node, mesh)
            if not bending.is_skinned and not mesh.primitives[0].targets:
                continue
            points = bending.positions(mesh.primitives[0], times)
            if not bending.is_skinned:
                world = node.world_from_node(times)
                points = np.einsum("tij,tvj->tvi", world[:, :3, :3], points) + world[:, None, :3, 3]
            found.append(np.stack([points.min(axis=1), points.max(axis=1)]))
        return sorted(found, key=lambda box: box[0, 0].tolist())


class OtherPrograms(ImportCase):
    def test_axes_and_units(self):
        stage = self.stage()
        UsdGeom.SetStageUpAxis(stage, "Z")
        UsdGeom.SetStageMetersPerUnit(stage, 0.01)
        quad(stage, "/a").AddTranslateOp().Set((100, 0, 200))
        gltf = self.load(stage)
        node = next(node for node in gltf.nodes if node.name == "a")
        np.testing.assert_allclose(node.world_from_node(np.zeros(1))[0][:3, 3], [1, 2, 0], atol=1e-6)

    def test_frames_are_counted_at_the_stages_rate(self):
        stage = self.stage()
        stage.SetTimeCodesPerSecond(48)
        stage.SetFramesPerSecond(24)
        stage.SetStartTimeCode(2)
        stage.SetEndTimeCode(96)
        move = quad(stage, "/a").AddTranslateOp()
        move.Set((0, 0, 0), 0)
        move.Set((96, 0, 0), 96)
        gltf = self.load(stage)
        self.assertEqual((gltf.settings.first, gltf.settings.last, gltf.settings.fps), (1, 48, 24))
        place = gltf.nodes[0].world_from_node(gltf.settings.seconds(np.array([12.0])))[0][:3, 3]
        np.testing.assert_allclose(place, [24, 0, 0], atol=1e-4)

    def test_lights_as_the_specification_has_them(self):
        stage = self.stage()
        sphere = UsdLux.SphereLight.Define(stage, "/sphere")
        sphere.CreateRadiusAttr(0.5)
        sphere.CreateIntensityAttr(2.0)
        rect = UsdLux.RectLight.Define(stage, "/rect")
        rect.CreateWidthAttr(2.0)
        rect.CreateHeightAttr(3.0)
        rect.CreateExposureAttr(1.0)
        rect.AddScaleOp().Set((2, 1, 1))
        sun = UsdLux.DistantLight.Define(stage, "/sun")
        sun.CreateAngleAttr(1.0)
        sun.CreateIntensityAttr(1000.0)
        dome = UsdLux.DomeLight.Define(stage, "/dome")
        dome.CreateIntensityAttr(0.5)
        dome.CreateExposureAttr(1.0)
        dome.CreateColorAttr((0.2, 0.4, 0.6))
        gltf = self.load(stage)
        sky = gltf.extras.group("sunfleck_env")
        self.assertEqual(sky.text_at("lights"), "surfaces_and_fog")
        np.testing.assert_allclose(sky.need("color").channels(), [0.2, 0.4, 0.6], rtol=1e-6)
        lights = {
            light["name"]: light for light in gltf.document.raw["extensions"]["KHR_lights_punctual"]["lights"]
        }
        # Radiance 2 of a disc of radius 0.5.
        self.assertAlmostEqual(lights["sphere"]["intensity"] / 683, 2.0 * np.pi * 0.25, 5)
        self.assertAlmostEqual(
            lights["sun"]["intensity"] / 683, 1000 * np.pi * np.sin(np.radians(0.5)) ** 2, 5
        )
        extras = next(node.extras.raw for node in gltf.nodes if node.name == "rect")
        # Radiance 2 over 12 square metres.
        self.assertAlmostEqual(extras["sunfleck_light"]["power_w"], np.pi * 24, 4)

    def test_domes_with_pictures_stand_upright(self):
        for axis, turns, expected in (
            ("Y", [("Y", 30)], np.radians(30 - 180)),
            # As Blender writes them: a dome's pole is its y, whatever is up in the stage.
            ("Z", [("Z", 40), ("X", 90)], np.radians(40 - 180)),
            ("Y", [("X", 10)], None),
            ("Z", [], None),
        ):
            stage = self.stage()
            UsdGeom.SetStageUpAxis(stage, axis)
            quad(stage, "/a")
            marked_sky(self.folder / "marked.exr")
            dome = UsdLux.DomeLight.Define(stage, "/dome")
            dome.CreateTextureFileAttr("./marked.exr")
            for about, degrees in turns:
                getattr(dome, f"AddRotate{about}Op")().Set(degrees)
            sky = self.load(stage).extras.member("sunfleck_env")
            if expected is None:
                self.assertIsNone(sky.member("image"))
                self.assertIn("not upright", " ".join(map(str, self.imported.lost)))
            else:
                self.assertAlmostEqual(
                    np.angle(np.exp(1j * (sky.need("rotation").number() - expected))), 0.0, 6
                )
        (self.folder / "marked.exr").write_bytes(b"no picture")
        self.assertIn("neither OpenEXR nor", self.without_a_picture())
        (self.folder / "marked.exr").unlink()
        self.assertIn("cannot be read", self.without_a_picture())

    def without_a_picture(self) -> str:
        """What is said of a dome whose picture cannot be had; it is a sky of one colour."""
        stage = self.stage()
        dome = UsdLux.DomeLight.Define(stage, "/dome")
        dome.CreateTextureFileAttr("./marked.exr")
        dome.CreateIntensityAttr(2.0)
        self.assertEqual(self.load(stage).extras.raw["sunfleck_env"]["color"], [2.0] * 3)
        return " ".join(map(str, self.imported.lost))

    def test_what_changes_is_carried(self):
        stage = self.stage()
        world = UsdGeom.Xform.Define(stage, "/World").GetPrim()
        density = world.CreateAttribute("userProperties:sunfleck_fog:density", Sdf.ValueTypeNames.Double)
        lamp = UsdLux.SphereLight.Define(stage, "/World/lamp")
        lamp.CreateNormalizeAttr(True)
        camera = UsdGeom.Camera.Define(stage, "/World/camera")
        for code, value in ((1, 0.5), (5, 1.5)):
            density.Set(value, code)
            lamp.CreateIntensityAttr().Set(8 * value, code)
            camera.CreateFocalLengthAttr().Set(50 * value, code)
        gltf = self.load(stage)
        times = gltf.settings.seconds(np.array([1, 3, 5]))
        carried = {target: control.at(times)[:, 0] for target, control in gltf.controls.items()}
        np.testing.assert_allclose(carried["scene.sunfleck_fog.density"], [0.5, 1.0, 1.5], atol=1e-6)
        # A quarter of the intensity to every side.
        np.testing.assert_allclose(carried["lamp.sunfleck_light.power_w"] / (4 * np.pi), [1, 2, 3], rtol=1e-6)
        aperture = camera.GetVerticalApertureAttr().Get()
        expected = 2 * np.arctan(0.5 * aperture / np.array([25.0, 50.0, 75.0]))
        np.testing.assert_allclose(carried["camera.sunfleck_camera.yfov"], expected, rtol=1e-6)
        self.assertEqual(gltf.extras.raw["sunfleck_fog"]["density"], 0.5)

    def test_the_shutter_of_a_camera(self):
        stage = self.stage()
        stage.SetTimeCodesPerSecond(48)
        stage.SetFramesPerSecond(24)
        camera = UsdGeom.Camera.Define(stage, "/camera")
        camera.CreateShutterOpenAttr(0.0)
        camera.CreateShutterCloseAttr(1.0)
        self.assertEqual(self.load(stage).settings.shutter, (0.0, 0.5))

    def test_skeletons_are_followed(self):
        stage = self.stage()
        stage.SetTimeCodesPerSecond(30)
        root = UsdSkel.Root.Define(stage, "/root")
        mesh = quad(stage, "/root/leaf")
        skeleton = UsdSkel.Skeleton.Define(stage, "/root/bones")
        identity = Vt.Matrix4dArray([Gf.Matrix4d(1)])
        skeleton.CreateJointsAttr(["joint"])
        skeleton.CreateBindTransformsAttr(identity)
        skeleton.CreateRestTransformsAttr(identity)
        animation = UsdSkel.Animation.Define(stage, "/root/bones/motion")
        animation.CreateJointsAttr(["joint"])
        animation.CreateRotationsAttr([Gf.Quatf(1)])
        animation.CreateScalesAttr([Gf.Vec3h(1)])
        moves = animation.CreateTranslationsAttr()
        for code in (1, 5):
            moves.Set([Gf.Vec3f(code - 1, 0, 0)], code)
        UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().SetTargets(
            [animation.GetPath()]
        )
        binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
        binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
        binding.CreateJointIndicesPrimvar(False, 1).Set([0] * 4)
        binding.CreateJointWeightsPrimvar(False, 1).Set([1.0] * 4)
        self.assertTrue(root)
        gltf = self.load(stage)
        node = next(node for node in gltf.nodes if node.source.raw.get("mesh") is not None)
        meshes = Meshes(gltf, [])
        bending = Bending(gltf, node, meshes.of(node)[1])
        for frame, expected in ((1, 0.0), (2.5, 1.5), (5, 4.0)):
            points = bending.positions(bending.mesh.primitives[0], gltf.settings.seconds(np.array([frame])))[0]
            self.assertAlmostEqual(points[:, 0].min(), expected, 5)

    def test_faces_have_materials_and_corners_of_their_own(self):
        stage = self.stage()
        mesh = quad(stage, "/leaf")
        mesh.GetPointsAttr().Set([*QUAD, (2, 0, 0), (2, 1, 0)])
        mesh.GetFaceVertexCountsAttr().Set([4, 4])
        mesh.GetFaceVertexIndicesAttr().Set([0, 1, 2, 3, 1, 4, 5, 2])
        primvar = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
            "st", Sdf.ValueTypeNames.TexCoord2fArray, "faceVarying"
        )
        primvar.Set([(0, 0), (1, 0), (1, 1), (0, 1)] * 2)
        for index, name in enumerate(("left", "right")):
            material = UsdShade.Material.Define(stage, f"/{name}")
            shader = UsdShade.Shader.Define(stage, f"/{name}/surface")
            shader.CreateIdAttr("UsdPreviewSurface")
            shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set((index, 0.5, 0.25))
            material.CreateSurfaceOutput().ConnectToSource(
                shader.CreateOutput("surface", Sdf.ValueTypeNames.Token)
            )
            subset = UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).CreateMaterialBindSubset(
                name, Vt.IntArray([index])
            )
            UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(material)
        gltf = self.load(stage)
        _, found = Meshes(gltf, []).of(gltf.nodes[0])
        self.assertEqual([len(each.triangles) for each in found.primitives], [2, 2])
        names = [gltf.document.raw["materials"][each.material]["name"] for each in found.primitives]
        self.assertEqual(names, ["left", "right"])
        # Corners in one place with other coordinates are vertices of their own; v counts from the top.
        right = found.primitives[1]
        at = {tuple(place): tuple(uv) for place, uv in zip(right.positions.tolist(), right.uvs[0].tolist())}
        self.assertEqual(at[(1.0, 0.0, 0.0)], (0.0, 1.0))

    def test_triangles_cover_a_leaf_that_is_not_convex(self):
        star = np.array(
            [(np.cos(a) * r, np.sin(a) * r, 0.0) for a, r in zip(np.arange(16) * np.pi / 8, [1.0, 0.3] * 8)]
        )
        area = 0.5 * np.abs(np.cross(star, np.roll(star, -1, axis=0)).sum(axis=0)[2])
        for turned in (star, star[:, [1, 2, 0]], star[:, [2, 0, 1]], star[::-1]):
            triangles = triangulate(np.array([16]), turned, np.arange(16))[:, :3]
            self.assertEqual(len(triangles), 14)
            a, b, c = (turned[triangles[:, corner]] for corner in range(3))
            self.assertAlmostEqual(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum(), area, 10)

    def test_instances_and_their_names(self):
        stage = self.stage()
        instancer = UsdGeom.PointInstancer.Define(stage, "/crowd")
        quad(stage, "/crowd/leaf")
        instancer.CreatePrototypesRel().SetTargets(["/crowd/leaf"])
        instancer.CreateProtoIndicesAttr([0, 0, 0])
        instancer.CreatePositionsAttr([(0, 0, 0), (1, 0, 0), (2, 0, 0)])
        instancer.CreateInvisibleIdsAttr([1])
        gltf = self.load(stage)
        self.assertEqual([node.name for node in gltf.nodes], ["crowd", "crowd.0", "crowd.2"])
        self.assertEqual(len(gltf.document.raw["meshes"]), 1)


if __name__ == "__main__":
    unittest.main()
