"""Pictures for eyes: the display transform, contact sheets, movies."""

from __future__ import annotations

import json
import shutil
import struct
import subprocess
import tempfile
import unittest
from fractions import Fraction
from pathlib import Path
from unittest import mock

import numpy as np

from sunfleck_tools.display import BAYER, Display
from sunfleck_tools.exr.decode import decode
from sunfleck_tools.png import png

from .command import NO_PROGRAM, PROGRAM, SEQUENCES, run
from .files import frame_path, good_sequence, rewrite
from .png_file import chunks, pixels, unpacked

# What Blender 5.0.1 shows of colours under its view AgX (tools/display/against_blender.py prints these).
BLENDER = {
    (0.0, 0.0, 0.0): (0.0, 0.0, 0.0),
    (0.18, 0.18, 0.18): (0.46133, 0.46133, 0.46137),
    (1.0, 1.0, 1.0): (0.77098, 0.77098, 0.77099),
    (16.0, 16.0, 16.0): (0.99857, 0.99857, 0.99857),
    (1.0, 0.0, 0.0): (0.85801, 0.22409, 0.1292),
    (0.0, 1.0, 0.0): (0.43247, 0.77264, 0.31843),
    (8.0, 3.0, 0.2): (0.98921, 0.87236, 0.76916),
}


class Displays(unittest.TestCase):
    def test_agx_is_blenders(self):
        shown = Display().encode(np.array([list(BLENDER)]))[0]
        np.testing.assert_allclose(shown, list(BLENDER.values()), atol=2.5 / 255)

    def test_the_dither_is_bayers_and_keeps_the_mean(self):
        self.assertEqual(BAYER[0].tolist(), [0, 32, 8, 40, 2, 34, 10, 42])
        self.assertEqual(sorted(BAYER.ravel()), list(range(64)))
        grey = np.full((8, 8, 3), 0.3)
        self.assertAlmostEqual(
            Display("srgb").bytes(grey).mean(), 255 * Display("srgb").encode(grey)[0, 0, 0], delta=1 / 64
        )

    def test_what_is_not_finite_is_black_or_white(self):
        for curve in ("agx", "srgb", "raw"):
            odd = np.array([[[np.nan] * 3, [np.inf] * 3, [-np.inf] * 3, [1e30] * 3]])
            self.assertEqual(Display(curve).bytes(odd)[0, :, 0].tolist(), [0, 255, 0, 255], curve)

    @unittest.skipUnless(PROGRAM, NO_PROGRAM)
    def test_pictures_are_those_of_the_program(self):
        with tempfile.TemporaryDirectory() as folder:
            for curve, stops in (("agx", 0.0), ("agx", 1.5), ("srgb", -1.0), ("raw", 0.0)):
                command = [
                    PROGRAM,
                    "render",
                    SEQUENCES / "falling_leaves.ron",
                    "--frames",
                    "40",
                    "--size",
                    "15%",
                    "--samples",
                    "1",
                ]
                command += [
                    "--crop",
                    "3,2,93,50",
                    "--preview",
                    "png",
                    "--display",
                    curve,
                    "--exposure",
                    str(stops),
                ]
                subprocess.run(
                    [*map(str, command), "--out", f"{folder}/x.####.exr", "--progress", "none"], check=True
                )
                theirs = pixels(Path(folder, "x.0040.png").read_bytes()).astype(int)
                channels = decode(Path(folder, "x.0040.exr"))
                light = np.stack([channels[letter] for letter in "RGB"], axis=-1)
                ours = Display(curve, stops).bytes(light, (3, 2)).astype(int)
                # Single and double precision round apart where a value lies on a step.
                self.assertLessEqual(np.abs(ours - theirs).max(), 1)
                self.assertLess(np.count_nonzero(ours != theirs), 0.002 * ours.size, curve)


