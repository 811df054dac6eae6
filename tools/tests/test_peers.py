"""`peers`: what other renderers are given, and that what they give is what sunfleck gives."""

import base64
import csv
import importlib.util
import json
import struct
import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy as np

from sunfleck_tools import SceneError
from sunfleck_tools.exr.decode import decode
from sunfleck_tools.peers import Point, write_table
from sunfleck_tools.peers.scene import read_scene

from .command import PROGRAM, run
from .files import marked_sky

CANOPY = Path(__file__).resolve().parents[2] / "tests/data/canopy20k/scene.ron"
LEAVES500 = Path(__file__).parents[2] / "tests/data/leaves500"
LEAF = LEAVES500.parent / "blender/b_leafcards_separate/leaf_rgba.png"


def changed(source: Path, target: Path, change) -> Path:
    """A binary glTF file with a changed document."""
    data = source.read_bytes()
    (length,) = struct.unpack_from("<I", data, 12)
    document = json.loads(data[20 : 20 + length])
    change(document)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    rest = data[20 + length :]
    head = struct.pack("<4sIIII", b"glTF", 2, 20 + len(text) + len(rest), len(text), 0x4E4F534A)
    target.write_bytes(head + text + rest)
    return target


class Scenes(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.scratch = Path(scratch.name)

    def test_what_other_renderers_get(self):
        scene = read_scene(LEAVES500 / "leaves500.glb")
        (sun,) = scene.suns
        self.assertAlmostEqual(float(np.linalg.norm(sun.to_sun)), 1.0)
        self.assertGreater(float(sun.irradiance.min()), 0.0)
        self.assertEqual(np.shape(scene.fog.density_per_m), (3,))
        self.assertGreater(sum(len(surface.triangles) for surface in scene.surfaces), 1000)
        for surface in scene.surfaces:
            self.assertLess(int(surface.triangles.max()), len(surface.positions))

    def test_what_they_cannot_be_given_is_refused(self):
        def sun(document):
            return document["extensions"]["KHR_lights_punctual"]["lights"][0]

        def fog(document):
            return next(
                node["extras"]
                for node in document["nodes"]
                if "sunfleck_fog_volume" in node.get("extras", {})
            )["sunfleck_fog_volume"]

        for change, why in (
            (lambda d: fog(d).update(height_falloff=0.1), "fills a box evenly"),
            (lambda d: fog(d).update(scale_height=2.0), "fills a box evenly"),
            (lambda d: d["scenes"][0].setdefault("extras", {}).update(sunfleck_env={"image": "data:,"}), "OpenEXR and Radiance HDR"),
            (lambda d: sun(d).update(type="line"), "`line` is no type of light"),
            (lambda d: d["nodes"][0].update(extras={"sunfleck_light": {"type": "line"}}), "no light of its type"),
            (lambda d: sun(d).update(color=[1]), "expected 3 numbers"),
            (lambda d: d["cameras"][0].update(type="orthographic"), "pinhole camera"),
            (lambda d: d["cameras"].clear(), "no camera 0"),
            (lambda d: d["accessors"][0].update(count=10**9), "accessors[0]"),
            (lambda d: d["nodes"][0].update(children=[0]), "nodes[0]"),
        ):
            path = changed(LEAVES500 / "leaves500.glb", self.scratch / "changed.glb", change)
            with self.assertRaisesRegex(SceneError, r"changed\.glb") as caught:
                read_scene(path)
            self.assertIn(why, str(caught.exception))

    def test_pictures_that_are_damaged(self):
        """The readers that there are must refuse them in a sentence, and none may believe what they claim."""
        whole = LEAF.read_bytes()
        marked_sky(self.scratch / "sky.exr")
        sky = (self.scratch / "sky.exr").read_bytes()
        renderers = [
            name for name, package in (("mitsuba-scalar", "mitsuba"), ("cycles", "bpy")) if _is_there(package)
        ]
        for data in (
            whole[:100],
            whole[:16] + b"\xff" * 8 + whole[24:],
            whole[:400] + b"x" * 40 + whole[440:500],
            sky[:200],
            sky[:60],
        ):
            uri = "data:;base64," + base64.b64encode(data).decode()

            def change(document, uri=uri):
                document["scenes"][0].setdefault("extras", {})["sunfleck_env"] = {"image": uri}

            path = changed(LEAVES500 / "leaves500.glb", self.scratch / "changed.glb", change)
            for renderer in renderers:
                code, _, err = run(
                    "peers",
                    path,
                    "--renderers",
                    renderer,
                    "--samples",
                    1,
                    "--size",
                    "4x4",
                    "--pictures",
                    self.scratch,
                )
                self.assertEqual(code, 3, (data[:8], err))
                self.assertRegex(err, "picture of the scene|larger than it can be|damaged")

    def test_what_cannot_be_used_says_why(self):
        glb = LEAVES500 / "leaves500.glb"
        for code, *arguments in (
            (2, glb),
            (2, glb, "--out", self.scratch / "x.csv"),
            (2, glb, "--reference", LEAVES500 / "box.exr"),
            (2, glb, "--renderers", "luxcore", "--pictures", self.scratch),
            (2, glb, "--samples", "0", "--pictures", self.scratch),
            (2, glb, "--size", "0x3", "--pictures", self.scratch),
        ):
            found, _, err = run("peers", *arguments)
            self.assertEqual(found, code, (arguments, err))
            self.assertIn("error: ", err)

    def test_renderers_that_are_not_there_are_named_with_the_remedy(self):
        absent = [
            name
            for name, package in (("mitsuba-scalar", "mitsuba"), ("cycles", "bpy"))
            if not _is_there(package)
        ]
        for name in absent:
            code, _, err = run(
                "peers", LEAVES500 / "leaves500.glb", "--renderers", name, "--pictures", self.scratch
            )
            self.assertEqual(code, 2)
            self.assertRegex(err, r"is not here .*: pip install (mitsuba|bpy) ")

    def test_the_table_is_what_bench_reads(self):
        path = self.scratch / "table.csv"
        with path.open("w", newline="") as file:
            write_table(file, [Point("Cycles", "5.0.1", 16, 3.25, 0.0518, 0.999)], "a remark")
        lines = path.read_text().splitlines()
        self.assertEqual(lines[0], "# a remark")
        (row,) = csv.DictReader(lines[1:])
        self.assertEqual(
            (row["renderer"], row["spp"], row["cpu_s"], row["rmse"]), ("Cycles", "16", "3.25", "0.0518")
        )


def color(path: Path) -> np.ndarray:
    channels = decode(path)
    return np.stack([channels[letter] for letter in "RGB"], axis=-1).astype(float)


def _is_there(package: str) -> bool:
    return importlib.util.find_spec(package) is not None


LAMPS = {
    "point": "Point(position_m: (0.8, 2.6, 1.2), intensity_w_per_sr: (2.0, 1.5, 1.0))",
    "sphere": "Point(position_m: (0.8, 2.6, 1.2), intensity_w_per_sr: (2.0, 1.5, 1.0), radius_m: 0.05)",
    "large sphere": "Point(position_m: (0.8, 2.6, 1.2), intensity_w_per_sr: (2.0, 1.5, 1.0), radius_m: 0.3)",
    "spot": "Spot(position_m: (1.5, 2.5, 0.8), target_m: (0, 0, 0), outer_deg: 25, blend: 0, "
            "intensity_w_per_sr: 12)",
    "rectangle": "Rectangle(position_m: (-1.5, 2.2, 0.5), target_m: (0, 0.3, 0), width_m: 1, height_m: 0.5, "
                 "power_w: 20)",
    "disc": "Disc(position_m: (1.5, 2.2, 0.5), target_m: (0, 0.3, 0), diameter_m: 0.6, power_w: 20)",
    "sun": "Sun(to_sun: (0.4, 1, 0.6), irradiance_w_per_m2: (3, 2.5, 2), angular_diameter_deg: 8)",
}
"""None of them in the picture, where others' noise would be without bounds."""
SCENE = """Scene(
    version: 1,
    meshes: {{ "leaf": Leaf(length_m: 0.9, width_m: 0.6, curl_deg: 30), "ground": Quad(size_m: 5) }},
    materials: {{ "gold": (base_color: (0.8, 0.5, 0.1)), "soil": (base_color: (0.3, 0.4, 0.5)) }},
    objects: {{
        "leaf": (mesh: "leaf", material: "gold", translation_m: (0.1, 0.7, 0.1), rotation_deg: (60, 30, 0)),
        "ground": (mesh: "ground", material: "soil"),
    }},
    cameras: {{ "main": (position_m: (0, 1.2, 3.6), look_at_m: (0, 0.6, 0), fov_deg: 40) }},
    lights: {{ "lamp": {lamp} }},
    fog: {{ {fog} }},
)"""
TEXTURED = """Scene(
    version: 1,
    meshes: {{ "card": Quad(size_m: 2) }},
    materials: {{ "card": (texture: "{texture}", base_color: (0.9, 0.7, 0.8)) }},
    objects: {{ "card": (mesh: "card", material: "card", rotation_deg: (90, 0, 0), translation_m: (0.2, 1, 0)) }},
    cameras: {{ "main": (position_m: (0.5, 1.2, 4), look_at_m: (0, 1, 0), fov_deg: 50) }},
    {light}
    fog: {{ {fog} }},
)"""
SUN = 'lights: { "sun": Sun(to_sun: (0.3, 0.5, 1), irradiance_w_per_m2: 4) },'
SKIES = {
    "constant": "sky: Constant(radiance_w_per_m2_sr: (0.6, 0.8, 1)),",
    "gradient": "sky: Gradient(zenith_w_per_m2_sr: (0.2, 0.35, 0.8), horizon_w_per_m2_sr: (0.8, 0.85, 0.9), "
                "ground_w_per_m2_sr: 0.3),",
    "image": 'sky: Image(image: "marked.exr", rotation_deg: 50, strength_w_per_m2_sr: (1, 2, 0.5)),',
}
FOG = '"haze": (min_m: (-3, 0, -3), max_m: (3, 3, 3), density_per_m: 0.12, anisotropy: 0.4)'
NOISE = 0.01
"""Of the mean of a picture of 48 x 27 pixels, relative, generously: other renderers' mostly,
ours with 64 samples."""


class Rendered(unittest.TestCase):
    """Where a renderer is installed, its picture is the reference within its noise."""

    def check(self, renderer: str, samples: int) -> None:
        with tempfile.TemporaryDirectory() as folder:
            table = Path(folder, "x.csv")
            arguments = [
                "--reference",
                LEAVES500 / "box.exr",
                "--out",
                table,
                "--pictures",
                Path(folder, "frames"),
            ]
            code, out, err = run(
                "peers",
                LEAVES500 / "leaves500.glb",
                "--renderers",
                renderer,
                "--samples",
                samples,
                *arguments,
            )
            self.assertEqual(code, 0, err)
            self.assertAlmostEqual(float(out.split("mean ratio")[1]), 1.0, delta=0.02)
            (row,) = csv.DictReader(table.read_text().splitlines()[1:])
            self.assertLess(float(row["rmse"]), 0.6)
            frame = next(Path(folder, "frames").iterdir())
            subprocess.run(
                [PROGRAM, "diff", frame, LEAVES500 / "box.exr", "--max-rmse", "0.6"], check=True, capture_output=True
            )

    def check_lamps(self, renderer: str, samples: int) -> None:
        """Every kind of light, in clear air and in fog whose lower face is the ground, against the
        program's own picture."""
        for name, lamp in LAMPS.items():
            for fog in ("", FOG):
                with self.subTest(name, fog=bool(fog)), tempfile.TemporaryDirectory() as folder:
                    scene = Path(folder, "scene.ron")
                    scene.write_text(SCENE.format(lamp=lamp, fog=fog))
                    ours, peers = self.both(scene, renderer, samples, 64)
                    self.assertGreater(ours.mean(), 0.005)
                    self.assertAlmostEqual(peers.mean() / ours.mean(), 1.0, delta=NOISE)
                    # Where the light falls, in tiles of 9 x 16 pixels.
                    tiles = [each.reshape(3, 9, 3, 16, 3).mean(axis=(1, 3, 4)) for each in (peers, ours)]
                    np.testing.assert_allclose(*tiles, atol=0.05 * ours.mean())

    def check_pictures(self, renderer: str, samples: int) -> None:
        """A texture in the sun, and before each kind of sky, in clear air and in fog."""
        for name, light in {"sun": SUN, **SKIES}.items():
            for fog in ("", FOG):
                with self.subTest(name, fog=bool(fog)), tempfile.TemporaryDirectory() as folder:
                    marked_sky(Path(folder, "marked.exr"))
                    scene = Path(folder, "scene.ron")
                    scene.write_text(TEXTURED.format(texture=LEAF, light=light, fog=fog))
                    ours, peers = self.both(scene, renderer, samples, 64)
                    self.assertAlmostEqual(peers.mean() / ours.mean(), 1.0, delta=NOISE)
                    tiles = [each.reshape(3, 9, 6, 8, 3).mean(axis=(1, 3)) for each in (peers, ours)]
                    np.testing.assert_allclose(*tiles, atol=0.03 * ours.mean(), rtol=0.01)

    def check_bounces(self, renderer: str, samples: int) -> None:
        """Light of all orders, by its mean: a leaf over a ground under a sun and a lamp, a card
        under a sky, a canopy."""
        sky = SKIES["gradient"]
        scenes = {
            "sun": (SCENE.format(lamp=LAMPS["sun"], fog=FOG), 0.03),
            "point": (SCENE.format(lamp=LAMPS["point"], fog=FOG), 0.03),
            "sky": (TEXTURED.format(texture=LEAF, light=sky, fog=FOG), 0.03),
            "canopy": (None, 0.03),
        }
        for name, (text, most) in scenes.items():
            with self.subTest(name), tempfile.TemporaryDirectory() as folder:
                scene = CANOPY
                if text is not None:
                    scene = Path(folder, "scene.ron")
                    scene.write_text(text)
                ours, peers = self.both(scene, renderer, samples, 16, Path(folder), ["--bounces", "all"])
                ratio = ours.mean() / peers.mean()
                print(f"{name}: all orders, mean {ratio:.4f} of {renderer}'s")
                self.assertAlmostEqual(ratio, 1.0, delta=most)

    def both(
        self,
        scene: Path,
        renderer: str,
        samples: int,
        own_samples: int,
        folder: Path | None = None,
        more: list[str] | None = None,
    ) -> tuple[np.ndarray, np.ndarray]:
        """The program's own picture of a scene, and another renderer's."""
        folder, more = folder or scene.parent, more or ["--bounces", "0"]
        own = [*more, "--samples", str(own_samples), "--progress", "none", "--out", f"{folder}/own.####.exr"]
        subprocess.run(
            [PROGRAM, "render", str(scene), "--size", "48x27", *own], check=True, capture_output=True
        )
        theirs = [
            *more,
            "--renderers",
            renderer,
            "--samples",
            samples,
            "--pictures",
            folder,
            "--sunfleck",
            PROGRAM,
        ]
        code, _, err = run("peers", scene, "--size", "48x27", *theirs)
        self.assertEqual(code, 0, err)
        (ours,) = (color(path) for path in folder.glob("own.*.exr"))
        (peers,) = (color(path) for path in folder.glob(f"{renderer}.*.exr"))
        return ours, peers

    @unittest.skipUnless(_is_there("mitsuba") and PROGRAM, "mitsuba, or sunfleck, is not installed")
    def test_textures_and_skies_in_mitsuba(self):
        self.check_pictures("mitsuba-scalar", 300)

    @unittest.skipUnless(_is_there("bpy") and PROGRAM, "bpy, or sunfleck, is not installed")
    def test_textures_and_skies_in_cycles(self):
        self.check_pictures("cycles", 64)

    @unittest.skipUnless(_is_there("mitsuba") and PROGRAM, "mitsuba, or sunfleck, is not installed")
    def test_bounces_in_mitsuba(self):
        self.check_bounces("mitsuba-scalar", 256)

    @unittest.skipUnless(_is_there("mitsuba"), "mitsuba is not installed")
    def test_mitsuba(self):
        self.check("mitsuba-scalar", 4)

    @unittest.skipUnless(_is_there("mitsuba") and PROGRAM, "mitsuba, or sunfleck, is not installed")
    def test_lamps_in_mitsuba(self):
        self.check_lamps("mitsuba-scalar", 512)

    @unittest.skipUnless(_is_there("mitsuba"), "mitsuba is not installed")
    def test_a_spot_that_fades_is_not_mitsubas(self):
        with tempfile.TemporaryDirectory() as folder:
            scene = Path(folder, "scene.ron")
            scene.write_text(SCENE.format(lamp=LAMPS["spot"].replace("blend: 0", "blend: 0.5"), fog=""))
            code, _, err = run("peers", scene, "--renderers", "mitsuba-scalar", "--pictures", folder)
            self.assertEqual((code, "without a blend" in err), (3, True), err)

    @unittest.skipUnless(_is_there("mitsuba") and PROGRAM, "mitsuba, or sunfleck, is not installed")
    def test_a_sky_that_leaves_fog_dark_is_not_mitsubas(self):
        with tempfile.TemporaryDirectory() as folder:
            scene = Path(folder, "scene.ron")
            sky = SKIES["constant"].replace("))", "), lights: Surfaces)")
            scene.write_text(TEXTURED.format(texture=LEAF, light=sky, fog=FOG))
            code, _, err = run(
                "peers", scene, "--renderers", "mitsuba-scalar", "--pictures", folder, "--sunfleck", PROGRAM
            )
            self.assertEqual((code, "leaves fog dark" in err), (3, True), err)

    @unittest.skipUnless(_is_there("bpy"), "bpy is not installed")
    def test_cycles(self):
        self.check("cycles", 4)

    @unittest.skipUnless(_is_there("bpy"), "bpy is not installed")
    def test_the_denoiser_of_cycles_takes_noise_away(self):
        """Of one sample a pixel it takes three quarters; without it the option would only cost time."""
        with tempfile.TemporaryDirectory() as folder:
            table = Path(folder, "table.csv")
            reference = ["--reference", LEAVES500 / "box.exr", "--out", table]
            code, _, err = run("peers", LEAVES500 / "leaves500.glb", "--renderers", "cycles,cycles-denoised", "--samples", 1, *reference)
            self.assertEqual(code, 0, err)
            noisy, denoised = (float(row["rmse"]) for row in csv.DictReader(table.read_text().splitlines()[1:]))
            self.assertLess(denoised, 0.4 * noisy)

    @unittest.skipUnless(_is_there("bpy") and PROGRAM, "bpy, or sunfleck, is not installed")
    def test_lamps_in_cycles(self):
        self.check_lamps("cycles", 64)
