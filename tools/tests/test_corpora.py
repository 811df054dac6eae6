"""What becomes of a corpus's files, told by a program that does what their names say."""

import json
import signal
import subprocess
import sys
import tempfile
import unittest
from dataclasses import replace
from pathlib import Path
from shlex import quote

import numpy as np
import OpenEXR

from .command import NO_PROGRAM, PROGRAM
from .corpora import Limits, Programs, as_json, as_text, find_files, verdict_on
from .corpora.limited import run_limited
from .corpora.outcomes import Outcome, group_of
from .corpora.probes import mean_radiance
from .files import DATA

PROGRAM_OF_NAMES = """#!/bin/sh
command=$1 file=$2
case $file in
    *refused*) echo "$file: nodes/3: error: the node 3 has no \\`size\\`" >&2; echo "  remedy: give it one" >&2; exit 3 ;;
    *lists*) printf 'error: a stage: does not hold together:\\n  there is no a/b.usd\\n  and more\\n' >&2; exit 3 ;;
    *sleeps*) sleep 60 ;;
    *turns*) while :; do :; done ;;
    *panics*) echo "thread 'main' panicked at src/main.rs:1:1:" >&2; exit 101 ;;
    *raises*) echo "Traceback (most recent call last):" >&2; exit 1 ;;
    *crashes*) kill -SEGV $$ ;;
    *exits*) exit 7 ;;
    *hoards*) exec {python} -c "held = b'x' * (700 << 20)" ;;
    *losses*) echo "$file: warning[points-and-lines]: points and lines are not drawn" >&2 ;;
    *unlit*) echo "$file: warning[no-light]: nothing lights the scene" >&2 ;;
esac
[ "$command" = inspect ] && echo '{{"animations": [{{"frame_start": 3.0}}], "frame_end": 9, "frame_start": -2, "frames": []}}' && exit 0
shift 2
while [ "$1" != --out ]; do [ "$1 $2" = "--frames -2" ] && asked=yes; shift; done
[ "$asked" = yes ] || exit 2
case $file in
    *black*) cp {black} "$(dirname "$2")/frame.-0002.exr" ;;
    *) cp {good} "$(dirname "$2")/frame.-0002.exr" ;;
esac
"""
PROGRAM_OF_STEPS = """#!/bin/sh
case $1 in
    validate | diff) echo "error: $1 takes no such frame" >&2; exit 4 ;;
    preview) echo "thread 'main' panicked at src/main.rs:1:1:" >&2; exit 101 ;;
esac
"""
OUTCOME_OF_NAME = {
    "good.glb": Outcome.DONE,
    "losses.gltf": Outcome.WITH_LOSSES,
    "unlit_black.glb": Outcome.BLACK_WITH_CAUSE,
    "refused.obj": Outcome.REFUSED,
    "lists.obj": Outcome.REFUSED,
    "black.obj": Outcome.BLACK,
    "sleeps.glb": Outcome.HANG,
    "turns.glb": Outcome.HANG,
    "hoards.glb": Outcome.MEMORY,
    "panics.glb": Outcome.PANIC,
    "raises.glb": Outcome.TRACEBACK,
    "crashes.glb": Outcome.CRASH,
    "exits.glb": Outcome.OTHER_EXIT,
}
# Linux counts the memory of whoever starts a program as the program's own, and these tests have 200 MB.
LIMITS = Limits(cpu_s=1, memory_bytes=500 << 20, wall_s=60)
IMPATIENT = replace(LIMITS, wall_s=2)
"""For what waits without working. What works has its time in the processor's seconds alone: other work on the
machine may make it wait."""


