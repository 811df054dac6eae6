"""Stages that `export-usd` writes: valid to USD's own validators, and where the renderer has things."""

import itertools
import json
import os
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy as np
from pxr import Usd, UsdGeom, UsdLux, UsdShade, UsdValidation

from sunfleck_tools import SceneError
from sunfleck_tools.exr.decode import decode
from sunfleck_tools.gltf.container import Container
from sunfleck_tools.gltf.load import load
from sunfleck_tools.gltf.meshes import Meshes
from sunfleck_tools.gltf.scene import Gltf
from sunfleck_tools.usd import ExportOptions, export_usd, import_usd

from .files import marked_sky
from .glb import glb
from .test_validation import run

SAMPLES = Path(__file__).parents[2] / "tests/data/blender"
PROGRAM = shutil.which(os.environ.get("SUNFLECK", "sunfleck"))
needs_program = unittest.skipUnless(PROGRAM, "the program sunfleck is not there: SUNFLECK names it")


def validation_errors(path: Path) -> list[str]:
    """What any of USD's validators finds, warnings too."""
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    found = UsdValidation.ValidationContext(validators).Validate(Usd.Stage.Open(str(path)))
    return [f"{error.GetName()}: {error.GetMessage()}" for error in found]


def inspect(path: Path, frames: list[float]) -> dict[float, dict]:
    """What the renderer says of a file at frames."""
    listed = ",".join(f"{frame:g}" for frame in frames)
    text = subprocess.run(
        [PROGRAM, "inspect", path, "--json", "--frames", listed], capture_output=True, check=True, text=True
    )
    return {frame["frame"]: frame for frame in json.loads(text.stdout)["frames"]}


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def export(self, source: Path, ending: str = "usdc", **options) -> Usd.Stage:
        # USD would give the layer that is open already for a name that it knows.
        path = self.folder / f"stage_{len(list(self.folder.iterdir()))}.{ending}"
        export_usd(source, path, ExportOptions(**options))
        return Usd.Stage.Open(str(path))


