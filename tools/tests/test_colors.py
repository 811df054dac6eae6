"""Colour spaces, codecs and parts of other programs' frames. OpenImageIO and OpenColorIO say what is right."""

import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy as np
import OpenEXR
import OpenImageIO
import PyOpenColorIO

from sunfleck_tools import Options, validate
from sunfleck_tools.analysis import read_frame, read_picture
from sunfleck_tools.difference import relative_mse
from sunfleck_tools.exr.codecs import why_unread
from sunfleck_tools.exr.colors import OURS, color_space
from sunfleck_tools.exr.header import parse_header
from sunfleck_tools.summary import thumbnail

from .command import NO_PROGRAM, PROGRAM, run
from .files import add_attribute, good_sequence, rewrite, scene, write_frame, write_parts

try:
    from pxr import Usd
except ImportError:
    Usd = None

COLOR = (0.2, 0.5, 0.1)
IN_REC_709 = {
    "lin_rec709_scene": (0.2, 0.5, 0.1), "lin_ap1_scene": (0.02179, 0.5433, 0.04601), "lin_ap0_scene": (-0.10148, 0.62144, 0.03727),
    "lin_rec2020_scene": (0.03099, 0.5407, 0.05795), "lin_p3d65_scene": (0.13252, 0.51262, 0.06658),
    "lin_ciexyzd65_scene": (-0.17036, 0.74829, 0.01483), "srgb_rec709_scene": (0.0331, 0.21404, 0.01002),
    "g22_ap1_scene": (-0.08642, 0.24444, -0.02149),
}  # fmt: skip
AP0 = np.array([0.7347, 0.2653, 0, 1, 0.0001, -0.077, 0.32168, 0.33767], "<f4").tobytes()
HERE = Options(processes=0)


