"""What the system may do to a command.

Streams are closed or full, disks take no more, signals come, memory is short, names and files are none. Each
ends with the right exit code, and never with a traceback.
"""

import errno
import html
import json
import os
import resource
import shlex
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path
from unittest import mock

import numpy as np

from sunfleck_tools import Options, SceneError, ToolError, validate
from sunfleck_tools.disk import need_regular, write_whole, writing
from sunfleck_tools.exr import decode
from sunfleck_tools.gltf.container import Container
from sunfleck_tools.parallel import in_processes
from sunfleck_tools.streams import Patient
from sunfleck_tools.words import printable

from .command import run
from .files import DATA, good_sequence, scene, write_frame

TOOLS = Path(__file__).parents[1]
COMMAND = [sys.executable, "-m", "sunfleck_tools"]
BAD = DATA / "exr/two_sequences"
FAST = ("--processes", "1")


def shell(line: str, **options: object) -> subprocess.CompletedProcess:
    """A line of bash in which `T` is the program."""
    script = f"set -o pipefail; T() {{ {shlex.join(COMMAND)} \"$@\" {' '.join(FAST)}; }}; {line}"
    return subprocess.run(
        ["bash", "-c", script], cwd=TOOLS, capture_output=True, text=True, timeout=120, **options
    )


def killed(process: int) -> int:
    """Ends its process as the system does where memory lacks."""
    if process == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    return process


def greedy(process: int) -> int:
    """Wants more than there is."""
    if process == 1:
        raise MemoryError("memory is not enough for it")
    return process


class WithFolder(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = Path(scratch.name)


@unittest.skipUnless(sys.platform == "linux", "/dev/full is Linux's")
class Streams(WithFolder):
    def test_the_exit_code_is_that_of_what_was_found(self):
        good = good_sequence(self.folder / "good")
        for number in range(3, 13):
            (good / f"leaf.{number:04d}.exr").unlink()
        good = shlex.quote(str(good))
        bad = shlex.quote(str(BAD))
        for line, code in (
            (f"T validate {good} 2>&-", 0), (f"T validate {good} >&- 2>&- "
                                             "<&-", 0), (f"T validate {bad} >&- 2>&- <&-", 1),
            (f"T validate {good} 2>/dev/full", 0), (f"T validate {bad} | true", 1), (f"T validate {good} 2>&1 >/dev/null | true", 0),
            (f"T validate {good} >/dev/full", 4), (f"T validate {bad} >/dev/full", 1), (f"T validate {good}/none 2>/dev/full", 4),
        ):  # fmt: skip
            with self.subTest(line):
                done = shell(line)
                self.assertEqual(done.returncode, code, done.stderr)
                self.assertNotIn("Traceback", done.stderr + done.stdout)

    def test_a_full_one_is_told_on_the_other(self):
        done = shell("T validate --list-checks >/dev/full")
        self.assertEqual(
            (done.returncode, done.stderr),
            (4, "error: the output could not be written: No space left on device\n"),
        )

    def test_a_closed_one_is_silent(self):
        for error in (OSError(errno.EPIPE, ""), OSError(errno.EBADF, ""), ValueError("closed")):
            beneath = mock.Mock(**{"write.side_effect": error, "fileno.side_effect": ValueError})
            stream = Patient(beneath)
            print("text", file=stream, flush=True)
            self.assertIsNone(stream.lost)
        self.assertFalse(Patient(None).isatty())


class Disks(WithFolder):
    def test_an_older_file_stays_until_the_new_one_is_whole(self):
        path = self.folder / "x.png"
        path.write_bytes(b"old and good")
        with self.assertRaisesRegex(ToolError, r"cannot write .*x\.png: No space left on device"):
            with writing(path) as file:
                file.write(b"half")
                raise OSError(errno.ENOSPC, "No space left on device")
        self.assertEqual((path.read_bytes(), list(self.folder.iterdir())), (b"old and good", [path]))
        write_whole(path, b"new")
        self.assertEqual((path.read_bytes(), list(self.folder.iterdir())), (b"new", [path]))

    def test_a_link_stays_a_link(self):
        link, path = self.folder / "link", self.folder / "file"
        link.symlink_to(path)
        write_whole(link, b"text")
        self.assertTrue(link.is_symlink() and path.read_bytes() == b"text")

    @unittest.skipUnless(sys.platform == "linux", "limits of files are Linux's")
    def test_a_page_that_cannot_be_written_is_said(self):
        good = good_sequence(self.folder / "good")
        out = self.folder / "out.png"
        out.write_bytes(b"old and good")
        done = subprocess.run(
            [*COMMAND, "validate", str(good), "--html", str(out), *FAST], cwd=TOOLS, capture_output=True, text=True, timeout=120,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (500, 500)),
        )  # fmt: skip
        self.assertEqual((done.returncode, done.stderr), (4, f"error: cannot write {out}: File too large\n"))
        self.assertEqual(out.read_bytes(), b"old and good")
        self.assertEqual(sorted(self.folder.iterdir()), [good, out])


    @unittest.skipUnless(sys.platform == "linux", "limits of files are Linux's")
    def test_a_stage_is_written_whole_or_not_at_all(self):
        nodes = [{"name": f"node {number}", "translation": [number, 0, 0]} for number in range(100)]
        source = self.folder / "scene.gltf"
        scenes = [{"nodes": list(range(100))}]
        source.write_text(
            json.dumps({"asset": {"version": "2.0"}, "scene": 0, "scenes": scenes, "nodes": nodes})
        )
        for ending in ("usda", "usdc", "usdz"):
            out = self.folder / f"out.{ending}"
            out.write_bytes(b"old and good")
            done = subprocess.run(
                [*COMMAND, "export-usd", str(source), str(out)], cwd=TOOLS, capture_output=True, text=True, timeout=120,
                preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (500, 500)),
            )  # fmt: skip
            self.assertEqual(
                (done.returncode, done.stderr), (4, f"error: cannot write {out}: File too large\n"), ending
            )
            self.assertEqual(out.read_bytes(), b"old and good")
            out.unlink()
            self.assertEqual(list(self.folder.iterdir()), [source])