class Stages(Case):
    def test_every_sample_is_valid(self):
        names = ("a_leaves40_sampled", "b_leafcards", "c_morph", "d_skin", "e_inst_default", "f_plain", "g_pbr", "h_cameras",
                 "h_fog_extras", "h_lights_nopointer", "h_time_23976_s101", "h_transforms", "i_conventions_nopointer")  # fmt: skip
        for name in names:
            for for_blender, point_instancer in itertools.product((False, True), repeat=2):
                path = self.folder / f"{name}.usdc"
                export_usd(SAMPLES / f"{name}.glb", path, ExportOptions(for_blender, point_instancer))
                self.assertEqual(
                    validation_errors(path), [], f"{name}, for_blender {for_blender}, {point_instancer}"
                )

    def test_which_rays_meet_things_goes_there_and_back(self):
        """By a node of its own, also where the others become one crowd."""
        source = Path(__file__).parents[2] / "tests/data/valid/gltf/leaf.gltf"
        document = json.loads(source.read_text())
        rays = {"visible_to_camera": False, "casts_shadow": False, "holdout": True}
        document["nodes"] += [{"name": "unseen", "mesh": 0, "extras": {"sunfleck_object": rays}}, {"name": "usual", "mesh": 0}]
        document["scenes"][0]["nodes"] += [len(document["nodes"]) - 2, len(document["nodes"]) - 1]
        path = self.folder / "leaf.gltf"
        path.write_text(json.dumps(document))
        for point_instancer in (False, True):
            stage, back = self.folder / f"leaf_{point_instancer}.usda", self.folder / f"back_{point_instancer}.glb"
            export_usd(path, stage, ExportOptions(point_instancer=point_instancer))
            import_usd(stage, back)
            found = {node.name: node.extras.raw.get("sunfleck_object") for node in load(back).nodes}
            self.assertEqual({name: said for name, said in found.items() if said}, {"unseen": rays})

    def test_a_package_holds_its_textures(self):
        path = self.folder / "cards.usdz"
        export_usd(SAMPLES / "b_leafcards.glb", path)
        self.assertEqual(validation_errors(path), [])
        self.assertEqual([file.name for file in self.folder.iterdir()], ["cards.usdz"])

    def test_a_sky_is_a_dome_that_lights_as_much(self):
        """An open plane that faces up receives pi (horizon + 2 zenith) / 3 from a gradient, and pi L
        from an even sky."""
        for sky, expected in (
            ({"zenith": [0.2, 0.35, 0.8], "horizon": [0.8, 0.85, 0.9], "strength": 2.0}, [0.8, 3.1 / 3, 5 / 3]),
            ({"color": [0.4, 0.2, 0.1]}, [0.4, 0.2, 0.1]),
        ):
            stage = self.export(self.under({**sky, "lights": "surfaces_and_fog"}))
            path = Path(stage.GetRootLayer().realPath)
            self.assertEqual(validation_errors(path), [])
            (dome,) = [UsdLux.DomeLight(prim) for prim in stage.Traverse() if prim.IsA(UsdLux.DomeLight)]
            light = np.array(dome.GetColorAttr().Get()) * dome.GetIntensityAttr().Get()
            if file := dome.GetTextureFileAttr().Get():
                channels = decode(Path(file.resolvedPath))
                light = light * np.stack([channels[letter] for letter in "RGB"], axis=-1).mean(
                    axis=1, dtype=float
                )
                self.assertTrue((light[512:] == 0).all())
            down = np.pi * (np.arange(1024) + 0.5) / 1024
            weights = np.where(down < np.pi / 2, np.cos(down) * np.sin(down), 0) * 2 * np.pi / 1024
            received = (np.broadcast_to(light, (1024, 3)) * weights[:, None]).sum(axis=0)
            np.testing.assert_allclose(received, expected, rtol=1e-5)
            export_back = self.folder / "back.glb"
            import_usd(path, export_back)
            back = load(export_back).extras.group("sunfleck_env")
            self.assertEqual(back.text_at("lights"), "surfaces_and_fog")
            for name, value in sky.items():
                np.testing.assert_allclose(back.raw[name], value)

    def test_an_image_of_the_sky_is_the_domes(self):
        marked_sky(self.folder / "marked.exr")
        sky = {"image": "marked.exr", "rotation": 0.5, "strength": [2.0, 1.0, 0.5]}
        for lights, ending in (("surfaces", "usdc"), ("surfaces", "usdz"), ("nothing", "usdc")):
            stage = self.export(self.under({**sky, "lights": lights}), ending)
            path = Path(stage.GetRootLayer().realPath)
            self.assertEqual(validation_errors(path), [])
            domes = [UsdLux.DomeLight(prim) for prim in stage.Traverse() if prim.IsA(UsdLux.DomeLight)]
            self.assertEqual(len(domes), lights != "nothing")
            for dome in domes:
                self.assertTrue(dome.GetTextureFileAttr().Get().resolvedPath)
                np.testing.assert_allclose(
                    np.array(dome.GetColorAttr().Get()) * dome.GetIntensityAttr().Get(), sky["strength"]
                )
                # USD has +z in the middle of the picture, the renderer -z, both turned
                # anticlockwise as seen from above.
                middle = np.array(dome.GetLocalTransformation(Usd.TimeCode.Default())).T[:3, 2]
                np.testing.assert_allclose(middle, [-np.sin(0.5), 0, -np.cos(0.5)], atol=1e-6)
            back = self.folder / "back.glb"
            import_usd(path, back)
            gltf = load(back)
            found = gltf.extras.group("sunfleck_env")
            self.assertEqual((found.text_at("lights"), found.raw["rotation"]), (lights, 0.5))
            self.assertEqual(
                gltf.container.linked(found.need("image")), (self.folder / "marked.exr").read_bytes()
            )

    def test_a_background_that_lights_nothing_is_no_dome(self):
        stage = self.export(self.under({"color": [0.4, 0.2, 0.1]}))
        self.assertEqual([prim for prim in stage.Traverse() if prim.IsA(UsdLux.DomeLight)], [])

    def under(self, sky: dict) -> Path:
        path = self.folder / "sky.glb"
        scene = {"nodes": [0], "extras": {"sunfleck_env": sky}}
        path.write_bytes(glb({"scene": 0, "scenes": [scene], "nodes": [{"name": "nothing"}]}))
        return path

    def test_metadata_is_whole(self):
        stage = self.export(SAMPLES / "a_leaves40_sampled.glb")
        self.assertEqual((stage.GetStartTimeCode(), stage.GetEndTimeCode()), (1.0, 72.0))
        self.assertEqual((stage.GetTimeCodesPerSecond(), stage.GetFramesPerSecond()), (24.0, 24.0))
        self.assertEqual(stage.GetDefaultPrim().GetPath(), "/World")
        self.assertEqual((UsdGeom.GetStageUpAxis(stage), UsdGeom.GetStageMetersPerUnit(stage)), ("Y", 1.0))
        samples = stage.GetPrimAtPath("/World/cam").GetAttribute("xformOp:translate").GetTimeSamples()
        self.assertTrue(samples and all(code == int(code) for code in samples))

    def test_leaves_share_their_mesh(self):
        stage = self.export(SAMPLES / "a_leaves40_sampled.glb")
        leaves = [prim for prim in stage.Traverse() if prim.IsInstance()]
        self.assertGreaterEqual(len(leaves), 40)
        self.assertLess(len(stage.GetPrototypes()), 5)

    @needs_program
    def test_places_are_the_renderers_at_any_frame(self):
        frames = [1.0, 2.5, 17.0, 33.3, 72.0]
        for name in (
            "a_leaves40_sampled",
            "a_leaves40_curves",
            "h_transforms",
            "h_transforms_scene",
            "d_skin",
        ):
            # Curves are joined by straight lines between samples: put one at each frame that is looked at.
            stage = self.export(
                SAMPLES / f"{name}.glb", samples_per_frame=10 if name == "a_leaves40_curves" else 1
            )
            named: dict[str, Usd.Prim] = {}
            for prim in stage.Traverse():
                # Behind the node itself there may be its mesh.
                named.setdefault(prim.GetAttribute("userProperties:sunfleck_name").Get(), prim)
            compared = 0
            for frame, expected in inspect(SAMPLES / f"{name}.glb", frames).items():
                cache = UsdGeom.XformCache(frame)
                for key, node in expected["nodes"].items():
                    if key not in named:
                        continue
                    world = np.array(cache.GetLocalToWorldTransform(named[key])).T.ravel()
                    worst = np.abs(world - node["world"]).max()
                    self.assertLessEqual(worst, 1e-5, f"{name}: {key} at {frame}")
                    compared += 1
            self.assertGreater(compared, 20)

    @needs_program
    def test_a_crowd_has_the_places_of_its_leaves(self):
        stage = self.export(SAMPLES / "a_leaves40_scene.glb", point_instancer=True)
        frames = [1.0, 2.5, 17.0, 72.0]
        compared = 0
        for frame, expected in inspect(SAMPLES / "a_leaves40_scene.glb", frames).items():
            for prim in stage.Traverse():
                if not prim.IsA(UsdGeom.PointInstancer):
                    continue
                above = np.array(UsdGeom.XformCache(frame).GetLocalToWorldTransform(prim))
                places = UsdGeom.PointInstancer(prim).ComputeInstanceTransformsAtTime(frame, frame)
                for key, place in zip(prim.GetAttribute("userProperties:sunfleck_names").Get(), places):
                    world = (np.array(place) @ above).T.ravel()
                    self.assertLessEqual(
                        np.abs(world - expected["nodes"][key]["world"]).max(), 1e-5, f"{key} at {frame}"
                    )
                    compared += 1
        self.assertEqual(compared, 160)

    def test_lights_follow_the_specification_or_blender(self):
        for for_blender, sun, angle in ((False, 3.0, 1.0), (True, 0.75, 0.5)):
            stage = self.export(self._lights(), for_blender=for_blender)
            light = UsdLux.DistantLight.Get(stage, "/World/sun")
            self.assertAlmostEqual(light.GetIntensityAttr().Get(), sun, 5)
            self.assertAlmostEqual(light.GetAngleAttr().Get(), np.degrees(0.02) * angle, 5)
            kept = light.GetPrim().GetCustomDataByKey("sunfleck")
            self.assertAlmostEqual(list(kept["irradiance_w_per_m2"])[0], 3.0, 5)
            lamp = UsdLux.SphereLight.Get(stage, "/World/lamp")
            # 10 W/sr is 40 pi W.
            self.assertAlmostEqual(lamp.GetIntensityAttr().Get(), 40.0, 4)

    def _lights(self) -> Path:
        lights = [
            {"type": "directional", "intensity": 3.0 * 683, "color": [1, 0.5, 0.25]},
            {"type": "point", "intensity": 10.0 * 683},
        ]
        nodes = [
            {"name": "sun", "extensions": {"KHR_lights_punctual": {"light": 0}}, "extras": {"sunfleck_light": {"angle": 0.02}}},
            {"name": "lamp", "extensions": {"KHR_lights_punctual": {"light": 1}}},
        ]
        path = self.folder / "lights.glb"
        path.write_bytes(glb({"nodes": nodes, "extensions": {"KHR_lights_punctual": {"lights": lights}}}))
        return path

    def test_what_hides_shrinks_for_blender(self):
        times, shown = np.float32([0, 10 / 24]), np.float32([[1, 0, 0], [0, 0, 0]])
        binary = times.tobytes() + shown.tobytes()
        views = [
            {"buffer": 0, "byteOffset": 0, "byteLength": 8},
            {"buffer": 0, "byteOffset": 8, "byteLength": 24},
        ]
        accessors = [{"bufferView": 0, "componentType": 5126, "count": 2, "type": "SCALAR"},
                     {"bufferView": 1, "componentType": 5126, "count": 2, "type": "VEC3"}]  # fmt: skip
        channel = {"sampler": 0, "target": {"node": 1, "path": "translation"}}
        control = {"target": "leaf.sunfleck_node.visible", "channel": "translation.x"}
        idle = {"target": "nobody.sunfleck_light.power_w", "channel": "translation.x"}
        document = {
            "nodes": [{"name": "leaf", "children": [2]}, {"name": "ctl", "extras": {"sunfleck_ctl": control}}, {"name": "child"},
                      {"name": "idle", "extras": {"sunfleck_ctl": idle}}],  # fmt: skip
            "scenes": [{"nodes": [0, 1, 3], "extras": {"sunfleck": {"fps": 24, "frame_start": 0, "frame_end": 20}}}],
            "buffers": [{"byteLength": len(binary)}],
            "bufferViews": views,
            "accessors": accessors,
            "animations": [{"channels": [channel], "samplers": [{"input": 0, "output": 1, "interpolation": "STEP"}]}],
        }
        path = self.folder / "hides.glb"
        path.write_bytes(glb(document, binary))
        for for_blender, scale in ((False, 1.0), (True, 1e-4)):
            stage = self.export(path, for_blender=for_blender)
            leaf = stage.GetPrimAtPath("/World/leaf")
            seen = [UsdGeom.Imageable(leaf).ComputeVisibility(code) for code in (0.0, 9.9, 10.0, 20.0)]
            self.assertEqual(seen, ["inherited", "inherited", "invisible", "invisible"])
            worlds = [UsdGeom.XformCache(code).GetLocalToWorldTransform(leaf)[0][0] for code in (9.9, 10.0)]
            np.testing.assert_allclose(worlds, [1.0, scale], atol=1e-7)
            self.assertFalse(stage.GetPrimAtPath("/World/ctl"))
        exported = export_usd(path, self.folder / "again.usda")
        self.assertEqual(exported.lost, ["what changes `nobody.sunfleck_light.power_w` is not carried"])

    def test_a_picture_on_the_sun_is_said_to_be_lost(self):
        source = json.loads((SAMPLES.parent / "valid/gltf/same/plain.gltf").read_text())
        path = self.folder / "picture.gltf"
        for shows, lost in (
            ({}, 0),
            ({"fractal": {"real": 0, "imaginary": 0.5}}, 1),
            ({"limb_darkening": 0.5}, 1),
        ):
            source["nodes"][2]["extras"] = {"sunfleck_light": {"angle": 0.1, **shows}}
            path.write_text(json.dumps(source))
            said = [
                line
                for line in export_usd(path, self.folder / "picture.usda").lost
                if "pictures on suns" in line
            ]
            self.assertEqual(len(said), lost, shows)

    def test_what_is_unlit_shines_in_its_colour(self):
        material = {
            "pbrMetallicRoughness": {"baseColorFactor": [0.25, 0.5, 0.75, 1]},
            "extensions": {"KHR_materials_unlit": {}},
        }
        source = json.loads((SAMPLES.parent / "valid/gltf/same/plain.gltf").read_text())
        for mesh in source["meshes"]:
            for primitive in mesh["primitives"]:
                primitive["material"] = 0
        source["materials"] = [material]
        path = self.folder / "unlit.gltf"
        path.write_text(json.dumps(source))
        stage = self.export(path)
        shaders = [
            UsdShade.Shader(prim)
            for prim in stage.Traverse(Usd.TraverseInstanceProxies())
            if prim.IsA(UsdShade.Shader)
        ]
        self.assertEqual(shaders[0].GetInput("emissiveColor").Get(), (0.25, 0.5, 0.75))
        self.assertEqual(shaders[0].GetInput("diffuseColor").Get(), (0, 0, 0))

    def test_masks_keep_their_cutoff(self):
        stage = self.export(SAMPLES / "b_leafcards.glb")
        thresholds = set()
        for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
            shader = UsdShade.Shader(prim)
            if shader and shader.GetInput("opacityThreshold"):
                thresholds.add(round(shader.GetInput("opacityThreshold").Get(), 3))
        self.assertEqual(thresholds, {0.3, 0.4, 0.5})

    def test_texture_coordinates_lead_to_the_same_texels(self):
        source = Container(SAMPLES / "g_pbr.glb").document.raw
        stage = self.export(SAMPLES / "g_pbr.glb", "usda")
        # Specification of KHR_texture_transform: translation * rotation * scale, v from the top.
        transform = next(
            texture["extensions"]["KHR_texture_transform"]
            for material in source["materials"]
            for texture in [material["pbrMetallicRoughness"].get("baseColorTexture", {})]
            if "KHR_texture_transform" in texture.get("extensions", {})
        )
        angle, uv = transform.get("rotation", 0.0), np.random.default_rng(1).random((20, 2))
        turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        expected = (uv * transform.get("scale", [1, 1])) @ turn.T + transform.get("offset", [0, 0])
        self.assertGreater(np.abs(expected - uv).max(), 0.1)
        # Specification of UsdTransform2d: scale, then rotate anticlockwise, then
        # translate, t from the bottom.
        found = []
        for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
            shader = UsdShade.Shader(prim)
            if shader and shader.GetIdAttr().Get() == "UsdTransform2d":
                scale, degrees, place = (
                    np.array(shader.GetInput(name).Get()) for name in ("scale", "rotation", "translation")
                )
                sine, cosine = np.sin(np.radians(degrees)), np.cos(np.radians(degrees))
                st = (uv * [1, -1] + [0, 1]) * scale @ np.array([[cosine, -sine], [sine, cosine]]).T + place
                found.append(np.abs(st * [1, -1] + [0, 1] - expected).max())
        self.assertLess(min(found), 1e-6)
        positions, flipped = [], []
        meshes = Meshes(Gltf(Container(SAMPLES / "f_plain.glb")), [])
        for node in meshes.gltf.nodes:
            if meshes.of(node):
                positions.append(meshes.of(node)[1].primitives[0].uvs[0])
        plain = self.export(SAMPLES / "f_plain.glb")
        for prim in plain.Traverse(Usd.TraverseInstanceProxies()):
            if prim.IsA(UsdGeom.Mesh):
                flipped.append(np.array(UsdGeom.PrimvarsAPI(prim).GetPrimvar("st").Get()))
        np.testing.assert_allclose(flipped[0] * [1, -1] + [0, 1], positions[0], atol=1e-6)

    def test_frames_that_were_asked_for(self):
        stage = self.export(SAMPLES / "a_leaves40_scene.glb", frames=(5, 9))
        self.assertEqual((stage.GetStartTimeCode(), stage.GetEndTimeCode()), (5.0, 9.0))
        self.assertEqual(
            stage.GetPrimAtPath("/World/cam").GetAttribute("xformOp:translate").GetTimeSamples(),
            [5, 6, 7, 8, 9],
        )

    def test_the_shutter_opens_where_it_does(self):
        stage = self.export(SAMPLES / "i_conventions_nopointer.glb")
        said = Gltf(Container(SAMPLES / "i_conventions_nopointer.glb")).extras.raw["sunfleck"]
        camera = next(UsdGeom.Camera(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Camera))
        opening, closing = camera.GetShutterOpenAttr().Get(), camera.GetShutterCloseAttr().Get()
        self.assertAlmostEqual(closing - opening, said["shutter"], 6)
        self.assertAlmostEqual(opening, said["shutter_offset"], 6)

    def test_frames_of_a_morph_are_samples_of_its_points(self):
        stage = self.export(SAMPLES / "c_morph.glb")
        meshes = [UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)]
        self.assertEqual(len(meshes), 2)
        for mesh in meshes:
            self.assertGreater(len(mesh.GetPointsAttr().GetTimeSamples()), 10)


