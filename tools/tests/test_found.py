"""Damage that no single frame shows, and what looks like it and is none, in frames of other renderers."""

import json
import shutil
import struct
import tempfile
import unittest
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import OpenEXR

from sunfleck_tools import Options, validate
from sunfleck_tools.checks.order import _swapped
from sunfleck_tools.exr.chunks import chunk_faults
from sunfleck_tools.exr.header import parse_header

from .command import run
from .files import DATA, frame_path, good_sequence, rewrite, scene, write_frame

PIZ = OpenEXR.PIZ_COMPRESSION


class WithFolder(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = Path(scratch.name)

    def write(
        self,
        number: int,
        change=lambda channels: None,
        name: str = "f",
        of: int | None = None,
        **header: object,
    ) -> Path:
        """A frame of `scene`, of the moment `of`, changed."""
        channels = scene(number if of is None else of)
        change(channels)
        return write_frame(self.folder / f"{name}.{number:04d}.exr", channels, **header)

    def found(self, check: str, **options: object) -> list[int | None]:
        report = validate(self.folder, Options(processes=0, **options))
        return [finding.frame for finding in report.findings if finding.check == check]


def blacken(rows: slice, columns: slice):
    """A part of the picture black, alpha too."""

    def change(channels):
        for values in channels.values():
            values[rows, columns] = 0

    return change


class BlackBlocks(WithFolder):
    def test_are_found_wherever_they_lie(self):
        for rows, columns in (
            (slice(16, 32), slice(16, 32)), (slice(0, 16), slice(0, 64)), (slice(32, 48), slice(48, 64)), (slice(20, 29), slice(0, 64)),
        ):  # fmt: skip
            for number in range(1, 6):
                self.write(number, blacken(rows, columns) if number == 3 else lambda channels: None)
            self.assertEqual(self.found("black-block"), [3], (rows, columns))

    def test_one_in_the_first_or_last_frame_or_in_a_picture_alone(self):
        path = self.write(1, blacken(slice(16, 32), slice(16, 32)))
        self.assertEqual(self.found("black-block"), [1])
        for number in range(2, 5):
            self.write(number)
        self.assertEqual(self.found("black-block"), [1])
        path.unlink()
        self.write(4, blacken(slice(16, 32), slice(16, 32)))
        self.assertEqual(self.found("black-block"), [4])

    def test_of_a_whole_are_told_with_their_place(self):
        for number in range(1, 4):
            self.write(number, blacken(slice(8, 24), slice(16, 48)) if number == 2 else lambda channels: None)
        (finding,) = [
            f for f in validate(self.folder, Options(processes=0)).findings if f.check == "black-block"
        ]
        self.assertEqual(
            finding.message, "32 x 16 pixels from (16, 8) on are black: a block that was not rendered"
        )
        self.assertEqual(finding.pixel, (16, 8))

    def test_bars_black_things_and_fades_are_none(self):
        def bars(channels):
            blacken(slice(0, 8), slice(0, 64))(channels)
            blacken(slice(40, 48), slice(0, 64))(channels)

        def disc(channels):
            y, x = np.mgrid[:48, :64]
            for values in channels.values():
                values[(x - 30) ** 2 + (y - 24) ** 2 < 150] = 0

        for number in range(1, 7):
            self.write(number, bars, "bars")
            self.write(number, disc if number == 3 else lambda channels: None, "disc")
            self.write(number, blacken(slice(10, 30), slice(20, 40)), "card")
            self.write(
                number, blacken(slice(0, 48), slice(0, 64)) if number > 4 else lambda channels: None, "end"
            )
        self.assertEqual(self.found("black-block"), [])
        still = self.folder / "bars.0001.exr"
        self.assertEqual([f.check for f in validate(still, Options(processes=0)).findings], ["unsigned"])


class Order(WithFolder):
    def sequence(self, order: list[int]) -> None:
        for number, of in enumerate(order, 1):
            self.write(number, of=of)

    def test_swapped_frames_are_found(self):
        for one, other in ((3, 4), (1, 2), (7, 8), (2, 6)):
            order = list(range(1, 9))
            order[one - 1], order[other - 1] = other, one
            self.sequence(order)
            self.assertEqual(self.found("order"), [one, other])

    def test_what_moves_evenly_turns_back_or_stops_is_in_order(self):
        for order in (
            range(1, 11),
            [1, 2, 3, 4, 5, 5, 4, 3, 2, 1],
            [1, 2, 3, 4, 4, 4, 4, 5, 6, 7],
            [1, 2, 3, 9, 10, 11, 12, 13, 14, 15],
        ):
            self.sequence(list(order))
            self.assertEqual(self.found("order"), [], list(order))

    def test_what_moves_in_no_order_accuses_nobody(self):
        random = np.random.default_rng(1)
        picture = random.random((14, 24))
        y, x = np.mgrid[:14, :24]

        def shaken():
            return np.exp(
                -((x - 12 - 3 * random.standard_normal()) ** 2 + (y - 7 - 2 * random.standard_normal()) ** 2)
                / 8
            )

        def accused(make) -> float:
            """Of a hundred sequences."""
            sequences = [[SimpleNamespace(signature=make()) for _ in range(24)] for _ in range(100)]
            return sum(bool(list(_swapped(frames))) for frames in sequences) / 100

        self.assertEqual(accused(lambda: picture + 0.1 * random.standard_normal(picture.shape)), 0)
        self.assertLessEqual(accused(lambda: picture * (1 + 0.3 * random.random())), 0.05)
        self.assertLessEqual(accused(shaken), 0.05)

    def test_numbers_that_files_say_count_more(self):
        for number in range(1, 9):
            self.write(number, of={3: 4, 4: 3}.get(number, number), imageCounter=number + 1000)
        # All are a thousand ahead: renumbered, not swapped.
        self.assertEqual((self.found("order"), self.found("image-counter")), ([], []))
        one, other, aside = self.folder / "f.0003.exr", self.folder / "f.0004.exr", self.folder / "aside"
        one.rename(aside)
        other.rename(one)
        aside.rename(other)
        self.assertEqual(self.found("image-counter"), [3, 4])

    def test_blender_says_its_numbers_in_words(self):
        names = {1: 1, 2: 3, 3: 2}
        for number, other in names.items():
            shutil.copy(
                DATA / f"exr/multipart_blender/f.{other:04d}.exr", self.folder / f"f.{number:04d}.exr"
            )
        self.assertEqual(self.found("image-counter"), [2, 3])


class Duplicates(WithFolder):
    def test_are_an_error_unless_nothing_moves(self):
        for number in range(1, 7):
            self.write(number, of=min(number, 5) if number != 4 else 3)
        code, out, _ = run("validate", self.folder)
        self.assertEqual(code, 1)
        self.assertIn("error: frame 4: it has the pixels of frame 3 [stuck]", out)
        self.assertEqual(run("validate", self.folder, "--static")[0], 0)

    def test_of_a_still_sequence_the_remedy_is_told(self):
        for number in range(1, 5):
            self.write(number, of=1)
        self.assertIn(
            "until frame 4; if nothing moves, say so by --static [stuck]", run("validate", self.folder)[1]
        )


class Missing(WithFolder):
    def test_frames_that_statistics_tell_of_are_expected(self):
        good = good_sequence(self.folder / "good")
        stats = self.folder / "stats.jsonl"
        stats.write_text(
            "".join(json.dumps({"frame": number, "render_seconds": 1.0}) + "\n" for number in range(1, 14))
        )
        code, out, _ = run("validate", good, "--stats", stats)
        self.assertEqual(code, 1)
        self.assertIn("frame 13: there is no leaf.0013.exr [missing-frame]", out)
        self.assertEqual(run("validate", good, "--stats", stats, "--frames", "1-12")[0], 0)


class Piz(WithFolder):
    def noisy(self, size: int = 96) -> Path:
        random = np.random.default_rng(3)
        ramp = np.linspace(0.2, 0.8, size)
        channels = {name: (ramp + 0.02 * random.random((size, size))).astype(np.float16) for name in "RGB"}
        return write_frame(self.folder / "n.0001.exr", channels, compression=PIZ)

    def test_zeros_anywhere_in_a_chunk_are_found(self):
        whole = self.noisy().read_bytes()
        header = parse_header(whole)
        first, second = struct.unpack_from("<2Q", whole, header.end)
        self.assertEqual(list(chunk_faults(header, whole)), [])
        for at in range(first + 4000, second - 100, 997):
            damaged = whole[:at] + bytes(64) + whole[at + 64 :]
            (fault,) = chunk_faults(header, damaged)
            self.assertRegex(
                fault, r"chunk 1 of 3 \(rows 0 to 31\) has 32 zeros and more in a row at byte \d+"
            )

    def test_pictures_full_of_zeros_are_not_accused(self):
        """A constant picture, one that is mostly black, one of few values, and one that
        is stored as it is."""
        y, x = np.mgrid[:96, :96]
        spots = np.where((x % 48 == 0) & (y % 40 == 0), 7.0, 0.0)
        random = np.random.default_rng(3)
        for values in (
            np.zeros((96, 96)),
            np.ones((96, 96)),
            spots,
            x // 48 * 1.0,
            np.where(x > 60, random.random((96, 96)), 0),
        ):
            for kind in (np.float16, np.float32):
                channels = {name: values.astype(kind) for name in "RGB"}
                data = write_frame(self.folder / "x.exr", channels, compression=PIZ).read_bytes()
                self.assertEqual(list(chunk_faults(parse_header(data), data)), [])
        tiny = {"R": np.zeros((1, 64), np.float32), "G": np.zeros((1, 64), np.float32)}
        data = write_frame(self.folder / "x.exr", tiny, compression=PIZ).read_bytes()
        self.assertEqual(list(chunk_faults(parse_header(data), data)), [])


class Motion(WithFolder):
    def found_with(self, motion: np.ndarray) -> list[int | None]:
        good_sequence(self.folder)
        rewrite(
            frame_path(self.folder, 6), lambda channels: {**channels, "Vector.X": motion.astype(np.float32)}
        )
        return self.found("motion")

    def test_near_the_cameras_plane_is_without_bound(self):
        """A camera that turns by 45 degrees: a column of points was in its plane, and motion falls
        off to either side."""
        width, height = 32, 18
        column = np.arange(width) - 20.001
        self.assertEqual(self.found_with(np.tile((width / 2) ** 2 / column, (height, 1))), [])

    def test_of_a_leaf_that_passes_by_is_large(self):
        motion = np.zeros((18, 32))
        motion[4:12, 9:20] = 32 * 150.0
        self.assertEqual(self.found_with(motion), [])
        motion[:] = 0
        motion[7, 5] = 32 * 150.0
        self.assertEqual(self.found_with(motion), [6])
