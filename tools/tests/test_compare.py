"""`compare`: what its figures are, against their formulas and against `sunfleck diff`."""

from __future__ import annotations

import json
import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy as np
import OpenEXR

from sunfleck_tools.comparison import compare
from sunfleck_tools.difference import IdErrors

from .command import NO_PROGRAM, PROGRAM, run
from .files import frame_path, good_sequence, rewrite
from .json_schema import faults
from .png_file import pixels

SCHEMA = Path(__file__).parents[1] / "sunfleck_tools/compare.schema.json"

try:
    import flip_evaluator
except ImportError:
    flip_evaluator = None


def write(path: Path, rows: list[float], first: int = 0, full: int = 4, names="RGB", values=None) -> Path:
    """A frame one row high, equal in all channels but those with `values` of their own."""
    row = np.array([rows], np.float32)
    pixels = {name: (values or {}).get(name, row).reshape(1, -1).copy() for name in names}
    windows = (np.array([first, 0], np.int32), np.array([first + len(rows) - 1, 0], np.int32))
    header = {
        "type": OpenEXR.scanlineimage,
        "compression": OpenEXR.ZIP_COMPRESSION,
        "dataWindow": windows,
        "displayWindow": (np.array([0, 0], np.int32), np.array([full - 1, 0], np.int32)),
    }
    with OpenEXR.File(header, {name: OpenEXR.Channel(own) for name, own in pixels.items()}) as file:
        file.write(str(path))
    return path


