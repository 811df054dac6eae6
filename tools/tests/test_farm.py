"""`sunfleck farm`: jobs run for real by the programs of Open Job Description, with what
goes wrong on a farm."""

import importlib.util
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path, PureWindowsPath
from shlex import quote
from unittest import mock

from .command import NO_PROGRAM, PROGRAM

OPENJD = shutil.which("openjd") or shutil.which("openjd", path=str(Path(sys.executable).parent))
TOOLS = Path(__file__).parents[1]
FRAMES = 48

SCENE = """Scene(
    version: 1,
    meshes: { "leaf": Leaf(length_m: 0.8, width_m: 0.5, curl_deg: 30.0) },
    objects: { "leaf": (mesh: "leaf", rotation_deg: Keyed(
        keys: [(at_s: 0.0, value: (20.0, 0.0, 10.0)), (at_s: 2.0, value: (20.0, 360.0, 10.0))], extend: Cycle)) },
    cameras: { "main": (position_m: (0.0, 0.0, 2.5), look_at_m: (0.0, 0.0, 0.0), fov_deg: 40.0) },
    lights: { "sun": Sun(to_sun: (0.4, 1.0, 0.6), irradiance_w_per_m2: (8.0, 7.2, 6.0)) },
    fog: { "haze": (min_m: (-4.0, -1.0, -4.0), max_m: (4.0, 3.0, 4.0), density_per_m: 0.15) },
)"""
# A frame takes long enough for a machine to be killed in the midst of a task, and no longer.
SHOT = f"""Sequence(version: 1, scene: "the scene.ron", frames: (1, {FRAMES}), frame_rate: 24,
    size: (96, 54), samples: 64, bounces: 0)"""


