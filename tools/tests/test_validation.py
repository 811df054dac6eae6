"""What the report says, and what the command line makes of it."""

import json
import os
import struct
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import numpy as np

from sunfleck_tools import Options, SequenceError, validate
from sunfleck_tools.frame_list import format_frames, parse_frames
from sunfleck_tools.parallel import in_processes

from .command import run
from .damages import set_value
from .damages import scaled
from .files import frame_path, good_sequence, rewrite
from .json_schema import faults

SCHEMA = Path(__file__).parents[1] / "sunfleck_tools/validate.schema.json"
HERE = Options(processes=0)


def die(argument: int) -> int:
    """Kills its process for one argument, as a crashing decoder does."""
    if argument == 3:
        os._exit(11)
    return argument


class WithSequence(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = good_sequence(Path(scratch.name) / "frames")


class ByItself(WithSequence):
    def test_a_picture_whose_name_has_no_number_is_any_frame(self):
        still = self.folder.parent / "still.exr"
        still.write_bytes(frame_path(self.folder, 7).read_bytes())
        self.assertEqual(validate(still, HERE).findings, [])
        numbered = still.rename(still.with_name("still.0008.exr"))
        self.assertEqual({finding.check for finding in validate(numbered, HERE).findings}, {"image-counter"})


class FrameLists(unittest.TestCase):
    def test_read_as_render_reads_them(self):
        for text, frames in (
            ("7", [7]),
            ("-3--1", [-3, -2, -1]),
            ("1..5x2,9", [1, 3, 5, 9]),
            ("1-4:3", [1, 4]),
        ):
            self.assertEqual(parse_frames(text), frames)
        for text in ("", "a", "5-1", "1-5x0", "1,,2", "1-99999999999"):
            with self.assertRaises(ValueError):
                parse_frames(text)

    def test_written_so_that_they_are_read_again(self):
        for frames in ([], [1], [1, 2, 3, 5], [-4, -3, 0, 2]):
            text = format_frames(frames)
            self.assertEqual(parse_frames(text) if text else [], frames)


class CommandLine(WithSequence):
    def test_good_frames_exit_with_0(self):
        code, out, err = run("validate", self.folder, "--processes", "1")
        self.assertEqual((code, err), (0, ""))
        self.assertIn("12 frames, 1-12: nothing found", out)

    def test_the_worst_frame_is_in_the_first_line_and_what_to_render_in_the_last(self):
        frame_path(self.folder, 4).write_bytes(b"")
        frame_path(self.folder, 9).unlink()
        code, out, _ = run("validate", self.folder / "leaf.####.exr")
        self.assertEqual(code, 1)
        self.assertIn("error: frame 4: the file is empty [empty-file]", out.splitlines()[0])
        self.assertIn("render again: 4,9", out.splitlines()[-1])
        self.assertEqual(run("validate", self.folder, "--list-missing")[:2], (1, "4,9\n"))

    def test_where_nothing_is_missing_render_is_told_so(self):
        # tests/cli/frames.rs: `sunfleck render --frames none` ends well.
        self.assertEqual(run("validate", self.folder, "--list-missing")[:2], (0, "none\n"))

    def test_a_list_that_was_asked_for_is_no_failure(self):
        listed = self.folder.parent / "missing.txt"
        frame_path(self.folder, 4).unlink()
        code, out, _ = run("validate", self.folder, "--write-missing", listed)
        self.assertEqual((code, listed.read_text()), (0, "4\n"))
        self.assertIn("render again: 4", out)
        self.assertEqual(
            run("validate", self.folder, "--list-missing", "--write-missing", listed.parent / "no" / "x")[0],
            4,
        )

    def test_warnings_fail_only_if_asked_to(self):
        rewrite(frame_path(self.folder, 4), texts={"seed": "3"})
        self.assertEqual(run("validate", self.folder)[0], 0)
        self.assertEqual(run("validate", self.folder, "--fail-on", "warning")[0], 1)
        self.assertEqual(
            run("validate", self.folder, "--fail-on", "warning", "--skip-checks", "mixed-seed")[0], 0
        )

    def test_what_cannot_be_used_says_why(self):
        empty = self.folder.parent / "empty"
        empty.mkdir()
        for code, *arguments in (
            (4, self.folder / "none"),
            (4, empty),
            (4, self.folder / "other.####.exr"),
            (2, self.folder, "--frames", "9-1"),
            (2, self.folder, "--fps", "0"),
            (2, self.folder, "--skip-checks", "nothing"),
            (2, self.folder, "--max-flip", "0.1"),
            (2, self.folder, "--max-relmse", "0.1"),
            (2, self.folder, "--processes", "0"),
            (4, self.folder, "--html", self.folder / "none/report.html"),
            (2, self.folder, "--html", frame_path(self.folder, 1)),
            (2, self.folder, "--write-missing", frame_path(self.folder, 1)),
            (4, self.folder, "--stats", self.folder / "none.jsonl"),
            (2, self.folder, "--stats", frame_path(self.folder, 1)),
            (2,),
        ):
            found, out, err = run("validate", *arguments)
            self.assertEqual(found, code, (arguments, err))
            self.assertIn("error", err)
            self.assertNotIn("Traceback", err)
        self.assertEqual(run("render")[0], 2)

    def test_frames_and_rate_that_were_asked_for(self):
        code, out, _ = run("validate", self.folder, "--frames", "1-14", "--fps", "24")
        self.assertEqual(code, 1)
        self.assertIn("frame 13: there is no leaf.0013.exr [missing-frame]", out)
        report = validate(self.folder, Options(processes=0, frames=tuple(range(3, 13))))
        self.assertEqual([f.frame for f in report.findings if f.check == "unexpected-frame"], [1, 2])
        self.assertIn("[frame-rate]", run("validate", self.folder, "--fps", "25")[1])

    def test_frames_that_nobody_asked_for_are_only_named(self):
        """So a smaller job in the folder of a larger one can succeed."""
        frame_path(self.folder, 1).write_bytes(b"")
        code, out, _ = run("validate", self.folder, "--frames", "2-12")
        self.assertEqual(code, 0, out)
        self.assertIn("frame 1: it is none of 2-12, and was not looked at [unexpected-frame]", out)
        out = run("validate", self.folder, "--frames", "20,21")[1]
        self.assertIn("0 frames: 2 errors, 12 warnings; render again: 20-21", out)

    def test_frames_that_the_scene_has_not_are_only_named(self):
        """Render would refuse a list with them."""
        for number in range(1, 13):
            rewrite(frame_path(self.folder, number), texts={"sequenceFrames": "1-12"})
        frame_path(self.folder, 2).rename(self.folder / "leaf.-001.exr")
        out = run("validate", self.folder)[1]
        self.assertIn("frame -1: it is none of 1-12, and was not looked at [unexpected-frame]", out)
        self.assertIn("11 frames, 1,3-12: 1 error, 1 warning; render again: 2", out)

    def test_padding_of_negative_numbers_is_ours_or_printfs(self):
        for name, number in (("leaf.-0001.exr", 1), ("leaf.-002.exr", 2), ("leaf.-03.exr", 3)):
            frame_path(self.folder, number).rename(self.folder / name)
        report = validate(self.folder, HERE)
        self.assertEqual([f.frame for f in report.findings if f.check == "mixed-padding"], [-3])

    def test_json_follows_its_schema(self):
        frame_path(self.folder, 4).write_bytes(b"")
        rewrite(frame_path(self.folder, 7), set_value("R", np.inf))
        stats = self.folder.parent / "stats.jsonl"
        stats.write_text(
            '{"frame": 2, "outcome": "written", "render_seconds": 1.5}\n{"frame": 3, "outcome": "skipped"}\n'
        )
        code, out, _ = run("validate", self.folder, "--json", "--stats", stats)
        report = json.loads(out)
        self.assertEqual(list(faults(report, json.loads(SCHEMA.read_text()))), [])
        self.assertEqual((code, report["sequence"]["rerender"]), (1, "4,7"))
        self.assertEqual(report["frames"][1]["render_seconds"], 1.5)
        infinity = next(finding for finding in report["findings"] if finding["check"] == "infinity")
        self.assertEqual((infinity["channel"], infinity["pixel"]), ("R", [5, 7]))

    def test_the_list_of_checks(self):
        self.assertIn("pixel-hash", run("validate", "--list-checks")[1])


class Apart(WithSequence):
    def found(self, check: str, **options: object) -> list[int | None]:
        report = validate(self.folder, Options(processes=0, **options))
        return [finding.frame for finding in report.findings if finding.check == check]

    def test_references(self):
        reference = good_sequence(self.folder.parent / "reference")
        self.assertEqual(self.found("reference", reference=reference), [])
        rewrite(frame_path(self.folder, 5), lambda c: {**c, "R": c["R"] * np.float16(2)})
        frame_path(reference, 6).unlink()
        frame_path(reference, 7).write_bytes(b"")
        rewrite(frame_path(reference, 8), lambda c: {name: values[:-1] for name, values in c.items()})
        self.assertEqual(self.found("reference", reference=reference), [5])
        self.assertEqual(self.found("reference-missing", reference=reference), [6, 7, 8])
        # As of `sunfleck diff`, 0 asks for equality.
        out = run("validate", self.folder, "--reference", reference, "--max-relmse", 0)[1]
        self.assertEqual(out.count("[reference]"), 1, out)

    def test_deep_data_is_named(self):
        path = frame_path(self.folder, 5)
        data = bytearray(path.read_bytes())
        struct.pack_into("<I", data, 4, struct.unpack_from("<I", data, 4)[0] | 0x800)
        path.write_bytes(bytes(data))
        self.assertEqual(self.found("unsupported"), [5])

    def test_a_file_that_the_system_withholds(self):
        with mock.patch.object(Path, "open", side_effect=PermissionError(13, "Permission denied")):
            self.assertEqual(self.found("unreadable"), list(range(1, 13)))
        path = frame_path(self.folder, 5)
        path.unlink()
        path.symlink_to("nowhere")
        self.assertEqual(validate(self.folder, HERE).rerender, [5])

    def test_a_lit_gap_that_lasts_is_no_firefly(self):
        def spike(channels):
            for letter in "RGB":
                channels[letter][7, 5] = 500

        rewrite(frame_path(self.folder, 5), spike)
        self.assertEqual(self.found("firefly"), [5])
        rewrite(frame_path(self.folder, 6), spike)
        self.assertEqual(self.found("firefly"), [])

    def test_a_rest_at_the_end_is_not_stuck_and_a_still_sequence_is(self):
        for number in (11, 12):
            frame_path(self.folder, number).write_bytes(frame_path(self.folder, 10).read_bytes())
            rewrite(frame_path(self.folder, number), counter=number)
        self.assertEqual(self.found("stuck"), [])
        for number in range(2, 13):
            frame_path(self.folder, number).write_bytes(frame_path(self.folder, 1).read_bytes())
        self.assertEqual(self.found("stuck"), [2])

    def test_black_frames_that_are_meant_so_are_not_accused(self):
        """A fade to black and back, a beginning before there is light."""

        def light(number: int, factor: float) -> None:
            rewrite(frame_path(self.folder, number), lambda channels: scaled(channels, factor))

        for number, factor in {3: 0.6, 4: 0.3, 5: 0.05, 6: 0, 7: 0, 8: 0.05, 9: 0.3, 10: 0.6}.items():
            light(number, factor)
        self.assertEqual([f.check for f in validate(self.folder, HERE).findings if f.check != "pop"], [])
        for number in (1, 2, 3):
            light(number, 0)
        self.assertEqual(self.found("black"), [])
        # Between 0.3 and 1.
        light(10, 0)
        self.assertEqual(self.found("black"), [10])

    def test_ids_of_cryptomatte_may_be_any_floats(self):
        for path in self.folder.iterdir():
            rewrite(path, lambda c: {**c, "CryptoObject00.R": np.full_like(c["Z"], -1.5e-20)})
        self.assertEqual([f.line() for f in validate(self.folder, HERE).findings], [])

    def test_no_sequence_at_all(self):
        with self.assertRaises(SequenceError):
            validate(self.folder / "x.exr", HERE)


class Processes(WithSequence):
    def test_a_script_needs_no_guard(self):
        text = f"import sunfleck_tools as s\nprint(len(s.validate({str(self.folder)!r}, s.Options(processes=2)).frames))\nprint(__spec__)\n"
        script = self.folder.parent / "script.py"
        script.write_text(text)
        for name, given in ((script, ""), ("-", text)):
            environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
            ran = subprocess.run(
                [sys.executable, name], input=given, capture_output=True, text=True, env=environment
            )
            self.assertEqual((ran.stdout, ran.stderr), ("12\nNone\n", ""))

    def test_one_that_dies_takes_no_other_along(self):
        results = list(in_processes(die, range(6), 2, lambda argument: -argument))
        self.assertEqual(results, [0, 1, 2, -3, 4, 5])