@unittest.skipUnless(sys.platform == "linux", "/proc is Linux's")
class Signals(WithFolder):
    def begun(self) -> tuple[subprocess.Popen, list[int]]:
        """A command at work, and its processes."""
        for number in range(1, 9):
            channels = {name: np.tile(values, (16, 16)) for name, values in scene(number).items()}
            write_frame(self.folder / f"x.{number:04d}.exr", channels)
        command = [*COMMAND, "validate", str(self.folder), "--processes", "2"]
        process = subprocess.Popen(
            command,
            cwd=TOOLS,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
            # A shell's background jobs inherit that SIGINT is ignored.
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        )
        self.addCleanup(process.kill)
        deadline = time.monotonic() + 60
        while len(children := self.children(process.pid)) < 2 and time.monotonic() < deadline:
            time.sleep(0.02)
        return process, children

    def children(self, parent: int) -> list[int]:
        return [int(pid) for pid in Path(f"/proc/{parent}/task/{parent}/children").read_text().split()]

    def all_end(self, children: list[int]) -> bool:
        """True if all have ended within seconds."""
        deadline = time.monotonic() + 20
        while any(self.lives(pid) for pid in children) and time.monotonic() < deadline:
            time.sleep(0.02)
        return not any(self.lives(pid) for pid in children)

    def lives(self, pid: int) -> bool:
        try:
            return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
        except OSError:
            return False

    def test_are_heard_and_leave_no_process(self):
        for number, code in ((signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGKILL, -9)):
            with self.subTest(number.name):
                process, children = self.begun()
                self.assertGreaterEqual(len(children), 2)
                # A terminal sends Ctrl-C to all of them.
                os.killpg(process.pid, number) if number is signal.SIGINT else process.send_signal(number)
                _, err = process.communicate(timeout=60)
                self.assertEqual(process.returncode, code)
                if number is not signal.SIGKILL:
                    self.assertNotIn("Traceback", err)
                self.assertTrue(self.all_end(children))


@unittest.skipUnless(hasattr(signal, "SIGCHLD"), "there is no SIGCHLD")
class IgnoredEnds(unittest.TestCase):
    def test_of_processes_are_learnt_of_all_the_same(self):
        before = signal.signal(signal.SIGCHLD, signal.SIG_IGN)
        self.addCleanup(signal.signal, signal.SIGCHLD, before)
        with self.assertRaises(MemoryError):
            list(in_processes(killed, range(3), 1, lambda argument: -1))


class Memory(WithFolder):
    def test_that_lacks_is_said(self):
        write_frame(self.folder / "x.0001.exr", scene(1))
        for error in (MemoryError(), RuntimeError("std::bad_alloc")):
            with mock.patch.object(decode.OpenEXR, "File", side_effect=error):
                # Where there is enough, it is the file that asked for too much.
                checks = [finding.check for finding in validate(self.folder, Options(processes=0)).findings]
                self.assertIn("decode", checks)
                with mock.patch.object(decode, "_could_hold", lambda size: False):
                    with self.assertRaisesRegex(
                        MemoryError, r"memory is not enough to decode .*x\.0001\.exr"
                    ):
                        validate(self.folder, Options(processes=0))
        with mock.patch(
            "sunfleck_tools.commands.validate.validate",
            side_effect=MemoryError("memory is not enough to decode x"),
        ):
            code, _, err = run("validate", self.folder)
        self.assertEqual(
            (code, err),
            (4, "error: memory is not enough to decode x: choose fewer --processes, or smaller frames\n"),
        )

    def test_that_lacks_in_a_process_is_no_crash_of_the_decoder(self):
        for function in (killed, greedy):
            with self.assertRaises(MemoryError):
                list(in_processes(function, range(3), 1, lambda argument: -1))