class WithSequence(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.scratch = Path(scratch.name)
        self.folder = good_sequence(self.scratch / "frames")


class Sheets(WithSequence):
    def sheet(self, *arguments: object) -> tuple[int, np.ndarray, str]:
        path = self.scratch / "sheet.png"
        code, _, err = run("contact-sheet", self.folder, path, "--display", "raw", *arguments)
        return code, pixels(path.read_bytes()), err

    def test_frames_stand_in_rows(self):
        code, sheet, _ = self.sheet("--columns", "5", "--frames", "1-12x2")
        self.assertEqual(code, 0)
        # 6 frames of 32x18, gaps of 4, numbers of 10 rows.
        self.assertEqual(sheet.shape, (4 + 2 * (18 + 10 + 12), 4 + 5 * (32 + 4), 3))
        channels = decode(frame_path(self.folder, 3))
        light = np.stack([channels[letter] for letter in "RGB"], axis=-1)
        np.testing.assert_array_equal(sheet[4:22, 40:72], Display("raw").bytes(light))

    def test_smaller_ones_are_averages(self):
        for path in self.folder.iterdir():
            rewrite(path, lambda c: {**c, **{letter: np.full_like(c[letter], 0.25) for letter in "RGB"}})
        _, sheet, _ = self.sheet("--width", "16")
        self.assertEqual(set(np.unique(sheet[4:13, 4:20])), {63, 64})

    def test_what_cannot_be_shown_keeps_its_place(self):
        frame_path(self.folder, 1).write_bytes(b"")
        frame_path(self.folder, 4).unlink()
        code, sheet, err = self.sheet("--columns", "4")
        self.assertEqual(code, 1)
        self.assertIn("frame 1 is not shown: the file is empty", err)
        self.assertIn("frame 4 is not shown: there is no such file", err)
        for x in (4, 4 + 3 * 36):
            self.assertEqual(set(np.unique(sheet[4:22, x : x + 32])), {50, 90})


class Movies(WithSequence):
    def test_an_animated_png_has_all_frames_and_the_rate(self):
        path = self.scratch / "leaf.png"
        frame_path(self.folder, 5).write_bytes(b"damaged")
        code, _, err = run("movie", self.folder, path, "--display", "raw")
        self.assertEqual(code, 1)
        self.assertIn("frame 5 is not shown", err)
        found = list(chunks(path.read_bytes()))
        self.assertEqual(struct.unpack(">II", dict(found)[b"acTL"]), (12, 0))
        controls = [struct.unpack(">IIIIIHHBB", body) for kind, body in found if kind == b"fcTL"]
        self.assertEqual([control[1:7] for control in controls], [(32, 18, 0, 0, 1, 24)] * 12)
        data = [body for kind, body in found if kind in (b"IDAT", b"fdAT")]
        numbers = [control[0] for control in controls] + [
            struct.unpack_from(">I", body)[0] for body in data[1:]
        ]
        self.assertEqual(sorted(numbers), list(range(23)))
        channels = decode(frame_path(self.folder, 7))
        light = np.stack([channels[letter] for letter in "RGB"], axis=-1)
        np.testing.assert_array_equal(unpacked(data[6][4:], 18, 32), Display("raw").bytes(light))

    def test_without_ffmpeg_there_is_a_way_out(self):
        with mock.patch.object(shutil, "which", return_value=None):
            code, _, err = run("movie", self.folder, self.scratch / "leaf.mp4")
        self.assertEqual((code, "write an animated PNG" in err), (2, True))

    def test_webp_without_ffmpeg(self):
        path = self.scratch / "leaf.webp"
        with mock.patch.object(shutil, "which", return_value=None):
            self.assertEqual(run("movie", self.folder, path, "--display", "raw", "--fps", "24")[0], 0)
        from PIL import Image

        with Image.open(path) as found:
            self.assertEqual((found.info["loop"], found.size), (0, (32, 18)))
            # Pictures that are the same once they are compressed are one, which lasts longer.
            begins, light, time_ms = [], [], 0
            for index in range(found.n_frames):
                found.seek(index)
                light.append(np.asarray(found.convert("RGB"), float).mean())
                begins.append(time_ms)
                time_ms += found.info["duration"]
        self.assertEqual(time_ms, 500)
        for number in range(1, 13):
            channels = decode(frame_path(self.folder, number))
            meant = Display("raw").bytes(np.stack([channels[letter] for letter in "RGB"], axis=-1)).mean()
            middle_ms = (number - 0.5) * 1000 / 24
            shown = max(index for index, begin in enumerate(begins) if begin <= middle_ms)
            self.assertAlmostEqual(light[shown], meant, delta=2.0)

    def test_webp_of_too_many_frames_says_so(self):
        with (
            mock.patch.object(shutil, "which", return_value=None),
            mock.patch("sunfleck_tools.webp.MOST_BYTES", 5 * 32 * 18 * 3),
        ):
            code, _, err = run("movie", self.folder, self.scratch / "leaf.webp")
        self.assertEqual(
            (code, "5 frames of this size are all" in err, list(self.scratch.glob("*.webp"))), (2, True, [])
        )

    @unittest.skipUnless(shutil.which("ffmpeg") and shutil.which("ffprobe"), "ffmpeg is not installed")
    def test_ffmpeg_gives_what_players_take(self):
        for ending in (".mp4", ".webm", ".mov"):
            path = self.scratch / f"leaf{ending}"
            self.assertEqual(run("movie", self.folder, path, "--fps", "30000/1001")[0], 0)
            command = ["ffprobe", "-v", "error", "-count_frames", "-show_streams", "-of", "json", str(path)]
            (stream,) = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)["streams"]
            self.assertEqual(
                (int(stream["nb_read_frames"]), stream["width"], stream["height"]), (12, 32, 18), ending
            )
            self.assertAlmostEqual(float(Fraction(stream["r_frame_rate"])), 29.97, places=2)

    @unittest.skipUnless(shutil.which("ffmpeg"), "ffmpeg is not installed")
    def test_webp_moves(self):
        path = self.scratch / "leaf.webp"
        self.assertEqual(run("movie", self.folder, path)[0], 0)
        data = path.read_bytes()
        self.assertEqual((data[:4], data[8:12], data.count(b"ANIM")), (b"RIFF", b"WEBP", 1))
        # ffmpeg joins pictures that look the same.
        self.assertIn(data.count(b"ANMF"), range(2, 13))

    def test_what_ffmpeg_says_is_told_and_nothing_is_left(self):
        binaries = self.scratch / "bin"
        binaries.mkdir()
        (binaries / "ffmpeg").write_text("#!/bin/sh\necho no such codec >&2\nexit 3\n")
        (binaries / "ffmpeg").chmod(0o755)
        before = sorted(self.scratch.iterdir())
        with mock.patch.dict("os.environ", {"PATH": f"{binaries}:/usr/bin:/bin"}):
            code, _, err = run("movie", self.folder, self.scratch / "leaf.mp4")
        self.assertEqual((code, sorted(self.scratch.iterdir())), (4, before))
        self.assertIn("ffmpeg failed with code 3: no such codec", err)

    def test_names_that_say_no_format(self):
        for name in ("leaf", "leaf.gif", "none/leaf.png", "frames"):
            code, _, err = run("movie", self.folder, self.scratch / name)
            self.assertIn(code, (2, 4), name)
            self.assertIn("error: ", err)


class Pngs(unittest.TestCase):
    def test_pixels_come_back(self):
        picture = np.random.default_rng(3).integers(0, 256, (5, 7, 3), np.uint8)
        np.testing.assert_array_equal(pixels(png(picture)), picture)
