"""Headers and chunks: what exactly is said of a damaged file, before any decoder sees it."""

import struct
import unittest
from fractions import Fraction

import numpy as np

from sunfleck_tools.exr.chunks import chunk_faults
from sunfleck_tools.exr.decode import claims_too_much
from sunfleck_tools.exr.half import extremes, plain, scaled_into, widened
from sunfleck_tools.exr.header import HeaderError, TimeCode, parse_header

from .files import DATA

WHOLE = (DATA / "leaf.0001.exr").read_bytes()
HEADER = parse_header(WHOLE)
OFFSETS = struct.unpack_from("<2Q", WHOLE, HEADER.end)


class Headers(unittest.TestCase):
    def test_of_a_frame_as_rendered(self):
        self.assertEqual((HEADER.size, HEADER.compression), ((32, 18), 3))
        self.assertEqual(HEADER.values["framesPerSecond"], Fraction(24))
        # 14 halves and 8 floats a pixel.
        self.assertEqual(HEADER.pixel_bytes, 32 * 18 * (14 * 2 + 8 * 4))
        self.assertIsNone(claims_too_much([HEADER], len(WHOLE)))
        self.assertIn("32 x 18 pixels", claims_too_much([HEADER], 8))

    def test_cut_off_anywhere(self):
        for end in range(HEADER.end):
            with self.assertRaises(HeaderError):
                parse_header(WHOLE[:end])

    def test_time_codes_are_binary_coded_decimals(self):
        # 01:02:03:04
        self.assertEqual(TimeCode(0x01020304).frame(24), ((60 + 2) * 60 + 3) * 24 + 4)
        self.assertEqual(TimeCode(0x23595923).frame(24), 24 * 3600 * 24 - 1)


class Chunks(unittest.TestCase):
    def faults(self, data: bytes) -> list[str]:
        return list(chunk_faults(HEADER, data))

    def test_whole(self):
        self.assertEqual(self.faults(WHOLE), [])

    def test_cut_off_within_the_last(self):
        size = len(WHOLE) - OFFSETS[1] - 8
        expected = f"chunk 2 of 2 (rows 16 to 17) has {size} bytes, of which the file holds {size - 1}"
        self.assertEqual(self.faults(WHOLE[:-1]), [expected])

    def test_cut_off_before_the_last(self):
        end = OFFSETS[1]
        expected = f"chunk 2 of 2 (rows 16 to 17) lies outside of the file, at byte {end} of {end}"
        self.assertEqual(self.faults(WHOLE[:end]), [expected])

    def test_cut_off_within_the_table(self):
        self.assertEqual(self.faults(WHOLE[: HEADER.end + 9]), ["the file ends within its table of 2 chunks"])

    def test_of_another_row(self):
        data = bytearray(WHOLE)
        struct.pack_into("<i", data, OFFSETS[1], 3)
        self.assertEqual(
            self.faults(bytes(data)), ["chunk 2 of 2 (rows 16 to 17) says that it begins at row 3"]
        )

    def test_never_written(self):
        data = bytearray(WHOLE)
        struct.pack_into("<Q", data, HEADER.end, 0)
        self.assertEqual(self.faults(bytes(data)), ["chunk 1 of 2 (rows 0 to 15) was never written"])


class Halves(unittest.TestCase):
    EVERY = np.arange(1 << 16, dtype=np.uint16).view(np.float16)

    def same(self, values: np.ndarray) -> None:
        np.testing.assert_array_equal(widened(values), values.astype(np.float32))

    def test_each_is_widened_to_itself(self):
        with np.errstate(invalid="ignore"):
            self.same(self.EVERY)
        finite = self.EVERY[np.isfinite(self.EVERY)]
        self.same(finite)
        self.same(finite[finite >= 0])
        np.testing.assert_array_equal(np.signbit(widened(finite)), np.signbit(finite))

    def test_products_of_plain_ones_are_those_of_the_floats(self):
        values = self.EVERY[: 0x7C00]
        self.assertTrue(plain(*extremes(values)))
        out = np.empty(values.shape, np.float32)
        for factor in (np.float32(0.2126), np.float32(0.0722), np.float32(1)):
            scaled_into(values, factor, out)
            np.testing.assert_array_equal(out, values.astype(np.float32) * factor)
        for other in (-0.0, -1.0, np.inf, np.nan):
            self.assertFalse(plain(*extremes(np.array([1, other], np.float16))), other)

    def test_extremes_are_those_of_the_floats(self):
        random = np.random.default_rng(1)
        for low, high in (
            (0x0000, 0x7C01),
            (0x0000, 0xFC01),
            (0x8000, 0xFC01),
            (0x0000, 0x10000),
            (0x7B00, 0x7D00),
        ):
            for _ in range(200):
                values = random.integers(low, high, 3).astype(np.uint16).view(np.float16)
                found = np.array(extremes(values))
                expected = np.array([values.astype(np.float64).min(), values.astype(np.float64).max()])
                np.testing.assert_array_equal(found, expected, values)