@unittest.skipUnless(PROGRAM, NO_PROGRAM)
class WithShot(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = Path(scratch.name).resolve() / "all of it"
        self.folder.mkdir()
        self.shot = self.folder / "a shot.ron"
        self.shot.write_text(SHOT)
        (self.folder / "the scene.ron").write_text(SCENE)

    def farm(self, *flags: str) -> Path:
        """The folder of a job for the shot."""
        job = self.folder / "the job"
        subprocess.run([PROGRAM, "farm", self.shot, "--out", job, *flags], check=True, capture_output=True)
        return job


@unittest.skipUnless(OPENJD, "openjd is not installed: pip install openjd-cli")
class OpenJobDescription(WithShot):
    def setUp(self):
        super().setUp()
        self.job = self.farm("--chunk", "8")
        self.tools = self.folder / "tools of this checkout"
        self.tools.write_text(
            f'#!/bin/sh\nPYTHONPATH={quote(str(TOOLS))} exec {quote(sys.executable)} -m sunfleck_tools "$@"\n'
        )
        self.tools.chmod(0o755)
        # openjd's folder of temporary files belongs to whoever first ran it on a machine.
        self.temporary = self.folder / "temporary"
        self.temporary.mkdir()
        elsewhere = mock.patch("tempfile.tempdir", str(self.temporary))
        elsewhere.start()
        self.addCleanup(elsewhere.stop)

    def worker(self, *arguments: str, shot: Path | None = None) -> subprocess.Popen:
        """A session of `openjd run`, in a group of processes of its own."""
        parameters = {"Input": shot or self.shot, "Sunfleck": Path(PROGRAM).resolve(), "Tools": self.tools}
        flags = [part for name, value in parameters.items() for part in ("-p", f"{name}={value}")]
        return subprocess.Popen(
            [OPENJD, "run", self.job / "template.json", *flags, *arguments],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True,
            env={**os.environ, "TMPDIR": str(self.temporary)},
        )  # fmt: skip

    def tasks(self, *chunks: str) -> tuple[str, ...]:
        return "--step", "Render", "--tasks", json.dumps([{"Frame": chunk} for chunk in chunks])

    def ends_well(self, worker: subprocess.Popen) -> str:
        out, _ = worker.communicate(timeout=300)
        self.assertEqual(worker.returncode, 0, out)
        return out

    def test_two_workers_one_killed_one_frame_damaged(self):
        subprocess.run(
            [PROGRAM, "render", self.shot, "--out", self.folder / "once/", "--progress", "none"], check=True
        )
        frames = self.job / "frames"
        mine, others = self.tasks("1-8", "9-16", "17-24"), self.tasks("25-32", "33-40", "41-48")
        killed, other = self.worker(*mine), self.worker(*others)
        deadline = time.monotonic() + 120
        while not (frames / "a shot.0003.exr").exists() and time.monotonic() < deadline:
            time.sleep(0.002)
        os.killpg(killed.pid, signal.SIGKILL)
        killed.communicate()
        self.assertIn("openjd_progress", self.ends_well(other))
        # What the manager does with tasks whose worker is gone.
        self.assertIn("openjd_status: frame 1 skipped", self.ends_well(self.worker(*mine)))
        damaged = frames / "a shot.0020.exr"
        data = bytearray(damaged.read_bytes())
        data[-9] ^= 1
        damaged.write_bytes(data)
        (frames / "a shot.0031.exr").unlink()
        self.ends_well(self.worker("--step", "Validate"))
        self.assertEqual((frames / "missing.txt").read_text(), "20,31\n")
        self.ends_well(self.worker("--step", "RenderAgain"))
        self.ends_well(self.worker("--step", "Check"))
        for number in range(1, FRAMES + 1):
            name = f"a shot.{number:04d}.exr"
            self.assertEqual((frames / name).read_bytes(), (self.folder / "once" / name).read_bytes(), name)

    def test_the_whole_job_at_once(self):
        self.ends_well(
            self.worker("--step", "Check", "--run-dependencies", "-p", "Frames=1-12:3", "-p", "ChunkSize=2")
        )
        names = sorted(path.name for path in (self.job / "frames").glob("*.exr"))
        self.assertEqual(names, [f"a shot.{number:04d}.exr" for number in (1, 4, 7, 10)])

    def test_a_task_that_fails_says_why(self):
        worker = self.worker(*self.tasks("1-8"), shot=self.folder / "nowhere.ron")
        out, _ = worker.communicate(timeout=120)
        self.assertNotEqual(worker.returncode, 0)
        self.assertRegex(out, r"openjd_fail: .*nowhere\.ron.*cannot be read")

    def test_a_frame_that_fails_says_why_and_the_others_are_kept(self):
        frames = self.job / "frames"
        blocked, first = frames / "a shot.0003.exr", frames / "a shot.0001.exr"
        blocked.mkdir(parents=True)
        worker = self.worker(*self.tasks("1-8"))
        out, _ = worker.communicate(timeout=120)
        self.assertNotEqual(worker.returncode, 0)
        self.assertRegex(out, r"openjd_fail: frame 3: .*a shot\.0003\.exr is a folder.*remedy: ")
        kept = first.stat().st_mtime_ns
        blocked.rmdir()
        self.assertIn("openjd_status: frame 2 skipped", self.ends_well(self.worker(*self.tasks("1-8"))))
        self.assertEqual(first.stat().st_mtime_ns, kept)
        self.assertEqual(len(list(frames.glob("*.exr"))), 8)

    @unittest.skipUnless(importlib.util.find_spec("openjd"), "the modules of openjd are not installed")
    def test_paths_of_windows_are_mapped(self):
        from openjd.model import ParameterValue, ParameterValueType, create_job, decode_job_template
        from openjd.sessions import ActionState, PathFormat, PathMappingRule, Session

        template = json.loads((self.job / "template.json").read_text())
        template = decode_job_template(template=template, supported_extensions=["TASK_CHUNKING"])
        text = {
            "Frames": "1-2",
            "ChunkSize": "2",
            "Sunfleck": str(Path(PROGRAM).resolve()),
            "Tools": str(self.tools),
        }
        paths = {
            "Input": r"C:\The Shows\a shot.ron",
            "Output": r"C:\The Shows\frames",
            "Bakes": r"C:\The Shows\bakes",
        }
        kinds = {definition.name: definition.type.value for definition in template.parameterDefinitions}
        values = {
            name: ParameterValue(type=ParameterValueType(kinds[name]), value=value)
            for name, value in (text | paths).items()
        }
        job = create_job(job_template=template, job_parameter_values=values)
        rule = PathMappingRule(
            source_path_format=PathFormat.WINDOWS,
            source_path=PureWindowsPath(r"C:\The Shows"),
            destination_path=self.folder,
        )
        with Session(session_id="mapped", job_parameter_values=values, path_mapping_rules=[rule]) as session:
            chunk = ParameterValue(type=ParameterValueType.CHUNK_INT, value="1-2")
            session.run_task(step_script=job.steps[0].script, task_parameter_values={"Frame": chunk})
            deadline = time.monotonic() + 120
            while session.state.value == "running" and time.monotonic() < deadline:
                time.sleep(0.05)
            self.assertEqual(session.action_status.state, ActionState.SUCCESS)
        self.assertEqual(len(list((self.folder / "frames").glob("*.exr"))), 2)


@unittest.skipUnless(shutil.which("node"), "there is no node to run Flamenco's script")
class Flamenco(WithShot):
    def test_the_job_type_makes_tasks_that_wait_for_one_another(self):
        job = self.farm("--profile", "flamenco", "--chunk", "20")
        # What Flamenco gives scripts, as far as this one uses it.
        script = """
        const tasks = [];
        const author = {
            Task: (name) => ({ name, commands: [], after: [],
                addCommand(command) { this.commands.push(command); }, addDependency(task) { this.after.push(task.name); } }),
            Command: (name, parameters) => ({ name, ...parameters }),
        };
        const frameChunker = (frames, size) => ["1-20", "21-40", "41-48"];
        """
        script += (job / "sunfleck.js").read_text()
        script += (
            f"compileJob({{ ...{(job / 'job.json').read_text()}, addTask: (task) => tasks.push(task) }});"
        )
        script += "console.log(JSON.stringify(tasks));"
        tasks = json.loads(
            subprocess.run(["node", "-e", script], check=True, capture_output=True, text=True).stdout
        )
        renders = ["Render 1-20", "Render 21-40", "Render 41-48"]
        self.assertEqual([task["name"] for task in tasks], [*renders, "Validate", "RenderAgain", "Check"])
        self.assertEqual([task["after"] for task in tasks[2:]], [[], renders, ["Validate"], ["RenderAgain"]])
        (command,) = tasks[1]["commands"]
        self.assertEqual((command["name"], command["exe"]), ("exec", "{sunfleck}"))
        self.assertEqual(command["args"][:3], ["render", str(self.shot), "--frames=21-40"])
        self.assertIn(f"--out={job}/frames/", command["args"])
