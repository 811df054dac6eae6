"""Figures in documents are those of the one table (tools/figures)."""

import contextlib
import importlib.machinery
import importlib.util
import io
import os
import re
import shutil
import sys
import unittest
from dataclasses import replace
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def tool():
    """The script as a module; its name has no ending."""
    loader = importlib.machinery.SourceFileLoader("figures", str(ROOT / "tools/figures"))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("figures", loader))
    sys.modules["figures"] = module
    loader.exec_module(module)
    return module


figures = tool()


class Documents(unittest.TestCase):
    """What is committed."""

    def test_every_figure_is_the_tables(self):
        self.assertEqual(figures.check(figures.load()), [])

    def test_rows_are_whole(self):
        rows = figures.load()
        self.assertEqual(len({row.id for row in rows}), len(rows))
        for row in rows:
            with self.subTest(row.id):
                self.assertRegex(row.date, r"^20\d\d-\d\d-\d\d$")
                self.assertTrue(row.value and row.command and row.machine and row.commit)
                self.assertGreater(float(row.minutes), 0)
                if row.read not in ("", "wall", "cpu", "memory"):
                    self.assertEqual(re.compile(row.read).groups, 1)

    def test_benches_and_files_of_commands_are_there(self):
        benches = (ROOT / "benches/figures/main.rs").read_text(encoding="utf-8")
        for command in sorted({row.command for row in figures.load()}):
            with self.subTest(command):
                for bench in re.findall(r"--bench figures -- ([\w-]+)", command):
                    self.assertIn(f'Some("{bench}")', benches)
                for module in re.findall(r"-m (tests\.\w+)", command):
                    self.assertTrue((ROOT / "tools" / module.replace(".", "/")).with_suffix(".py").is_file())
                for path in re.findall(r"(?:tests/data|sequences|tools/peers|benches)/[\w/.]+", command):
                    self.assertTrue((ROOT / path).exists(), path)


class Rule(unittest.TestCase):
    """What counts as a figure."""

    row = figures.Figure(
        id="frame", topic="t", what="a frame", column="", value="93", unit="s", command="sunfleck render x",
        read="wall", minutes="1", date="2020-01-02", machine="a machine", commit="abc",
    )  # fmt: skip

    def found(self, text, quoting=True):
        return figures.findings(text, [self.row], quoting)

    def test_numbers_that_are_measured_are_links(self):
        for text in ["It takes 93 s.", "302 times", "2 %", "1.5e-7", "| 609 MB |", "12 ms", "0.9 CPU s"]:
            self.assertEqual(len(self.found(text)), 1, text)

    def test_links_limits_and_records_are_none(self):
        for text in [
            "It takes [93 s](../figures.md#frame), so [93](figures.md#frame).",
            "open for `0.5 s`, at most `10 %`",
            "```\n93 s\n```",
            "## Lost\n\nMeasured 2026-11-22, a machine: it took 99 s.",
            "10 m wide, 24 frames, 1920x1080, three times, step 4",
        ]:
            self.assertEqual(self.found(text), [], text)

    def test_quotations_follow_the_table(self):
        old = "[94 s](../figures.md#frame), [94](figures.md#frame), [how](figures.md#g), [94 s](other.md#a)"
        new = "[93 s](../figures.md#frame), [93](figures.md#frame), [how](figures.md#g), [94 s](other.md#a)"
        self.assertEqual(figures.requoted(old, [self.row]), new)

    def test_columns_of_a_unit_hold_links(self):
        table = "| what | seconds | rays |\n|---|---|---|\n| a | 93 | 4 |\n| b | [93](figures.md#frame) | 8 |"
        self.assertEqual(self.found(table), ["3: '93' is no link to a row"])

    def test_a_record_ends_with_its_section(self):
        found = self.found("## Lost\nMeasured 2026-11-22.\n## Kept\nIt takes 99 s.")
        self.assertEqual(found, ["4: '99 s' is no link to a row"])

    def test_links_say_what_the_row_says(self):
        self.assertEqual(len(self.found("[94 s](figures.md#frame)", quoting=False)), 1)
        self.assertEqual(len(self.found("[93 s](figures.md#no-such-row)", quoting=False)), 1)
        self.assertEqual(self.found("[how](figures.md#how-time-grows)", quoting=False), [])
        self.assertEqual(self.found("93 s", quoting=False), [])


