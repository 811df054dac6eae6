"""Every kind of damage is found by the check that is there for it; good frames are not accused."""

import tempfile
import unittest
from pathlib import Path

from sunfleck_tools import Options, validate
from sunfleck_tools.exr.file_hash import NAME, file_hash
from sunfleck_tools.exr.header import parse_header
from sunfleck_tools.findings import CHECKS

from .damages import DAMAGES, VICTIM, seal_all
from .files import DATA, flip, frame_path, good_sequence, rewrite

HERE = Options(processes=0)
ROOT = Path(__file__).parents[2]
# They need more than one folder, or are made elsewhere.
TESTED_APART = {"unexpected-frame", "unreadable", "unsupported", "reference", "reference-missing"}


class Damaged(unittest.TestCase):
    def test_each_is_found_where_it_is(self):
        for entry in DAMAGES:
            with self.subTest(entry.what), tempfile.TemporaryDirectory() as scratch:
                folder = good_sequence(Path(scratch))
                entry.make(folder)
                report = validate(folder, HERE)
                found = {finding.frame for finding in report.findings if finding.check == entry.found_by}
                self.assertEqual(found, set(entry.frames))

    def test_each_check_has_a_damage(self):
        damaged = {entry.found_by for entry in DAMAGES} | TESTED_APART
        self.assertEqual(damaged, set(CHECKS))

    def test_the_page_has_each_check_and_says_how_many_damages_there_are(self):
        text = (ROOT / "docs/validate.md").read_text()
        self.assertIn(f"{len(DAMAGES)} kinds of damage (`tools/tests/damages.py`)", text)
        for check in CHECKS.values():
            self.assertIn(f"| `{check.id}` | {check.severity.value} | {check.about} |", text)

    def test_a_file_cut_off_at_forty_places(self):
        with tempfile.TemporaryDirectory() as scratch:
            folder = good_sequence(Path(scratch))
            path = frame_path(folder, VICTIM)
            whole = path.read_bytes()
            for cut in range(40):
                path.write_bytes(whole[: len(whole) * cut // 40])
                report = validate(folder, HERE)
                self.assertEqual([finding.frame for finding in report.findings][:1], [VICTIM], cut)
                self.assertEqual(report.rerender, [VICTIM])

    def test_one_chunk_more_is_not_several(self):
        whole = (DATA / "leaf.0001.exr").read_bytes()
        table = parse_header(whole).end
        with tempfile.TemporaryDirectory() as scratch:
            path = Path(scratch) / "leaf.0001.exr"
            path.write_bytes(whole[:table] + bytes(16) + whole[table + 16 :])
            lines = [finding.line() for finding in validate(path, HERE).findings if finding.check == "chunks"]
        self.assertEqual(len(lines), 1)
        self.assertIn("was never written, and 1 more chunk is damaged", lines[0])

    def test_any_byte_may_be_wrong_without_a_traceback(self):
        for compression in (0, 3, 4):
            with tempfile.TemporaryDirectory() as scratch:
                path = Path(scratch) / "leaf.0001.exr"
                path.write_bytes((DATA / "leaf.0001.exr").read_bytes())
                rewrite(path, compression=compression)
                whole = path.read_bytes()
                # All of the header's, where lengths and counts are, and some of the pixels'.
                for at in [*range(0, 1600, 19), *range(1600, len(whole), 1999)]:
                    path.write_bytes(whole)
                    flip(path, at)
                    validate(path, HERE)


class Sealed(unittest.TestCase):
    """The renderer's own frames, with hashes of their files."""

    def test_any_bit_of_the_file_counts(self):
        with tempfile.TemporaryDirectory() as scratch:
            folder = good_sequence(Path(scratch), "sealed")
            path = frame_path(folder, 2, "sealed")
            whole = path.read_bytes()
            for at in range(0, len(whole), 7):
                path.write_bytes(whole)
                flip(path, at, 1 << at % 8)
                self.assertIn(2, [finding.frame for finding in validate(folder, HERE).findings], at)

    def test_hashes_are_the_renderers(self):
        whole = (DATA / "sealed.0001.exr").read_bytes()
        said, found = file_hash(whole)
        self.assertEqual(said, found)
        self.assertNotEqual(*file_hash(whole + b"\0"))
        self.assertIsNone(file_hash(b"no file"))

    def test_damage_of_pixels_is_said_once(self):
        with tempfile.TemporaryDirectory() as scratch:
            folder = good_sequence(Path(scratch))
            path = seal_all(folder)
            rewrite(path, lambda channels: channels["R"].fill(0.5), extra={NAME: "0" * 64}, sign=False)
            found = [
                finding.check for finding in validate(folder, HERE).findings if "hash" in finding.message
            ]
        self.assertEqual(found, ["pixel-hash"])


class Good(unittest.TestCase):
    def test_frames_as_rendered(self):
        for name in sorted({path.name.split(".")[0] for path in DATA.glob("*.exr")}):
            with tempfile.TemporaryDirectory() as scratch:
                report = validate(good_sequence(Path(scratch), name), HERE)
                self.assertEqual([finding.line() for finding in report.findings], [], name)

    def test_every_compression(self):
        for compression in (0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 13):
            with tempfile.TemporaryDirectory() as scratch:
                folder = good_sequence(Path(scratch))
                # Lossy ones make shafts brighter than the beauty: here it is the container that is tested.
                skipped = frozenset(
                    ["beauty-sum", "depth", "normal-length", "leaf-id", "negative", "alpha-range"]
                )
                for number in range(5, 13):
                    frame_path(folder, number).unlink()
                for path in folder.iterdir():
                    rewrite(path, compression=compression)
                report = validate(folder, Options(processes=0, skip_checks=skipped))
                self.assertEqual([finding.line() for finding in report.findings], [], compression)
