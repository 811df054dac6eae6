"""What a farm's job takes beyond a plain run, on this machine: the same frames as a job, and at once.

    SUNFLECK=../target/release/sunfleck python -m tests.farm_overhead --profile shell      (in tools/)

Both take turns, with as many threads together. Writing the job, which is done once, does not count, nor does
starting the manager. With `openjd` the step `Render` counts. Its session is told apart from the start of
`openjd`, as a worker on a farm runs all the time. `shell` is two machines, and `slurm` two nodes, each with
half of the threads: all four steps count, with two looks at every frame.
"""

import argparse
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from .command import NO_PROGRAM, PROGRAM, SEQUENCES
from .slurm import NO_SLURM, Slurm
from .test_farm import OPENJD, TOOLS

MACHINES = 2


def seconds(command: list[str | Path], environment: dict[str, str] | None = None) -> tuple[float, str]:
    """By the clock, and what was printed."""
    start = time.monotonic()
    done = subprocess.run(command, capture_output=True, text=True, env=environment)
    if done.returncode != 0:
        raise SystemExit(f"{command} ended with {done.returncode}: {done.stdout[-500:]}{done.stderr[-500:]}")
    return time.monotonic() - start, done.stdout


def session_seconds(printed: str) -> float:
    """At the last line of a session, which has its time in front."""
    *_, (hours, minutes, rest) = re.findall(r"(?m)^(\d+):(\d+):([\d.]+)\t", printed)
    return 3600 * int(hours) + 60 * int(minutes) + float(rest)


def by_openjd(job: Path, sequence: Path, _: dict[str, str]) -> dict[str, float]:
    """Of the command, and of its session."""
    command = [OPENJD, "run", job / "template.json", "--step", "Render"]
    took, printed = seconds([*command, "-p", f"Input={sequence}", "-p", f"Sunfleck={Path(PROGRAM).resolve()}"])
    return {"as a job": took, "its session": session_seconds(printed)}


def by_shell(job: Path, _: Path, environment: dict[str, str]) -> dict[str, float]:
    """Until both machines have ended, and the sequence was found whole."""
    start = time.monotonic()
    scripts = sorted(job.glob("machine-*.sh"))
    machines = [
        subprocess.Popen(["sh", script], env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        for script in scripts
    ]
    codes = [machine.wait() for machine in machines]
    if any(codes):
        raise SystemExit(f"the machines ended with {codes}")
    return {"as a job": time.monotonic() - start}


def by_slurm(job: Path, _: Path, environment: dict[str, str]) -> dict[str, float]:
    """Until the last step has ended, well."""
    slurm = Slurm()
    try:
        slurm.start()
        start = time.monotonic()
        _, told = seconds(["sh", job / "submit.sh", "--mem=500M"], environment | slurm.environment)
        slurm.wait_for(lambda: not slurm.states(), 3600)
        took = time.monotonic() - start
        last = slurm.told("scontrol", "show", "job", re.search(r"if job (\d+) ends well", told)[1])
    finally:
        slurm.stop()
    if "JobState=COMPLETED" not in last:
        raise SystemExit(f"the sequence is not whole: {last}")
    return {"as a job": took}


WAYS: dict[str, Callable[[Path, Path, dict[str, str]], dict[str, float]]] = {
    "openjd": by_openjd,
    "shell": by_shell,
    "slurm": by_slurm,
}


def lacks(profile: str) -> str:
    """What there is not; empty if all is there."""
    if PROGRAM is None:
        return NO_PROGRAM
    if profile == "openjd" and OPENJD is None:
        return "openjd is not installed"
    return NO_SLURM if profile == "slurm" else ""


def both(arguments: argparse.Namespace, folder: Path) -> dict[str, float]:
    """A plain run and a job, one after the other."""
    program, sequence = Path(PROGRAM).resolve(), arguments.sequence.resolve()
    tools = folder / "tools"
    tools.write_text(f'#!/bin/sh\nPYTHONPATH="{TOOLS}" exec "{sys.executable}" -m sunfleck_tools "$@"\n')
    tools.chmod(0o755)
    environment = os.environ | {"SUNFLECK": str(program), "SUNFLECK_TOOLS": str(tools)}
    frames = ["--frames", arguments.frames]
    once = ["render", sequence, "--progress", "none", *frames, "--threads", str(arguments.threads)]
    plain, _ = seconds([program, *once, "--out", folder / "once/"])
    job = folder / "job"
    line = ["farm", sequence, "--profile", arguments.profile, "--chunk", str(arguments.chunk), *frames, "--out", job]
    machines = 1 if arguments.profile == "openjd" else MACHINES
    if arguments.profile == "shell":
        line += ["--machines", str(machines)]
    seconds([program, *line, "--", "--threads", str(max(1, arguments.threads // machines))])
    return {"at once": plain} | WAYS[arguments.profile](job, sequence, environment)


def main() -> int:
    """Prints both, round by round, and their ratio by the least of each."""
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=raw)
    parser.add_argument("--profile", choices=WAYS, default="openjd", help="default: %(default)s")
    parser.add_argument("--sequence", type=Path, default=SEQUENCES / "falling_leaves.ron")
    parser.add_argument("--frames", default="1-16", help="default: %(default)s")
    parser.add_argument("--chunk", type=int, default=8, help="default: %(default)s")
    parser.add_argument("--threads", type=int, default=os.cpu_count(), help="of all together (%(default)s)")
    parser.add_argument("--rounds", type=int, default=2)
    arguments = parser.parse_args()
    if missing := lacks(arguments.profile):
        print(f"error: {missing}", file=sys.stderr)
        return 2
    rounds: list[dict[str, float]] = []
    for number in range(arguments.rounds):
        with tempfile.TemporaryDirectory() as scratch:
            rounds.append(both(arguments, Path(scratch)))
        told = ", ".join(f"{name} {took:.1f} s" for name, took in rounds[-1].items())
        print(f"round {number + 1}: {told}", flush=True)
    once, *jobs = ((name, min(found[name] for found in rounds)) for name in rounds[0])
    print(", ".join(f"{name} {took / once[1]:.3f} times" for name, took in jobs))
    return 0


if __name__ == "__main__":
    sys.exit(main())