class Page(unittest.TestCase):
    """What is printed of the table."""

    usual = replace(Rule.row, id="other", what="another", value="7")
    rows = [Rule.row, usual]

    def test_a_unit_stands_in_the_head_of_its_column(self):
        self.assertIn("|  | s |\n|---|---|\n", figures.markdown(self.rows))
        mixed = figures.markdown([Rule.row, replace(self.usual, unit="MB")])
        self.assertIn("|  | value |\n|---|---|\n", mixed)
        self.assertIn("7 MB", mixed)

    def test_two_commands_of_one_thing_are_two_tables(self):
        self.assertIn("| by |", figures.markdown([Rule.row, replace(self.usual, command="sunfleck render y")]))
        same = [Rule.row, replace(Rule.row, id="other", column="memory", command="sunfleck render y")]
        self.assertEqual(figures.markdown(same).count("|---|---|\n"), 2)

    def test_rows_that_documents_cite_have_an_anchor(self):
        printed = figures.markdown(self.rows, cited={"frame"})
        self.assertIn('<a id="frame"></a>93 |', printed)
        self.assertIn("| another | 7 |", printed)

    def places(self, *marks):
        return "".join(f"<!-- {mark} -->\n<!-- end -->\n" for mark in marks)

    def test_where_it_was_measured_is_told_unless_it_is_the_usual_place(self):
        elsewhere = replace(Rule.row, topic="u", machine="an old one")
        text = figures.page(
            self.places("figures: usual", "figures: t", "figures: u"), [*self.rows, elsewhere], {"frame"}
        )
        head, usual, other = text.split("<!-- end -->\n")[:3]
        self.assertIn("*2020-01-02, a machine; abc*", head)
        self.assertNotIn("a machine", usual)
        self.assertIn("*2020-01-02, an old one; abc*", other)

    def test_a_place_may_have_what_documents_quote_alone(self):
        text = figures.page(self.places("figures: usual", "cited: t"), self.rows, {"frame"})
        self.assertIn("| a frame |", text)
        self.assertNotIn("| another |", text)

    def test_what_documents_quote_needs_a_place(self):
        self.assertTrue(figures.page(self.places("figures: usual"), self.rows, set()))
        with self.assertRaisesRegex(SystemExit, "one place for the topic 't'"):
            figures.page(self.places("figures: usual"), self.rows, {"frame"})


@contextlib.contextmanager
def silent():
    """What the script says as it measures is no result of a test."""
    with contextlib.redirect_stdout(io.StringIO()):
        yield


@unittest.skipUnless(hasattr(os, "wait4") and shutil.which("bash"), "measures where there are bash and wait4")
class Measuring(unittest.TestCase):
    """A row measured anew."""

    def test_values_are_read_from_what_is_printed(self):
        row = replace(Rule.row, command="echo 'frame 24: 12.5 s'", read=r"frame 24: ([\d.]+)")
        other = replace(row, id="other", value="7")
        with silent():
            measured, kept = figures.measure([row, other], {"frame"})
        self.assertEqual((measured.value, kept), ("12.5", other))
        self.assertNotEqual(measured.date, row.date)

    def test_the_clock_and_memory_are_the_commands(self):
        with silent():
            printed, meters = figures.run("sleep 0.3; echo done")
        self.assertEqual(printed, "done\n")
        self.assertGreaterEqual(float(meters["wall"]), 0.3)
        self.assertLess(float(meters["cpu"]), 0.3)
        self.assertGreater(float(meters["memory"]), 0.5)

    def test_a_command_that_fails_or_prints_something_else_stops(self):
        for command in ["exit 3", "echo nothing"]:
            with silent(), self.assertRaises(SystemExit):
                figures.measure([replace(Rule.row, command=command, read=r"(\d+)")], {"frame"})


if __name__ == "__main__":
    unittest.main()
