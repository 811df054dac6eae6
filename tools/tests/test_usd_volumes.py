"""Fog by OpenVDB files as UsdVol has it, there and back."""

import json
import shutil
import subprocess
import unittest
from pathlib import Path

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, UsdVol

from sunfleck_tools.exr.decode import decode
from sunfleck_tools.usd import ExportOptions, export_usd, import_usd

from .test_usd_export import PROGRAM, needs_program, validation_errors
from .test_usd_lights import LookCase

GRIDS = Path(__file__).parents[2] / "tests/data/vdb"
SCENE = """Scene(version: 1,
    objects: { "holder": (translation_m: (0.5, 0.0, 0.0), rotation_deg: (0.0, 20.0, 0.0)) },
    fog: { "mist": (parent: "holder", vdb: "VDB", grid: "GRID", density_per_m: (0.2, 0.3, 0.4),
        albedo: 0.9, anisotropy: 0.3) },
    cameras: { "main": (position_m: (0.8, 3.5, 8.0), look_at_m: (0.8, 3.5, 3.0), fov_deg: 50.0) },
    lights: { "sun": Sun(to_sun: (0.5, 1.0, 0.4), irradiance_w_per_m2: (3.0, 2.0, 1.0)) })"""


class VolumeCase(LookCase):
    def scene(self, name: str, grid: str = "density", **files: str) -> Path:
        """A scene in a folder of its own, with files beside it."""
        folder = self.folder / "my scene"
        folder.mkdir(exist_ok=True)
        for file in files.values():
            shutil.copyfile(GRIDS / ("thin.vdb" if file.endswith("9.vdb") else "several.vdb"), folder / file)
        path = folder / "scene.ron"
        path.write_text(SCENE.replace("VDB", name).replace("GRID", grid))
        return path

    def fog(self, glb: Path) -> dict:
        """Of the only node that has some."""
        data = glb.read_bytes()
        document = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])
        (fog,) = (
            node["extras"]["sunfleck_fog_volume"]
            for node in document["nodes"]
            if "sunfleck_fog_volume" in node.get("extras", {})
        )
        return fog

    def field(self, stage: Usd.Stage, name: str) -> UsdVol.OpenVDBAsset:
        """Of the only volume."""
        (volume,) = (each for each in stage.Traverse() if each.IsA(UsdVol.Volume))
        return UsdVol.OpenVDBAsset(stage.GetPrimAtPath(UsdVol.Volume(volume).GetFieldPaths()[name]))

    def rendered(self, path: Path, frame: int = 1) -> np.ndarray:
        out = path.with_suffix(".exr")
        flags = f"--frames {frame} --size 48x27 --samples 4 --bounces 0 --passes none".split()
        subprocess.run([PROGRAM, "render", path, *flags, "--out", out], check=True, capture_output=True)
        channels = decode(out)
        return np.stack([np.float64(channels[each]) for each in "RGB"], axis=-1)

    def volume(self, stage: Usd.Stage, path: str, *files: tuple[float, str]) -> UsdVol.Volume:
        volume = UsdVol.Volume.Define(stage, path)
        asset = UsdVol.OpenVDBAsset.Define(stage, f"{path}/density")
        attribute = asset.CreateFilePathAttr()
        for code, file in files:
            attribute.Set(file, code) if len(files) > 1 else attribute.Set(file)
        asset.CreateFieldNameAttr("density")
        volume.CreateFieldRelationship("density", asset.GetPath())
        return volume


