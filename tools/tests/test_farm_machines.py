"""`sunfleck farm`: jobs of Slurm and of machines without a manager, run for real, with what goes wrong."""

import os
import re
import signal
import subprocess
import sys
import time
import unittest
from collections import Counter
from pathlib import Path
from shlex import quote

from .command import PROGRAM
from .slurm import NO_SLURM, Slurm
from .test_farm import FRAMES, TOOLS, WithShot

DONE = re.compile(r"^(?:frame (\d+)\b(?!.*skipped))", re.MULTILINE)


SLOW = """#!/bin/sh
case "$*" in *--frames=25-32*)
    if mkdir {slow} 2>/dev/null; then
        for word; do
            [ "$word" != --frames=25-32 ] || word=--frames=25-29
            set -- "$@" "$word"
            shift
        done
        {program} "$@"
        sleep 600 &
        trap 'kill $!; exit 143' TERM
        wait
    fi ;;
esac
exec {program} "$@"
"""


class Machines(WithShot):
    def setUp(self):
        super().setUp()
        self.tools = self.folder / "tools of this checkout"
        self.tools.write_text(
            f'#!/bin/sh\nPYTHONPATH={quote(str(TOOLS))} exec {quote(sys.executable)} -m sunfleck_tools "$@"\n'
        )
        self.program = self.folder / "the program"
        self.program.write_text(f'#!/bin/sh\nexec {quote(str(Path(PROGRAM).resolve()))} "$@"\n')
        for program in (self.tools, self.program):
            program.chmod(0o755)
        self.environment = {**os.environ, "SUNFLECK": str(self.program), "SUNFLECK_TOOLS": str(self.tools)}

    @property
    def frames(self) -> Path:
        return self.folder / "the job/frames"

    def frame(self, number: int) -> Path:
        return self.frames / f"a shot.{number:04d}.exr"

    def once(self) -> None:
        """All frames in one run, beside the job."""
        subprocess.run(
            [PROGRAM, "render", self.shot, "--out", self.folder / "once/", "--progress", "none"], check=True
        )

    def is_whole(self) -> None:
        """Byte by byte as in one run."""
        for number in range(1, FRAMES + 1):
            once = self.folder / "once" / self.frame(number).name
            self.assertEqual(self.frame(number).read_bytes(), once.read_bytes(), number)
        self.assertEqual(len(list(self.frames.glob("*.exr"))), FRAMES)

    def damage(self, number: int) -> None:
        data = bytearray(self.frame(number).read_bytes())
        data[-9] ^= 1
        self.frame(number).write_bytes(data)

    def wait_for(self, path: Path) -> None:
        deadline = time.monotonic() + 120
        while not path.exists():
            self.assertLess(time.monotonic(), deadline, f"{path} is not there")
            time.sleep(0.002)

    def rendered(self, told: str) -> Counter:
        """How often each frame was rendered, by what tasks told."""
        return Counter(int(number) for number in DONE.findall(told))


class Shell(Machines):
    def machine(self, number: int) -> subprocess.Popen:
        return subprocess.Popen(
            ["sh", self.folder / f"the job/machine-{number}.sh"], env=self.environment, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True,
        )  # fmt: skip

    def test_two_machines_one_killed_and_started_again_one_frame_damaged(self):
        self.once()
        self.farm("--profile", "shell", "--chunk", "4", "--", "--threads", "1")
        killed, other = self.machine(1), self.machine(2)
        claimed = self.folder / "the job/claims"
        self.wait_for(self.frame(2))
        mine = 1 if (claimed / "1/machine-1").exists() else 2
        os.killpg((killed if mine == 1 else other).pid, signal.SIGKILL)
        self.damage(1)
        gone, left = (killed, other) if mine == 1 else (other, killed)
        first, _ = gone.communicate(timeout=120)
        told, _ = left.communicate(timeout=300)
        self.assertEqual(left.returncode, 0, told)
        self.assertIn("finish.sh", told)
        again = self.machine(mine)
        last, _ = again.communicate(timeout=300)
        self.assertEqual(again.returncode, 0, last)
        self.is_whole()
        counts = self.rendered(first + told + last)
        # What is written as its machine is killed may not be told any more.
        self.assertGreaterEqual(len(counts), FRAMES - 1)
        # The damaged one, and none that was whole.
        self.assertEqual({number for number, count in counts.items() if count > 1} - {1}, set())
        self.assertFalse(claimed.exists())

    def test_a_machine_that_is_gone_for_good(self):
        self.once()
        self.farm("--profile", "shell", "--machines", "3")
        gone = self.machine(3)
        self.wait_for(self.frame(3))
        os.killpg(gone.pid, signal.SIGKILL)
        gone.communicate()
        told, _ = self.machine(1).communicate(timeout=300)
        self.assertIn("another machine is at chunk", told)
        subprocess.run(
            ["sh", self.folder / "the job/finish.sh"], env=self.environment, check=True, capture_output=True
        )
        self.is_whole()


@unittest.skipIf(NO_SLURM, NO_SLURM)
class OnSlurm(Machines):
    def setUp(self):
        super().setUp()
        self.slurm = Slurm()
        self.addCleanup(self.slurm.stop)
        self.slurm.start()
        self.environment.update(self.slurm.environment, SUNFLECK=str(self.program), SUNFLECK_TOOLS=str(self.tools))

    def submit(self, *flags: str) -> str:
        """The last job's number, which ends well if the sequence is whole."""
        done = subprocess.run(
            ["sh", self.folder / "the job/submit.sh", *flags], env=self.environment, text=True, capture_output=True
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        return re.search(r"if job (\d+) ends well", done.stdout)[1]

    def ends_well(self, job: str) -> str:
        """What all tasks told."""

        def is_over() -> bool:
            self.slurm.hurry()
            return not self.slurm.states()

        self.slurm.wait_for(is_over, 400)
        logs = {path.name: path.read_text() for path in sorted((self.folder / "the job/logs").iterdir())}
        told = "\n".join(f"== {name}\n{text}" for name, text in logs.items())
        self.assertRegex(self.slurm.told("scontrol", "show", "job", job), "JobState=COMPLETED", told)
        return told

    def test_a_node_is_killed_a_task_reaches_its_limit_a_frame_is_damaged(self):
        self.once()
        # The first time, frame 30 takes for ever, so that its task runs into its limit.
        slow = self.folder / "was slow"
        self.program.write_text(SLOW.format(slow=quote(str(slow)), program=quote(str(Path(PROGRAM).resolve()))))
        self.farm("--profile", "slurm", "--", "--threads", "1")
        # A node has one processor; of a limit of a minute the last seconds are for ending whole.
        job = self.submit("--time=1", "--signal=B:USR1@5", "--mem=100M")
        self.wait_for(self.frame(3))
        at = self.slurm.told("squeue", "-h", "-r", "-t", "running", "-o", "%K %N").split()
        node = at[at.index("0") + 1] if "0" in at else at[1]
        self.slurm.kill_node(node)
        self.damage(1)
        self.slurm.wait_until_down(node)
        self.slurm.start_node(node)
        told = self.ends_well(job)
        self.is_whole()
        self.assertIn("the time limit is near", told)
        counts = self.rendered(told)
        self.assertGreaterEqual(len(counts), FRAMES - 1)
        self.assertEqual({number for number, count in counts.items() if count > 1} - {1}, set(), told)