class Names(WithFolder):
    def test_control_characters_are_escaped_wherever_they_are_shown(self):
        self.assertEqual(printable("a\x1b[31m\nb\udcff\u202e\u00e9"), "a\\x1b[31m\\nb\\udcff\\u202e\u00e9")
        # Where names are in UTF-8 the byte 255 is no letter; elsewhere it may be one.
        name = os.fsdecode(b"evil\x1b[31m\n\xff<b>")
        shown = printable(name)
        self.assertTrue(shown.startswith("evil\\x1b[31m\\n"), shown)
        path = write_frame(self.folder / "x.exr", scene(1))
        path.rename(self.folder / f"{name}.0001.exr")
        page = self.folder / "page.html"
        code, out, err = run("validate", self.folder, "--html", page)
        self.assertEqual(code, 0, err)
        self.assertNotIn("\x1b", out + err)
        self.assertIn(f"{shown}.####.exr: 1 frame", run("validate", self.folder)[1])
        self.assertIn(f"{html.escape(shown)}.", page.read_text("utf-8"))
        code, _, err = run("validate", self.folder / "none\x1b[31m")
        self.assertEqual(code, 4)
        self.assertIn("none\\x1b[31m", err)
        json.loads(run("validate", self.folder, "--json")[1])
        self.assertNotIn("\x1b", run("validate", self.folder, "--frames", "\x1b[31m")[2])


@unittest.skipUnless(hasattr(os, "mkfifo"), "there are no FIFOs")
class SpecialFiles(WithFolder):
    def test_are_not_read(self):
        fifo = self.folder / "x.0002.exr"
        os.mkfifo(fifo)
        write_frame(self.folder / "x.0001.exr", scene(1))
        code, out, _ = run("validate", self.folder)
        self.assertEqual(code, 1)
        self.assertIn(
            "frame 2: it cannot be read: it is a FIFO, and only regular files are read [unreadable]", out
        )
        self.assertEqual(run("validate", fifo)[0], 4)
        self.assertEqual(run("validate", self.folder, "--stats", fifo)[0], 4)
        with self.assertRaisesRegex(SceneError, "it is a FIFO, and only regular files are read"):
            Container(fifo)
        with self.assertRaisesRegex(OSError, "a device"):
            need_regular(Path("/dev/zero"))


class Scenes(WithFolder):
    def write(self, **members: object) -> Path:
        path = self.folder / "in/scene.gltf"
        path.parent.mkdir(exist_ok=True)
        path.write_text(json.dumps({"asset": {"version": "2.0"}, **members}))
        return path

    def test_json_that_is_nested_too_deeply_is_said_to_be(self):
        path = self.write()
        path.write_text("[" * 200_000 + "]" * 200_000)
        with self.assertRaisesRegex(SceneError, "its JSON is nested too deeply"):
            Container(path)
        code, _, err = run("export-usd", path, self.folder / "out.usda")
        self.assertEqual((code, "nested too deeply" in err, "Traceback" in err), (3, True, False))

    def test_what_lies_outside_is_read_only_if_allowed(self):
        for name in ("in/own.bin", "outside/other.bin"):
            (self.folder / name).parent.mkdir(exist_ok=True)
            (self.folder / name).write_bytes(b"1234")
        (self.folder / "in").joinpath("link.bin").symlink_to(self.folder / "outside/other.bin")
        absolute = str(self.folder / "outside/other.bin")
        for uri in ("../outside/other.bin", "..%2Foutside/other.bin", "link.bin", absolute):
            path = self.write(buffers=[{"byteLength": 4, "uri": uri}])
            with self.assertRaisesRegex(
                SceneError, r"buffers\[0\]\.uri: leads out of the file's folder, .*give --allow"
            ):
                Container(path).buffer(0)
            self.assertEqual(Container(path, [self.folder / "outside"]).buffer(0), b"1234")
        self.assertEqual(
            Container(self.write(buffers=[{"byteLength": 4, "uri": "own.bin"}])).buffer(0), b"1234"
        )
