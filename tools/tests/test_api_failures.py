"""What a call from Python says where it cannot go on. Nothing is left of it: no program, no file."""

import os
import pickle
import signal
import subprocess
import sys
import time
import unittest
from contextlib import contextmanager
from pathlib import Path
from shlex import quote
from unittest import mock

import sunfleck
from sunfleck import process
from sunfleck.diagnostic import diagnostics

from .command import NO_PROGRAM, PROGRAM
from .test_api import FIRST_LEAF, SIZE, WithFolder

TOOLS = Path(__file__).parents[1]
SLOW = {"size": (3840, 2160), "tolerance": 0.001, "bounces": 0}
"""What makes a frame take minutes, and lets it begin at once: nothing is found beforehand."""
WITHOUT_PACKAGES = [sys.executable, "-I", "-S", "-c"]
"""A Python that finds no package but its own library."""
CALLER = """
import sys
import sunfleck

def told(event):
    if event["event"] == "frame_progress":
        print("begun", flush=True)

try:
    sunfleck.render(sys.argv[1], out=sys.argv[2] or None, progress=told, size="3840x2160", tolerance=0.001, bounces=0)
except KeyboardInterrupt:
    sys.exit(130)
"""


def is_running(process_id: int) -> bool:
    """False of one that has ended and was waited for."""
    try:
        os.kill(process_id, 0)
    except ProcessLookupError:
        return False
    return True


class Failing(WithFolder):
    def stand_in(self, script: str, says: str = f"sunfleck {sunfleck.__version__}") -> Path:
        """A program that says its version, and then does as the script of the shell does."""
        path = self.folder / "stand_in"
        path.write_text(f'#!/bin/sh\nif [ "$1" = --version ]; then echo {says}; exit; fi\n{script}\n')
        path.chmod(0o755)
        return path

    @contextmanager
    def program(self, path: object):
        """For a block, the program is that one."""
        with mock.patch.dict(os.environ, {"SUNFLECK": str(path)}):
            yield

    def fails(self, kind: type[sunfleck.SunfleckError], words: str, scene: object = FIRST_LEAF, **settings: object):
        """A call ends so, with these words, and leaves nothing for the time being; other processes can be told."""
        with self.assertRaisesRegex(kind, words) as raised:
            sunfleck.render(scene, **settings)
        self.assertEqual(list(self.temporary.iterdir()), [])
        again = pickle.loads(pickle.dumps(raised.exception))
        told = [(type(error), str(error), error.exit_code, error.diagnostics) for error in (again, raised.exception)]
        self.assertEqual(*told)
        return raised.exception


class Programs(Failing):
    @contextmanager
    def only(self, beside: Path, on_path: Path):
        """For a block, these are the folders where programs are looked for."""
        surroundings = {name: value for name, value in os.environ.items() if name != "SUNFLECK"} | {"PATH": str(on_path)}
        with mock.patch.dict(os.environ, surroundings, clear=True), mock.patch("sysconfig.get_path", lambda *_: str(beside)):
            yield

    def test_there_is_none(self):
        with self.only(self.folder, self.folder):
            error = self.fails(sunfleck.ProgramError, "there is no program sunfleck, .*: install the wheel, or let SUNFLECK name it")
            self.assertIsNone(error.exit_code)
        with self.program(self.folder / "none"):
            self.fails(sunfleck.ProgramError, "SUNFLECK names .*none, and there is no such program: name one")

    def test_the_one_beside_this_python_comes_before_the_path(self):
        beside, on_path = self.folder / "bin", self.folder / "path"
        for folder in (beside, on_path):
            folder.mkdir()
            self.stand_in("").rename(folder / "sunfleck")
        with self.only(beside, on_path):
            self.assertEqual(process.program(), str(beside / "sunfleck"))
            (beside / "sunfleck").unlink()
            self.assertEqual(process.program(), str(on_path / "sunfleck"))

    def test_another_version(self):
        with self.program(self.stand_in("", says="sunfleck 0.0.9")):
            words = f"is version 0.0.9, and this Python package {sunfleck.__version__}: install both from one wheel"
            self.fails(sunfleck.ProgramError, words)

    def test_a_program_that_is_another(self):
        with self.program(self.stand_in("", says="true (GNU coreutils) 9.1")):
            self.fails(sunfleck.ProgramError, "is not sunfleck: let SUNFLECK name the program")
        broken = self.folder / "broken"
        broken.write_bytes(b"\x7fELF of another machine")
        broken.chmod(0o755)
        with self.program(broken):
            self.fails(sunfleck.ProgramError, "cannot be run .*: install the wheel that is made for this machine")

    def test_one_that_dies_or_talks_nonsense(self):
        for script, words in (
            ("kill -9 $$", "SIGKILL ended the program, .* memory lacks: choose a smaller size"),
            ("echo thread main panicked >&2; exit 101", "exit code 101, .*: thread main panicked"),
            ("echo hello", "no JSON .*hello.*let SUNFLECK name sunfleck itself"),
        ):
            with self.program(self.stand_in(script)):
                self.fails(sunfleck.ProgramError, words)

    def test_one_that_is_ended_by_others_keeps_whole_frames(self):
        with self.program(self.stand_in("echo 'error: stopped by signal 15: whole frames are kept' >&2; exit 143")):
            self.assertEqual(self.fails(sunfleck.Stopped, "whole frames are kept").exit_code, 143)