class ThereAndBack(VolumeCase):
    @needs_program
    def test_pictures_are_the_same(self):
        source = self.scene("mist.vdb", "heat", first="mist.vdb")
        for name in ("stage.usda", "stage.usdc"):
            stage, back = self.folder / name, self.folder / "back.glb"
            exported = export_usd(source, stage, ExportOptions(program=PROGRAM))
            self.assertEqual((exported.prims["Volume"], exported.lost), (1, []))
            self.assertEqual(validation_errors(stage), [])
            opened = Usd.Stage.Open(str(stage))
            field = self.field(opened, "heat")
            self.assertEqual(field.GetFilePathAttr().Get().path, "./my scene/mist.vdb")
            self.assertEqual(field.GetFieldNameAttr().Get(), "heat")
            imported = import_usd(stage, back)
            self.assertEqual(imported.lost, [])
            self.assertEqual(self.fog(back)["vdb"], "my%20scene/mist.vdb")
            expected, found = self.rendered(source), self.rendered(back)
            self.assertGreater(expected.mean(), 1e-3)
            # To a step of the halves that frames are written in.
            steps = [np.float16(each).view(np.int16).astype(int) for each in (expected, found)]
            self.assertLessEqual(np.abs(steps[1] - steps[0]).max(), 1)

    @needs_program
    def test_sequences_too(self):
        source = self.scene("mist.####.vdb", first="mist.0008.vdb", second="mist.0009.vdb")
        stage, back = self.folder / "stage.usdc", self.folder / "back.glb"
        export_usd(source, stage, ExportOptions(program=PROGRAM, frames=(7, 10)))
        self.assertEqual(validation_errors(stage), [])
        self.assertEqual(import_usd(stage, back).lost, [])
        self.assertEqual(self.fog(back)["vdb"], "my%20scene/mist.%23%23%23%23.vdb")
        eighth, ninth = self.rendered(back, 8), self.rendered(back, 9)
        self.assertGreater(np.abs(eighth - ninth).max(), 0.1 * eighth.mean())

    @needs_program
    def test_packages_hold_their_grids(self):
        source = self.scene("mist.vdb", first="mist.vdb")
        package = self.folder / "stage.usdz"
        export_usd(source, package, ExportOptions(program=PROGRAM))
        shutil.rmtree(source.parent)
        opened = Usd.Stage.Open(str(package))
        self.assertIn("[", self.field(opened, "density").GetFilePathAttr().Get().resolvedPath)


class Foreign(VolumeCase):
    def grid(self, name: str) -> str:
        shutil.copyfile(GRIDS / "thin.vdb", self.folder / name)
        return f"./{name}"

    def test_without_a_word_on_it_a_volume_scatters(self):
        stage = self.stage()
        UsdGeom.SetStageMetersPerUnit(stage, 0.01)
        volume = self.volume(stage, "/smoke", (0.0, self.grid("smoke.vdb")))
        field = volume.GetPrim().GetChild("density")
        UsdGeom.Xformable(field).AddTranslateOp().Set(Gf.Vec3d(1, 2, 3))
        material = UsdShade.Material.Define(stage, "/look")
        UsdShade.MaterialBindingAPI.Apply(volume.GetPrim()).Bind(material)
        gltf = self.load(stage)
        self.assertEqual(self.fog(self.folder / "made.glb"), {"density": 100.0, "vdb": "smoke.vdb", "grid": "density"})
        node = next(node for node in gltf.nodes if "sunfleck_fog_volume" in (node.extras.raw or {}))
        self.assertEqual(node.source.raw["translation"], [1.0, 2.0, 3.0])
        self.assertEqual([(loss.kind, loss.count) for loss in self.imported.lost], [("usd-volume", 2)])

    def test_what_is_not_carried_is_said(self):
        stage = self.stage()
        volume = self.volume(stage, "/smoke", (0.0, self.grid("smoke.vdb")))
        flame = UsdVol.OpenVDBAsset.Define(stage, "/smoke/flame")
        volume.CreateFieldRelationship("flame", flame.GetPath())
        self.volume(stage, "/gone", (0.0, "./nowhere.vdb"))
        UsdVol.Volume.Define(stage, "/empty")
        self.load(stage)
        said = {str(loss) for loss in self.imported.every}
        for words in ("/smoke: its field `flame`", "/gone/density: the file `./nowhere.vdb`", "/empty: has no field"):
            self.assertTrue(any(words in loss for loss in said), (words, said))

    def test_files_that_are_no_frames_are_said(self):
        for numbers, expected in (((1, 2, 3), "smoke.%23%23%23.vdb"), ((11, 12, 13), "smoke.011.vdb")):
            stage = self.stage()
            files = [(code, self.grid(f"smoke.{number:03d}.vdb")) for code, number in enumerate(numbers, 1)]
            self.volume(stage, "/smoke", *files).GetPrim()
            self.load(stage)
            self.assertEqual(self.fog(self.folder / "made.glb")["vdb"], expected)
            said = any("not numbered as frames" in str(loss) for loss in self.imported.every)
            self.assertEqual(said, numbers[0] == 11)


if __name__ == "__main__":
    unittest.main()
