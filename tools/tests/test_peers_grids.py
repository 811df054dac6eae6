"""`peers` with fog by an OpenVDB file: other renderers get the same grid."""

import re
import shutil
import tempfile
import unittest
from pathlib import Path

import numpy as np

from sunfleck_tools import SceneError
from sunfleck_tools.peers.scene import read_scene

from . import test_peers
from .command import PROGRAM, run
from .test_peers import _is_there

GRIDS = Path(__file__).parents[2] / "tests/data/vdb"
SCENE = """Scene(version: 1,
    meshes: { "ground": Quad(size_m: 30) },
    materials: { "soil": (base_color: (0.3, 0.4, 0.5)) },
    objects: { "ground": (mesh: "ground", material: "soil"), "holder": (rotation_deg: (0, 20, 0)) },
    fog: { "mist": (parent: "holder", vdb: "VDB", density_per_m: 0.4, albedo: 0.9, anisotropy: 0.3) },
    cameras: { "main": (position_m: (0.8, 3.5, 9), look_at_m: (0.8, 3.2, 3), fov_deg: 50) },
    lights: { "sun": Sun(to_sun: (0.5, 1, 0.4), irradiance_w_per_m2: (3, 2, 1)) })"""
NOISE = 0.01
"""Of the mean of a picture of 48 x 27 pixels, relative."""


@unittest.skipUnless(PROGRAM, "the program sunfleck is not there: SUNFLECK names it")
class Grids(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def scene(self, vdb: str, *files: str) -> Path:
        for file in files:
            shutil.copyfile(GRIDS / "thin.vdb", self.folder / file)
        path = self.folder / "scene.ron"
        path.write_text(SCENE.replace("VDB", vdb))
        return path

    def test_the_file_is_the_scenes(self):
        fog = read_scene(self.scene("a b.vdb", "a b.vdb"), program=PROGRAM).fog
        self.assertEqual(fog.grid, ((self.folder / "a b.vdb").resolve(), "density"))
        with self.assertRaisesRegex(SceneError, "no sequences of grids"):
            read_scene(self.scene("a.##.vdb", "a.01.vdb", "a.02.vdb"), program=PROGRAM)

    def test_colours_go_along_and_light_is_refused(self):
        shutil.copyfile(GRIDS / "colours.vdb", self.folder / "a.vdb")
        scene = self.scene("a.vdb")
        text = scene.read_text()
        scene.write_text(text.replace("albedo: 0.9", 'albedo: 0.9, albedo_grid: "Cd"'))
        self.assertEqual(read_scene(scene, program=PROGRAM).fog.albedo_grid, "Cd")
        shining = 'emission_grid: "density", emission_w_per_m3_sr: 1'
        scene.write_text(text.replace("albedo: 0.9", f"albedo: 0.9, {shining}"))
        with self.assertRaisesRegex(SceneError, "grids of density and albedo alone"):
            read_scene(scene, program=PROGRAM)

    def check(self, renderer: str, samples: int, **changed: str) -> None:
        scene = self.scene("a.vdb", "a.vdb")
        for field, value in changed.items():
            scene.write_text(re.sub(rf"{field}: \([^()]*\)", f"{field}: {value}", scene.read_text()))
        ours, theirs = test_peers.Rendered.both(self, scene, renderer, samples, 64)
        self.assertGreater(np.abs(ours - np.median(ours, axis=(0, 1))).max(), 0.1 * ours.mean())
        blocks = [picture[:24].reshape(4, 6, 6, 8, 3).mean(axis=(1, 3)) for picture in (ours, theirs)]
        off = np.abs(blocks[0] - blocks[1]).mean() / ours.mean()
        print(f"{renderer}: mean {theirs.mean() / ours.mean():.5f}, blocks off {off:.5f}")
        self.assertLess(abs(theirs.mean() / ours.mean() - 1), NOISE)
        self.assertLess(off, 2 * NOISE)

    @unittest.skipUnless(_is_there("bpy"), "bpy is not installed")
    def test_cycles(self):
        self.check("cycles", 256)

    @unittest.skipUnless(_is_there("mitsuba") and _is_there("bpy"), "mitsuba or bpy is not installed")
    def test_mitsuba(self):
        self.check("mitsuba-scalar", 256)

    @unittest.skipUnless(_is_there("mitsuba") and _is_there("bpy"), "mitsuba or bpy is not installed")
    def test_mitsuba_has_fog_over_a_ground_in_its_face(self):
        from sunfleck_tools.peers import mitsuba
        from sunfleck_tools.peers.mitsuba_grids import _dense

        mitsuba.select("scalar_rgb")
        fog = read_scene(self.scene("a.vdb", "a.vdb"), program=PROGRAM).fog
        low_m = _dense(fog)[2][1, 3]
        down = {"position_m": "(2, 4, 6)", "look_at_m": "(0.6, 0, 3.5)"}
        # In place of its turn the grid moves down, until its box ends in the ground.
        self.check("mitsuba-scalar", 256, rotation_deg=f"(0, 0, 0), translation_m: (0, {-low_m}, 0)", **down)

    @unittest.skipUnless(_is_there("mitsuba") and not _is_there("bpy"), "mitsuba is not installed alone")
    def test_mitsuba_alone_says_what_it_needs(self):
        scene = self.scene("a.vdb", "a.vdb")
        arguments = ["--renderers", "mitsuba-scalar", "--samples", 1, "--pictures", self.folder]
        code, _, err = run("peers", scene, *arguments, "--sunfleck", PROGRAM)
        self.assertNotEqual(code, 0)
        self.assertRegex(err, "Mitsuba gets grids by Blender's module .*: pip install bpy")


if __name__ == "__main__":
    unittest.main()