@unittest.skipUnless(PROGRAM, NO_PROGRAM)
class Inputs(Failing):
    def test_what_is_not_there(self):
        error = self.fails(sunfleck.FileError, "none.ron: error: cannot be read", scene=self.folder / "none.ron")
        self.assertEqual((error.exit_code, error.place, error.remedy), (4, str(self.folder / "none.ron"), "check the path"))
        with self.assertRaisesRegex(sunfleck.FileError, "none.exr: .*\n  remedy: check the path"):
            sunfleck.read(self.folder / "none.exr")
        with self.assertRaises(sunfleck.FileError) as raised:
            sunfleck.read(self.folder / "none.exr")
        self.assertEqual(raised.exception.remedy, "check the path")
        with self.assertRaises(sunfleck.FileError):
            sunfleck.inspect(self.folder / "none.ron")

    def test_a_scene_with_a_slip(self):
        scene = self.folder / "bad.ron"
        scene.write_text("Scene(version: 1,\n  lihgts: {})")
        error = self.fails(sunfleck.SceneError, "there is no field `lihgts`", scene=scene)
        self.assertEqual((error.exit_code, error.place, error.remedy), (3, f"{scene}:2:3", "did you mean `lights`?"))

    def test_an_input_whose_name_begins_like_a_flag(self):
        error = self.fails(sunfleck.FileError, "cannot be read", scene="--frames=2.ron")
        self.assertEqual(error.place, "--frames=2.ron")

    def test_settings_that_cannot_be(self):
        self.fails(sunfleck.UsageError, "frame 900 is not part of the sequence", frame=900)
        self.fails(sunfleck.UsageError, "--tolerance", tolerance=7)
        for said, setting in (("'--nonsense'", {"nonsense": 3}), ("'x'", {"tolerance": "x"}), ("--strict", {"strict": "yes"})):
            self.assertIn("--help", self.fails(sunfleck.UsageError, said, **setting).remedy)
        for setting in ("frames", "dry_run", "skip"):
            with self.assertRaisesRegex(TypeError, f"{setting} is no setting from Python: "):
                sunfleck.render(FIRST_LEAF, **{setting: "1"})
        with self.assertRaises(TypeError):
            sunfleck.render(FIRST_LEAF, "1-2")

    def test_types_that_cannot_be(self):
        for said, arguments in (
            ("scene is 5, a int", {"scene": 5}),
            ("scene is ''", {"scene": ""}),
            ("no file is called", {"scene": "a\0b.ron"}),
            ("frame is '1', a str", {"frame": "1"}),
            ("frame is 1.5, a float", {"frame": 1.5}),
            ("out is \\[\\], a list", {"out": []}),
            ("size is 5, a int", {"size": 5}),
            ("size is \\('a', 2\\)", {"size": ("a", 2)}),
            ("passes is or holds b'depth', a bytes", {"passes": b"depth"}),
            ("passes is or holds None, a NoneType", {"passes": [None]}),
            ("tolerance is or holds {'a': 1}, a dict", {"tolerance": {"a": 1}}),
            ("camera is or holds <object", {"camera": object()}),
            ("progress is 'jsonl'", {"progress": "jsonl"}),
            ("progress is 3", {"progress": 3}),
            ("help is no setting", {"help": True}),
            ("version is no setting", {"version": True}),
        ):
            error = self.fails(sunfleck.UsageError, said, **arguments)
            self.assertTrue(error.remedy, said)
            self.assertIsInstance(error, TypeError)
        for call in (
            lambda: sunfleck.render_frames(FIRST_LEAF, 3j),
            lambda: sunfleck.render_frames(FIRST_LEAF, progress="jsonl"),
            lambda: sunfleck.inspect(FIRST_LEAF, frames=object()),
            lambda: sunfleck.inspect(None),
            lambda: sunfleck.read(7),
        ):
            with self.assertRaises(sunfleck.UsageError) as caught:
                call()
            self.assertTrue(caught.exception.remedy)

    def test_an_output_that_cannot_be_written(self):
        taken = self.folder / "taken"
        taken.write_bytes(b"a file, no folder")
        error = self.fails(sunfleck.FileError, "error: .*taken", out=taken / "x.####.exr", size=SIZE)
        self.assertTrue(error.remedy)
        self.assertEqual((taken.read_bytes(), sorted(self.folder.iterdir())), (b"a file, no folder", [taken, self.temporary]))

    def test_a_frame_that_takes_too_long_leaves_nothing(self):
        out = self.folder / "out"
        error = self.fails(sunfleck.FrameError, "", out=f"{out}/", frame_timeout=0.1, **SLOW)
        self.assertEqual((error.exit_code, list(self.folder.glob("out/*"))), (5, []))

    def test_a_damaged_frame_is_said(self):
        path = self.folder / "x.exr"
        sunfleck.render(FIRST_LEAF, size=SIZE, samples=1, bounces=0, out=path)
        path.write_bytes(path.read_bytes()[:-9])
        with self.assertRaisesRegex(sunfleck.FileError, "x.exr: error: .*\n  remedy: render the frame again"):
            sunfleck.read(path)