class WithFolder(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = Path(scratch.name)

    def even(self, name: str, id: str | None = None, color=COLOR, chromaticities: bytes | None = None) -> Path:
        """A frame of one colour, in the space of that name."""
        channels = {letter: np.full((8, 16), value, np.float32) for letter, value in zip("RGB", color)}
        path = write_frame(self.folder / name, channels, **({} if id is None else {"colorInteropID": id}))
        if chromaticities is not None:
            add_attribute(path, "chromaticities", "chromaticities", chromaticities)
        return path

    def found(self, target: Path) -> list[str]:
        return [f.check for f in validate(target, HERE).findings if f.check not in ("unsigned", "constant")]


class Spaces(WithFolder):
    def test_names_are_known_and_their_colours_converted(self):
        for id, expected in IN_REC_709.items():
            _, frame = read_frame(1, str(self.even("a.0001.exr", id)))
            shown = [float(color[3, 3]) for color in frame.shown()]
            np.testing.assert_allclose(shown, expected, atol=3e-4, err_msg=id)

    def test_the_id_counts_first_and_doubts_are_said(self):
        for id, chromaticities, doubt in (
            ("lin_ap0_scene", AP0, None), (None, AP0, None), ("lin_ap1_scene", AP0, "disagree"),
            ("data", None, "holds data"), ("studio:lin_ap1_scene", None, "not known"), ("unknown", AP0, None),
        ):  # fmt: skip
            path = self.even("a.0001.exr", id, chromaticities=chromaticities)
            space = color_space(parse_header(path.read_bytes()))
            self.assertEqual(space.doubt is None, doubt is None, id)
            self.assertIn(doubt or "", space.doubt or "")
            self.assertEqual(self.found(path), ["colour-space"] if doubt else [], id)

    def test_mixtures_are_found_and_two_ways_to_say_the_same_are_none(self):
        rec_709 = np.array([0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329], "<f4").tobytes()
        for number, given in enumerate(((None, None), ("lin_rec709_scene", None), (None, rec_709)), 1):
            write_frame(self.folder / f"a.{number:04d}.exr", scene(number), **({"colorInteropID": given[0]} if given[0] else {}))
            if given[1]:
                add_attribute(self.folder / f"a.{number:04d}.exr", "chromaticities", "chromaticities", given[1])
        self.assertEqual(self.found(self.folder), [])
        write_frame(self.folder / "a.0002.exr", scene(2), colorInteropID="lin_ap1_scene")
        self.assertEqual(self.found(self.folder), ["structure"])

    def test_colours_of_different_spaces_are_converted_to_be_compared(self):
        other = self.even("b.exr", "lin_ap1_scene")
        same = self.even("a.exr", "lin_rec709_scene", IN_REC_709["lin_ap1_scene"])
        frames = [read_picture(path)[0] for path in (same, other)]
        self.assertLess(relative_mse(*frames), 1e-6)
        self.assertEqual(relative_mse(frames[1], frames[1]), 0.0)

    def test_thumbnails_are_in_linear_rec_709(self):
        path = self.even("b.exr", "lin_ap1_scene")
        for width in (16, 8):
            seen = thumbnail(read_picture(path)[0], width)[2, 2]
            np.testing.assert_allclose(seen, IN_REC_709["lin_ap1_scene"], atol=1e-3)


class BesideOpenImageIO(WithFolder):
    def test_what_it_writes_is_read_as_it_means_it(self):
        for id in IN_REC_709:
            path = self.folder / "a.0001.exr"
            image = OpenImageIO.ImageBuf(OpenImageIO.ImageSpec(16, 8, 3, "float"))
            OpenImageIO.ImageBufAlgo.fill(image, COLOR)
            image.specmod().attribute("oiio:ColorSpace", id)
            self.assertTrue(image.write(str(path)), image.geterror())
            converted = OpenImageIO.ImageBufAlgo.colorconvert(image, id, "lin_rec709_scene")
            _, frame = read_frame(1, str(path))
            shown = [float(color[3, 3]) for color in frame.shown()]
            np.testing.assert_allclose(shown, converted.getpixel(3, 3)[:3], atol=5e-4, err_msg=id)

    @unittest.skipIf(PROGRAM is None, NO_PROGRAM)
    def test_it_reads_frames_of_the_program_as_linear_rec_709(self):
        (self.folder / "a.ron").write_text(
            'Scene(version: 1, meshes: {}, objects: {}, sky: Constant(radiance_w_per_m2_sr: (0.2, 0.5, 0.1)), cameras: '
            '{"main": (position_m: (0.0, 0.0, 4.0), look_at_m: (0.0, 0.0, 0.0), fov_deg: 34.0)})'
        )
        out = self.folder / "a.exr"
        subprocess.run(
            [PROGRAM, "render", "a.ron", "--size", "8x4", "--samples", "1", "--out", out],
            cwd=self.folder, check=True, capture_output=True,
        )  # fmt: skip
        image = OpenImageIO.ImageBuf(str(out))
        self.assertEqual(image.spec().get_string_attribute("oiio:ColorSpace"), "lin_rec709_scene")
        seen = OpenImageIO.ImageBufAlgo.colorconvert(image, "", "srgb_rec709_scene").getpixel(2, 2)[:3]
        np.testing.assert_allclose(seen, (0.4845, 0.7354, 0.3492), atol=2e-3)


class BesideOpenColorIO(unittest.TestCase):
    def test_colours_are_those_of_its_config(self):
        config = PyOpenColorIO.Config.CreateFromBuiltinConfig("studio-config-latest")
        every = config.getColorSpaces(PyOpenColorIO.SEARCH_REFERENCE_SPACE_ALL, PyOpenColorIO.COLORSPACE_ALL)
        names = {space.getInteropID(): space.getName() for space in every if space.getInteropID()}
        for id, expected in IN_REC_709.items():
            processor = config.getProcessor(names[id], "lin_rec709_scene").getDefaultCPUProcessor()
            np.testing.assert_allclose(processor.applyRGB(list(COLOR)), expected, atol=3e-4, err_msg=id)


class Codecs(WithFolder):
    def test_those_that_the_program_does_not_read_have_names(self):
        for compression, name in (("HTJ2K256", "htj2k256"), ("HTJ2K32", "htj2k32"), ("LJ2K", "lj2k"), ("ZSTD", "zstd")):
            path = write_frame(self.folder / "a.exr", scene(1), compression=OpenEXR.Compression(getattr(OpenEXR, f"{compression}_COMPRESSION")))
            self.assertIn(name, why_unread(path.read_bytes()))
            self.assertIn("oiiotool IN.exr -a --compression zip", why_unread(path.read_bytes()))
        for compression in ("NO", "ZIP", "DWAB", "B44A", "PIZ"):
            write_frame(path, scene(1), compression=OpenEXR.Compression(getattr(OpenEXR, f"{compression}_COMPRESSION")))
            self.assertIsNone(why_unread(path.read_bytes()))
        add_attribute(path, "envmap", "envmap", b"\1")
        self.assertIn("six sides of a cube", why_unread(path.read_bytes()))
        path.write_bytes(b"no picture")
        self.assertIsNone(why_unread(path.read_bytes()))

    @unittest.skipIf(Usd is None, "usd-core is not installed")
    def test_a_dome_with_one_is_said_before_it_is_rendered(self):
        write_frame(self.folder / "sky.exr", scene(1), compression=OpenEXR.Compression(OpenEXR.ZSTD_COMPRESSION))
        (self.folder / "a.usda").write_text(
            '#usda 1.0\n(upAxis = "Y")\ndef DomeLight "sky" {\n    asset inputs:texture:file = @./sky.exr@\n}\n'
        )
        code, _, err = run("import-usd", self.folder / "a.usda", self.folder / "a.glb")
        self.assertEqual(code, 0, err)
        for words in ("[usd-texture] /sky", "zstd", "oiiotool IN.exr -a --compression zip"):
            self.assertIn(words, err)
        code, _, err = run("import-usd", self.folder / "a.usda", self.folder / "b.glb", "--strict")
        self.assertEqual((code, (self.folder / "b.glb").exists()), (3, False), err)

    def test_lossy_ones_leave_values_below_zero_that_are_no_fault(self):
        for compression, level in (("DWAA", 45.0), ("DWAB", 200.0), ("B44", None), ("B44A", None), ("LJ2K", None)):
            for number in range(1, 5):
                x, y = np.meshgrid(np.arange(128), np.arange(72))
                noise = np.random.default_rng(number).exponential(2e-5, (72, 128))
                light = noise + 60 * np.exp(-((x - 30 - 4 * number) ** 2 + (y - 36) ** 2) / 20)
                channels = {letter: (light * share).astype(np.float16) for letter, share in zip("RGB", (1, 0.25, 0.03))}
                channels["A"] = np.ones((72, 128), np.float16)
                header = {} if level is None else {"dwaCompressionLevel": level}
                header["compression"] = OpenEXR.Compression(getattr(OpenEXR, f"{compression}_COMPRESSION"))
                path = write_frame(self.folder / f"{compression}/f.{number:04d}.exr", channels, **header)
            _, frame = read_frame(1, str(path))
            self.assertLess(min(frame.extremes(letter)[0] for letter in "RGB"), 0, compression)
            self.assertEqual(self.found(path.parent), [], compression)

    def test_own_frames_that_were_compressed_with_loss_are_not_asked_for_sums(self):
        for compression in ("DWAA", "B44", "LJ2K", "ZSTD"):
            folder = good_sequence(self.folder / compression)
            for path in sorted(folder.iterdir()):
                rewrite(path, compression=getattr(OpenEXR, f"{compression}_COMPRESSION").value)
            self.assertEqual(self.found(folder), [], compression)

    def test_light_below_zero_and_lost_blocks_are_found_in_them_too(self):
        for number in range(1, 4):
            channels = scene(number)
            if number == 2:
                channels["G"][:8, :8] = -0.5
                for letter in "RGB":
                    channels[letter][16:32, 16:32] = 0
            write_frame(self.folder / f"f.{number:04d}.exr", channels, compression=OpenEXR.Compression(OpenEXR.DWAA_COMPRESSION))
        self.assertEqual(sorted(self.found(self.folder)), ["black-block", "negative"])


class Parts(WithFolder):
    def test_the_picture_is_the_beauty_in_any_order(self):
        beauty = {letter: scene(1)[letter] for letter in "RGB"}
        normal = {letter: np.full((48, 64), value, np.float16) for letter, value in zip("RGB", (-0.5, 0.5, 1))}
        for order in (("N", "albedo", "C"), ("C", "N", "albedo"), ("albedo", "C", "N")):
            parts = {"N": normal, "albedo": {letter: np.float16(0.5) + values * 0 for letter, values in beauty.items()}, "C": beauty}
            path = write_parts(self.folder / "a.0001.exr", {name: parts[name] for name in order})
            self.assertEqual(self.found(path), [], order)
            _, frame = read_frame(1, str(path))
            np.testing.assert_array_equal(frame.group()[0], beauty["R"].astype(np.float32))
            self.assertEqual(set(frame.channels), {*"RGB", *(f"{name}.{letter}" for name in ("N", "albedo") for letter in "RGB")})

    def test_our_own_space_is_what_nobody_says(self):
        self.assertTrue(color_space(parse_header(self.even("a.exr").read_bytes())) == OURS)


if __name__ == "__main__":
    unittest.main()