class Refusals(Case):
    def test_damaged_files_are_refused_with_their_place(self):
        cut = self.folder / "cut.glb"
        whole = (SAMPLES / "f_plain.glb").read_bytes()
        for length in range(0, len(whole) - 1, 97):
            cut.write_bytes(whole[:length])
            with self.assertRaises(SceneError):
                export_usd(cut, self.folder / "stage.usdc")
        self.assertEqual([file.name for file in self.folder.iterdir()], ["cut.glb"])

    def test_each_lie_is_found_where_it_is(self):
        circle = {"nodes": [{"children": [1]}, {"children": [0]}], "scenes": [{"nodes": [0]}], "scene": 0}
        huge = {"accessors": [{"count": 10**12, "type": "VEC3", "componentType": 5126}],
                "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "nodes": [{"mesh": 0}]}  # fmt: skip
        cases = [
            (circle, "nodes[0]: has two parents"),
            (huge, "accessors[0]: claims 1000000000000 values"),
            ({"nodes": [{"mesh": 7}]}, "nodes[0].mesh: there is no mesh 7, of 0"),
            ({"nodes": [{"translation": [1, 2]}]}, "nodes[0].translation: expected 3 numbers, found 2"),
            ({"nodes": "many"}, "nodes: expected a list"),
            ({"nodes": [{"camera": 0}], "cameras": [{"type": "perspective"}]}, "cameras[0]: has no `perspective`"),
            ({"extensionsRequired": ["EXT_no_such_thing"]}, "EXT_no_such_thing"),
        ]
        path = self.folder / "lie.glb"
        for document, said in cases:
            path.write_bytes(glb(document))
            code, _, err = run(
                "export-usd", path, self.folder / "stage.usdc", "--sunfleck", "no such program"
            )
            self.assertEqual(code, 3, said)
            self.assertIn(said, err)

    def test_flipped_bytes_raise_nothing_else(self):
        whole = (SAMPLES / "c_morph.glb").read_bytes()
        generator = np.random.default_rng(1)
        path = self.folder / "flipped.glb"
        for _ in range(150):
            data = bytearray(whole)
            for at in generator.integers(20, len(data), 3):
                data[at] ^= int(generator.integers(1, 256))
            path.write_bytes(data)
            try:
                export_usd(path, self.folder / "stage.usdc", ExportOptions(program="no such program"))
            except SceneError:
                pass

    def test_commands_that_cannot_be_used(self):
        source = SAMPLES / "f_plain.glb"
        for target, said in (
            (self.folder / "stage.obj", "is no stage"),
            (self.folder / "none/stage.usdc", "there is no folder"),
        ):
            code, _, err = run("export-usd", source, target)
            self.assertEqual(code, 3)
            self.assertIn(said, err)
        code, _, err = run("export-usd", self.folder / "none.glb", self.folder / "stage.usdc")
        self.assertEqual(code, 3)
        self.assertIn("cannot be read", err)


if __name__ == "__main__":
    unittest.main()