@unittest.skipUnless(PROGRAM and os.name == "posix", NO_PROGRAM)
class Ends(Failing):
    def witness(self) -> tuple[Path, Path]:
        """The program behind a script that notes the number of its process, and where."""
        noted = self.folder / "noted"
        return self.stand_in(f'echo $$ >{quote(str(noted))}; exec {quote(str(Path(PROGRAM).resolve()))} "$@"'), noted

    def ended(self, noted: Path) -> bool:
        return not is_running(int(noted.read_text()))

    def test_ctrl_c_ends_the_program_too(self):
        program, noted = self.witness()
        surroundings = {**os.environ, "SUNFLECK": str(program), "TMPDIR": str(self.temporary)}
        # To the caller alone as a notebook does it, and to the whole group as a terminal does.
        for send, out in ((os.kill, ""), (os.killpg, f"{self.folder / 'out'}/")):
            with self.subTest(send.__name__):
                caller = subprocess.Popen(
                    [sys.executable, "-c", CALLER, str(FIRST_LEAF), out],
                    cwd=TOOLS, env=surroundings, stdout=subprocess.PIPE, start_new_session=True,
                    # Shells let what runs in the background ignore Ctrl-C, and so would all that it starts.
                    preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
                )  # fmt: skip
                self.assertEqual(caller.stdout.readline(), b"begun\n")
                began = time.monotonic()
                send(caller.pid, signal.SIGINT)
                caller.stdout.read()
                self.assertEqual(caller.wait(30), 130)
                self.assertLess(time.monotonic() - began, 5)
                caller.stdout.close()
                self.assertTrue(self.ended(noted))
                self.assertEqual(list(self.temporary.iterdir()), [])
        self.assertEqual([*self.folder.glob("out/*"), *self.folder.glob("out/.*")], [])

    def test_an_iterator_that_is_left_ends_it(self):
        program, noted = self.witness()
        with self.program(program):
            frames = sunfleck.render_frames(FIRST_LEAF, size=(480, 270))
            self.assertEqual(next(frames).number, 1)
            frames.close()
        self.assertTrue(self.ended(noted))
        self.assertEqual(list(self.temporary.iterdir()), [])

    def test_a_function_that_raises_ends_it(self):
        program, noted = self.witness()

        def told(event: dict) -> None:
            raise RuntimeError("enough")

        with self.program(program), self.assertRaisesRegex(RuntimeError, "enough"):
            sunfleck.render(FIRST_LEAF, progress=told, **SLOW)
        self.assertTrue(self.ended(noted))
        self.assertEqual(list(self.temporary.iterdir()), [])

    def test_one_that_does_not_want_to_end_is_killed(self):
        noted = self.folder / "noted"
        started = '{"event": "started", "frames": 1}'
        deaf = self.stand_in(f"""trap '' TERM; echo $$ >{quote(str(noted))}; echo '{started}'; while :; do sleep 0.1; done""")
        with self.program(deaf), mock.patch.object(process, "GRACE_S", 0.3):
            frames = sunfleck.render_frames(FIRST_LEAF, progress=self.stop)
            with self.assertRaisesRegex(RuntimeError, "stop"):
                next(frames)
        self.assertTrue(self.ended(noted))

    def stop(self, event: dict) -> None:
        raise RuntimeError("stop")

    def test_python_m_sunfleck_is_the_program(self):
        with self.program(PROGRAM):
            for arguments, code in ((["--version"], 0), (["render", "none.ron"], 4)):
                done = subprocess.run([sys.executable, "-m", "sunfleck", *arguments], cwd=TOOLS, capture_output=True, text=True,
                                      env={**os.environ, "SUNFLECK": str(Path(PROGRAM).resolve())})  # fmt: skip
                self.assertEqual(done.returncode, code, done.stderr)
        done = subprocess.run([sys.executable, "-m", "sunfleck"], cwd=TOOLS, capture_output=True, text=True,
                              env={**os.environ, "SUNFLECK": "none"})  # fmt: skip
        self.assertEqual((done.returncode, done.stderr.count("\n")), (1, 1))
        self.assertIn("error: SUNFLECK names none", done.stderr)