class Measures(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = Path(scratch.name)

    def compared(self, output: Path, reference: Path, **options):
        (result,) = compare(output, reference, processes=0, **options)
        return result

    def test_are_what_their_formulas_say(self):
        reference = write(self.folder / "r.exr", [1, 2, 3, 4])
        output = write(self.folder / "o.exr", [1, 2, 3, 6])
        color = self.compared(output, reference).difference.color
        self.assertAlmostEqual(color.mean_ratio, 1.2)
        self.assertAlmostEqual(color.rmse, 1.0)
        self.assertAlmostEqual(color.relative_mse, 1 / 16.0625)
        self.assertEqual((color.max_error, color.pixel, color.not_finite), (2.0, (3, 0), 0))

    def test_nan_counts_and_enters_no_mean(self):
        reference = write(self.folder / "r.exr", [1, np.inf, 3, 4])
        output = write(self.folder / "o.exr", [1, np.inf, np.nan, 4])
        result = self.compared(output, reference)
        red = result.difference.channels["R"]
        self.assertEqual((red.not_finite, red.rmse, red.mean_ratio, red.pixel), (1, 0.0, 1.0, None))
        self.assertEqual(run("compare", output, reference, "--max-rmse", "1")[0], 1)
        self.assertEqual(run("compare", output, reference)[0], 0)

    def test_crops_are_compared_where_they_overlap(self):
        reference = write(self.folder / "r.exr", [1, 2, 3, 4])
        output = write(self.folder / "o.exr", [3, 4.5], first=2)
        color = self.compared(output, reference).difference.color
        self.assertEqual((color.max_error, color.pixel), (0.5, (3, 0)))

    def test_what_cannot_be_compared_says_why(self):
        reference = write(self.folder / "r.exr", [1, 2, 3, 4])
        for output, why in (
            (write(self.folder / "size.exr", [1, 2, 3, 4], full=5), "the pictures differ in size: 5x1 "
                                                                    "against 4x1 pixels"),
            (write(self.folder / "names.exr", [1, 2, 3, 4], names="XYZ"), "no channel in common"),
        ):
            self.assertIn(why, self.compared(output, reference).fault)
            self.assertEqual(run("compare", output, reference)[0], 1)

    def test_ids_are_equal_or_not(self):
        """The bits of two of these ids are those of NaN and of a number next to another."""
        rows = (
            np.array([0, 7, 0x7FC00001, 0x3F800000], np.uint32),
            np.array([0, 7, 0x7FC00002, 0x3F800001], np.uint32),
        )
        one, other = (self.folder / name for name in ("one.exr", "other.exr"))
        for path, ids in zip((one, other), rows):
            names = ("CryptoObject00.R", "CryptoObject00.G")
            write(path, [0.5] * 4, names=names, values={"CryptoObject00.R": ids.view(np.float32)})
        found = self.compared(one, other).difference
        self.assertEqual(found.ids, {"CryptoObject00.R": IdErrors(2, (2, 0), 4)})
        # Coverages are amounts.
        self.assertEqual(
            (list(found.channels), found.channels["CryptoObject00.G"].rmse), (["CryptoObject00.G"], 0.0)
        )
        self.assertEqual(self.compared(one, one).difference.ids["CryptoObject00.R"].different, 0)
        for limit, code in (("0.5", 0), ("0.4", 1), ("0", 1)):
            self.assertEqual(run("compare", one, other, "--max-ids", limit)[0], code)
        self.assertEqual(run("compare", one, one, "--max-ids", "0")[0], 0)
        self.assertIn("CryptoObject00.R  2 of 4 ids differ, first at 2, 0", run("compare", one, other)[1])

    def test_ids_alone_can_be_compared(self):
        one, other = (write(self.folder / f"{n}.exr", [1, 2, n, 4], names=["leaf_id.X"]) for n in (3, 5))
        code, out, _ = run("compare", one, other, "--max-ids", "0.1", "--json")
        (frame,) = json.loads(out)["frames"]
        self.assertEqual((code, frame["ids"][0]["pixel"], frame["channels"]), (1, [2, 0], []))
        self.assertEqual(frame["exceeded"], ["share of ids that differ of leaf_id.X 0.25, allowed 0.1"])

    @unittest.skipUnless(PROGRAM, NO_PROGRAM)
    def test_figures_are_those_of_the_program(self):
        folder = good_sequence(self.folder / "frames")
        pair = [frame_path(folder, 3), frame_path(folder, 4)]
        theirs = subprocess.run(
            [PROGRAM, "diff", *map(str, pair)], check=True, capture_output=True, text=True
        ).stdout
        _, ours, _ = run("compare", *pair)
        for line in theirs.strip().splitlines():
            name, _, figures = line.partition(" ")
            (own,) = [other for other in ours.splitlines() if other.split(":")[1].split()[0] == name]
            for one, other in zip(figures.split(), own.split(f" {name} ", 1)[1].split()):
                if one.replace(".", "").replace("-", "").replace("e", "").isdigit():
                    self.assertAlmostEqual(
                        float(one), float(other), delta=2e-6 * (1 + abs(float(one))), msg=line
                    )
                else:
                    self.assertEqual(one, other)


class Sequences(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.scratch = Path(scratch.name)
        self.ours, self.theirs = (good_sequence(self.scratch / name) for name in ("ours", "theirs"))

    def test_by_number_with_limits_and_exit_code(self):
        self.assertEqual(run("compare", self.ours, self.theirs, "--max-error", "1e-9")[0], 0)
        rewrite(frame_path(self.ours, 7), lambda c: {**c, "G": c["G"] * np.float16(1.5)})
        code, out, _ = run("compare", self.ours, self.theirs, "--max-relmse", "0.01")
        self.assertEqual(code, 1)
        self.assertRegex(
            out.splitlines()[0],
            r"^frame 7: RGB .* in G; too much: relative mean square error .*, allowed 0.01$",
        )
        self.assertEqual(len(out.splitlines()), 12)
        frame_path(self.theirs, 2).unlink()
        frame_path(self.theirs, 3).write_bytes(b"")
        code, out, _ = run("compare", self.ours, self.theirs)
        self.assertEqual(code, 1)
        self.assertIn("error: frame 2: the reference has no such frame", out)
        self.assertIn("leaf.0003.exr: the file is empty", out)

    def test_json_follows_its_schema(self):
        frame_path(self.theirs, 2).unlink()
        rewrite(frame_path(self.ours, 7), lambda c: {**c, "G": np.full_like(c["G"], np.nan)})
        _, out, _ = run(
            "compare",
            self.ours,
            self.theirs,
            "--json",
            "--max-rmse",
            "1",
            "--picture",
            self.scratch / "pictures",
        )
        report = json.loads(out)
        self.assertEqual(list(faults(report, json.loads(SCHEMA.read_text()))), [])
        self.assertEqual(
            [len(frame["exceeded"]) for frame in report["frames"]], [0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0]
        )
        self.assertTrue(
            all(Path(frame["picture"]).is_file() for frame in report["frames"] if frame["picture"])
        )

    def test_the_picture_shows_both_and_where_they_differ(self):
        one = frame_path(self.ours, 7)
        rewrite(one, lambda c: {**c, "G": c["G"] + np.eye(18, 32, dtype=np.float16)})
        picture = self.scratch / "d.png"
        run("compare", one, frame_path(self.theirs, 7), "--picture", picture, "--white", "1")
        shown = pixels(picture.read_bytes())
        self.assertEqual(shown.shape, (18, 3 * 32 + 2 * 4, 3))
        heat = shown[:, 72:].astype(int).sum(axis=2)
        self.assertTrue((heat.diagonal() > 600).all())
        self.assertEqual(np.count_nonzero(heat), 18)

    def test_what_cannot_be_used_says_why(self):
        one = frame_path(self.ours, 1)
        for code, *arguments in (
            (4, self.ours, self.scratch / "none"),
            (2, one, self.theirs),
            (2, self.ours, self.theirs, "--max-rmse", "-1"),
            (2, self.ours, self.theirs, "--max-ids", "1.5"),
            (2, one, one, "--picture", self.scratch / "x.jpg"),
            (4, one, one, "--picture", self.scratch / "none/x.png"),
            (4, self.ours, self.theirs, "--picture", one),
        ):
            found, _, err = run("compare", *arguments)
            self.assertEqual(found, code, (arguments, err))
            self.assertIn("error: ", err)


@unittest.skipUnless(flip_evaluator, "flip-evaluator is not installed")
class Flip(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.scratch = Path(scratch.name)
        self.ours, self.theirs = (good_sequence(self.scratch / name) for name in ("ours", "theirs"))
        rewrite(frame_path(self.ours, 7), lambda c: {**c, "G": c["G"] * np.float16(1.5)})
        # FLIP takes its time: two frames say as much as twelve.
        for number in (1, 2, 3, 4, 5, 8, 9, 10, 11, 12):
            frame_path(self.ours, number).unlink()
            frame_path(self.theirs, number).unlink()

    def test_is_that_of_the_authors_package_reading_files(self):
        pair = frame_path(self.theirs, 7), frame_path(self.ours, 7)
        expected = float(flip_evaluator.evaluate(*map(str, pair), "HDR")[1])
        (result,) = compare(pair[1], pair[0], wants_flip=True, processes=0)
        self.assertGreater(expected, 0.01)
        self.assertAlmostEqual(result.difference.flip, expected, places=5)
        self.assertEqual(compare(*pair[:1] * 2, wants_flip=True, processes=0)[0].difference.flip, 0.0)

    def test_is_a_limit(self):
        self.assertEqual(run("compare", self.ours, self.theirs, "--max-flip", "0.001")[0], 1)
        self.assertEqual(run("compare", self.ours, self.theirs, "--max-flip", "0.9")[0], 0)
        limits = ["--reference", self.theirs, "--max-relmse", "9"]
        code, out, _ = run("validate", self.ours, *limits, "--max-flip", "0.001")
        self.assertEqual(code, 1)
        self.assertRegex(out, r"error: frame 7: mean FLIP 0\.\d+, allowed 0\.001 \[reference\]")
        self.assertEqual(run("validate", self.ours, *limits, "--max-flip", "0.9")[0], 0)
