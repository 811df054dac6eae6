"""Deep EXR files in `sunfleck diff` and `preview`: flattened as OpenEXR's `CompositeDeepScanLine` does."""

from __future__ import annotations

import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy as np

from sunfleck_tools.exr.header import parse_header

from .command import NO_PROGRAM, PROGRAM

try:
    import OpenEXR
except ImportError:
    OpenEXR = None

SIZE = 9, 14
COLORS = ("R", "G", "B", "A")


def samples(seed: int, names: tuple[str, ...], kind: type) -> dict[str, np.ndarray]:
    """Up to four samples a pixel, in no order; none in one row and in many pixels."""
    rng = np.random.default_rng(seed)
    counts = rng.integers(0, 5, SIZE)
    counts[2] = 0
    ranges = {"Z": (1, 9), "ZBack": (9, 10), "A": (0, 0.9)}
    channels = {name: np.empty(SIZE, dtype=object) for name in names}
    for place, count in np.ndenumerate(counts):
        for name, channel in channels.items():
            if name == "id":
                channel[place] = rng.integers(1, 1000, count).astype(np.uint32) if count else None
            else:
                dtype = np.float32 if name.startswith("Z") else kind
                channel[place] = rng.uniform(*ranges.get(name, (0, 1)), count).astype(dtype) if count else None
    return channels


def flat(channels: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Each sample over those behind it; of whole numbers the nearest."""
    pictures = {name: np.zeros(SIZE, np.uint32 if name == "id" else np.float32) for name in channels}
    for place in np.ndindex(SIZE):
        depths = channels["Z"][place]
        if depths is None:
            continue
        covered = np.float32(0)
        for number, sample in enumerate(np.argsort(depths)):
            for name, picture in pictures.items():
                if name != "id":
                    picture[place] += (1 - covered) * np.float32(channels[name][place][sample])
                elif number == 0:
                    picture[place] = channels[name][place][sample]
            covered = pictures["A"][place]
    return pictures


@unittest.skipUnless(PROGRAM and OpenEXR, NO_PROGRAM)
class Deep(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def write(self, name: str, channels: dict, **header: object) -> Path:
        path = self.folder / name
        flat = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
        # Which makes its own of what it is given.
        OpenEXR.File(flat | header, dict(channels)).write(str(path))
        return path

    def run_program(self, *arguments: object) -> subprocess.CompletedProcess:
        return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, check=False)

    def kinds(self):
        compressions = OpenEXR.NO_COMPRESSION, OpenEXR.RLE_COMPRESSION, OpenEXR.ZIPS_COMPRESSION
        for number, compression in enumerate(compressions):
            for kind in (np.float16, np.float32):
                yield number, {"compression": compression, "type": OpenEXR.deepscanline}, kind
                tiles = {"tiles": OpenEXR.TileDescription()}
                yield number, {"compression": compression, "type": OpenEXR.deeptile} | tiles, kind

    def test_samples_lie_over_those_behind_them(self):
        for names in ((*COLORS, "Z", "ZBack", "id"), (*COLORS, "Z")):
            for seed, header, kind in self.kinds():
                channels = samples(seed, names, kind)
                deep = self.write("deep.exr", channels, **header)
                pictures = flat(channels)
                expected = self.write("flat.exr", pictures)
                found = self.run_program("diff", deep, expected, "--max-error", "1e-6")
                self.assertEqual(found.returncode, 0, found.stdout + found.stderr)
                pictures["G"][4, 5] += 0.01
                other = self.write("other.exr", pictures)
                self.assertEqual(self.run_program("diff", deep, other, "--max-error", "1e-6").returncode, 5)
        (self.folder / "frames").mkdir()
        deep.rename(self.folder / "frames/deep.0001.exr")
        shown = self.run_program("preview", self.folder / "frames", "--out", self.folder / "shown.png")
        self.assertEqual(shown.returncode, 0, shown.stdout + shown.stderr)

    def test_without_alpha_the_nearest_is_seen_and_without_depth_the_first(self):
        header = {"compression": OpenEXR.ZIPS_COMPRESSION, "type": OpenEXR.deepscanline}
        for names in (("R", "G", "B", "Z"), ("Z",), ("R", "G", "B")):
            channels = samples(1, names, np.float16)
            pictures = {name: np.zeros(SIZE, np.float32) for name in names}
            for place, found in np.ndenumerate(channels[names[-1]]):
                if found is not None:
                    seen = np.argmin(found) if "Z" in names else 0
                    for name, picture in pictures.items():
                        picture[place] = channels[name][place][seen]
            deep, expected = self.write("deep.exr", channels, **header), self.write("flat.exr", pictures)
            found = self.run_program("diff", deep, expected, "--max-error", "0")
            self.assertEqual(found.returncode, 0, found.stdout + found.stderr)

    def test_what_is_deep_is_in_the_flags_whatever_the_type_says(self):
        """Of a file of one part, as OpenEXR has it."""
        flat = self.write("flat.exr", {"Z": np.ones(SIZE, np.float32)})
        data = flat.read_bytes()
        value, table = data.index(b"type\0string\0") + 12, parse_header(data).end
        self.assertEqual(data[value : value + 17], b"\x0d\0\0\0scanlineimage")
        chunk = int.from_bytes(data[table : table + 8], "little") - 1
        other = self.folder / "other.exr"
        other.write_bytes(
            data[:value] + b"\x0c\0\0\0deepscanline" + data[value + 17 : table] + chunk.to_bytes(8, "little") + data[table + 8 :]
        )
        found = self.run_program("diff", other, flat, "--max-error", "0")
        self.assertEqual(found.returncode, 0, found.stdout + found.stderr)

    def test_damaged_files_are_answered(self):
        """Cut short anywhere, and with any byte of a lattice changed."""
        header = {"compression": OpenEXR.ZIPS_COMPRESSION, "type": OpenEXR.deepscanline}
        whole = self.write("deep.exr", samples(1, (*COLORS, "Z"), np.float16), **header).read_bytes()
        path = self.folder / "damaged.exr"
        cut = [whole[:length] for length in range(0, len(whole), 211)]
        changed = [whole[:at] + bytes([whole[at] ^ 0x91]) + whole[at + 1 :] for at in range(4, len(whole), 61)]
        for damaged in cut + changed:
            path.write_bytes(damaged)
            found = self.run_program("diff", path, path)
            self.assertIn(found.returncode, (0, 4), found.stderr)
            self.assertNotIn("panicked", found.stderr)


if __name__ == "__main__":
    unittest.main()