class Packages(unittest.TestCase):
    def test_without_numpy_a_sentence_says_what_to_install(self):
        for module, script, code in (
            ("sunfleck", "import sunfleck", 1),
            ("sunfleck_tools", "from sunfleck_tools.cli import main; sys.exit(main(['validate', 'out']))", 2),
        ):
            done = subprocess.run(
                [*WITHOUT_PACKAGES, f"import sys; sys.path.insert(0, {str(TOOLS)!r}); {script}"], capture_output=True, text=True
            )
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertRegex(done.stderr.splitlines()[-1], "numpy is not installed: pip install numpy")
            if module == "sunfleck_tools":
                self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)

    def test_without_usd_the_other_commands_go_on(self):
        script = f"import sys; sys.path.insert(0, {str(TOOLS)!r}); sys.modules['pxr'] = None; from sunfleck_tools.cli import main; "
        for arguments, code, said in (
            (["export-usd", str(FIRST_LEAF), "x.usda"], 2, "error: pxr is not installed: pip install usd-core"),
            (["validate", "--list-checks"], 0, ""),
        ):
            done = subprocess.run([sys.executable, "-c", f"{script}sys.exit(main({arguments}))"], capture_output=True, text=True)
            self.assertEqual((done.returncode, done.stderr.strip()), (code, said))


class Words(unittest.TestCase):
    def test_are_taken_apart_and_none_is_lost(self):
        said = (
            "a: b.glb:/nodes/3: warning[no-light]: there is no light\n  remedy: add one\nerror: it is dark\n  expected: light\n"
            "\n  tip: wait\nUsage: sunfleck"
        )
        warning, error = diagnostics(said)
        self.assertEqual((warning.severity, warning.id, warning.remedy), ("warning", "no-light", "add one"))
        self.assertEqual(warning.place, "a: b.glb:/nodes/3")
        self.assertEqual((error.place, error.message, error.expected, error.remedy), ("", "it is dark", "light", "wait"))
        self.assertEqual(f"{warning.text}\n{error.text}", said)
        self.assertEqual([found.severity for found in diagnostics("hello\nworld")], ["line"])
        self.assertEqual(diagnostics(""), ())