@unittest.skipUnless(sys.platform == "linux", "limits of memory are Linux's")
class Corpora(unittest.TestCase):
    script = Path(__file__).parents[1] / "corpora"

    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        root = Path(cls.scratch.name)
        black = root / "dark.exr"
        with OpenEXR.File(
            {"type": OpenEXR.scanlineimage}, {letter: np.zeros((9, 16), np.float32) for letter in "RGB"}
        ) as file:
            file.write(str(black))
        cls.program = root / "program"
        cls.program.write_text(
            PROGRAM_OF_NAMES.format(
                python=quote(sys.executable), black=quote(str(black)), good=quote(str(DATA / "leaf.0006.exr"))
            )
        )
        cls.program.chmod(0o755)
        cls.corpus = root / "corpus"
        for name in OUTCOME_OF_NAME:
            path = cls.corpus / "models" / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.touch()
        files = find_files(cls.corpus, invalid={"models/refused.obj"})
        limits = [IMPATIENT if "sleeps" in file.name else LIMITS for file in files]
        cls.verdicts = [
            verdict_on(file, Programs(str(cls.program), limits=limit)) for file, limit in zip(files, limits)
        ]

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    def test_every_outcome(self):
        found = {verdict.file.path.name: verdict.outcome for verdict in self.verdicts}
        self.assertEqual(found, OUTCOME_OF_NAME)

    def test_order_is_that_of_names(self):
        names = [verdict.file.name for verdict in self.verdicts]
        self.assertEqual(names, sorted(f"models/{name}" for name in OUTCOME_OF_NAME))

    def test_rows_of_the_report(self):
        rows = {row["file"]: row for row in json.loads(json.dumps(as_json(self.verdicts)))}
        self.assertEqual(rows["models/losses.gltf"]["losses"], ["points-and-lines"])
        self.assertEqual(rows["models/refused.obj"]["step"], "inspect")
        self.assertEqual(rows["models/refused.obj"]["sentence"], "the node 3 has no `size`")
        self.assertEqual(
            rows["models/lists.obj"]["sentence"], "a stage: does not hold together: there is no a/b.usd"
        )
        self.assertEqual(rows["models/black.obj"]["mean"], 0)
        self.assertGreater(rows["models/good.glb"]["mean"], 0)
        # It may be stopped on its way, by its processor's time on a machine that is busy.
        self.assertGreater(rows["models/hoards.glb"]["peak_mb"], LIMITS.memory_bytes >> 20)

    def test_table_counts_and_lists(self):
        text = as_text(self.verdicts)
        counts = {line.split()[0].rstrip(","): line.split() for line in text.splitlines()[1:4]}
        self.assertEqual(counts["gltf"][1], "10")
        self.assertIn("obj, invalid", text)
        self.assertIn(
            "1  obj, invalid, inspect: the node N has no `…`\n       such as models/refused.obj", text
        )
        faults = text.split("faults of the program:\n")[1].split("\n\n")[0].splitlines()
        self.assertEqual(len(faults), sum(outcome.is_fault for outcome in OUTCOME_OF_NAME.values()))
        self.assertIn("black  models/black.obj  mean 0", faults)

    def test_frames_go_through_every_command(self):
        """A refusal by one hides nothing that another does."""
        with tempfile.TemporaryDirectory() as folder:
            program = Path(folder) / "program"
            program.write_text(PROGRAM_OF_STEPS)
            program.chmod(0o755)
            (Path(folder) / "x.exr").touch()
            (verdict,) = (
                verdict_on(file, Programs(str(program), (str(program),), LIMITS))
                for file in find_files(Path(folder))
            )
        self.assertEqual((verdict.outcome, verdict.step), (Outcome.PANIC, "preview"))
        self.assertEqual(verdict.refused_by, ("validate", "diff"))
        self.assertIn("panicked", verdict.sentence)

    def test_processor_time_has_a_limit_of_its_own(self):
        ended = run_limited(["sh", "-c", "while :; do :; done"], Limits(cpu_s=1, wall_s=60))
        self.assertEqual(ended.code, -signal.SIGXCPU)
        self.assertTrue(ended.took_too_long)

    def test_sentences_of_one_kind_are_one_group(self):
        one = group_of("node 12 (`leaf`) is at /some/place/x.png, 1.5e-3 m off")
        self.assertEqual(one, group_of("node 7 (`twig`) is at y/other.png, 2 m off"))
        self.assertNotEqual(one, group_of("node 7 (`twig`) is missing"))

    def test_exit_code_of_the_command(self):
        for name, code in (("panics", 1), ("black", 1), ("refused", 0), ("good", 0)):
            with self.subTest(name), tempfile.TemporaryDirectory() as folder:
                (Path(folder) / f"{name}.glb").touch()
                done = subprocess.run(
                    [sys.executable, self.script, folder, "--sunfleck", self.program, "--jobs", "2"],
                    capture_output=True,
                    text=True,
                )
                self.assertEqual(done.returncode, code, done.stdout + done.stderr)
                self.assertIn(f"{name}.glb", done.stdout)

    def test_stopped_it_reports_what_it_has(self):
        with tempfile.TemporaryDirectory() as folder:
            for name in ("good.glb", "zz_stops.glb", "zzz.glb"):
                (Path(folder) / name).touch()
            program, report = Path(folder) / "program", Path(folder) / "report.json"
            # The second file's program ends the command that tries it.
            program.write_text(
                f"#!/bin/sh\ncase $2 in *stops*) kill -TERM $STOPPED; exit 3 ;; esac\nexec {quote(str(self.program))} "
                "\"$@\"\n"
            )
            program.chmod(0o755)
            command = [
                sys.executable,
                str(self.script),
                folder,
                "--sunfleck",
                str(program),
                "--out",
                str(report),
            ]
            line = ["sh", "-c", 'export STOPPED=$$; exec "$@"', "sh", *command]
            done = subprocess.run(line, capture_output=True, text=True)
            self.assertEqual(done.returncode, 130, done.stdout + done.stderr)
            self.assertIn("good.glb", [row["file"] for row in json.loads(report.read_text())])
            self.assertIn("of 3 files", done.stderr)


@unittest.skipUnless(PROGRAM, NO_PROGRAM)
class Steps(unittest.TestCase):
    """With the renderer itself."""

    def test_files_of_this_project(self):
        data = Path(__file__).parents[2] / "tests" / "data"
        files = find_files(data / "valid" / "gltf" / "same")[:2] + find_files(DATA, {"exr"})[:1]
        self.assertEqual(len(files), 3)
        for file in files:
            with self.subTest(file.name):
                verdict = verdict_on(file, Programs(PROGRAM))
                self.assertIn(verdict.outcome, (Outcome.DONE, Outcome.WITH_LOSSES), verdict)

    def test_sentences_name_no_folder_that_is_gone(self):
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "no_frame.exr").write_bytes(b"no frame")
            (verdict,) = (verdict_on(file, Programs(PROGRAM)) for file in find_files(Path(folder)))
        self.assertEqual(verdict.outcome, Outcome.REFUSED, verdict)
        self.assertIn("frame.0001.exr", verdict.sentence)
        self.assertNotIn(tempfile.gettempdir(), verdict.sentence)

    def test_mean_of_a_frame(self):
        self.assertGreater(mean_radiance(DATA / "leaf.0006.exr"), 0)
        self.assertTrue(np.isnan(mean_radiance(DATA / "no such file.exr")))
