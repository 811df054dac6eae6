"""What a farm's job takes beyond a plain run: the same frames by `openjd run` in chunks of 8, and at once.

    SUNFLECK=../target/release/sunfleck python -m tests.farm_overhead          (in tools/)

Both take turns. Writing the job, which is done once, does not count. The session is told apart from the start
of `openjd`, as a worker on a farm runs all the time.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from .command import NO_PROGRAM, PROGRAM, SEQUENCES
from .test_farm import OPENJD


def seconds(command: list[str | Path]) -> tuple[float, str]:
    """By the clock, and what was printed."""
    start = time.monotonic()
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"{command} ended with {done.returncode}: {done.stdout[-500:]}{done.stderr[-500:]}")
    return time.monotonic() - start, done.stdout


def session_seconds(printed: str) -> float:
    """At the last line of a session, which has its time in front."""
    *_, (hours, minutes, rest) = re.findall(r"(?m)^(\d+):(\d+):([\d.]+)\t", printed)
    return 3600 * int(hours) + 60 * int(minutes) + float(rest)


def main() -> int:
    """Prints both, round by round, and their ratio by the least of each."""
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=raw)
    parser.add_argument("--sequence", type=Path, default=SEQUENCES / "falling_leaves.ron")
    parser.add_argument("--frames", default="1-16", help="default: %(default)s")
    parser.add_argument("--rounds", type=int, default=2)
    arguments = parser.parse_args()
    if PROGRAM is None or OPENJD is None:
        print(f"error: {NO_PROGRAM if PROGRAM is None else 'openjd is not installed'}", file=sys.stderr)
        return 2
    program, sequence, frames = Path(PROGRAM).resolve(), arguments.sequence.resolve(), arguments.frames
    found: dict[str, list[float]] = {"at once": [], "in chunks of 8": [], "its session": []}
    for number in range(arguments.rounds):
        with tempfile.TemporaryDirectory() as scratch:
            folder = Path(scratch)
            flags = ["--frames", frames, "--out"]
            plain, _ = seconds([program, "render", sequence, "--progress", "none", *flags, folder / "once/"])
            seconds([program, "farm", sequence, "--chunk", "8", *flags, folder / "job"])
            job = [OPENJD, "run", folder / "job" / "template.json", "--step", "Render"]
            chunks, printed = seconds([*job, "-p", f"Input={sequence}", "-p", f"Sunfleck={program}"])
        for times, value in zip(found.values(), (plain, chunks, session_seconds(printed))):
            times.append(value)
        told = ", ".join(f"{name} {times[-1]:.1f} s" for name, times in found.items())
        print(f"round {number + 1}: {told}", flush=True)
    once, chunks, session = (min(times) for times in found.values())
    print(f"overhead {100 * (chunks / once - 1):.1f} %, of its session {100 * (session / once - 1):.1f} %")
    return 0


if __name__ == "__main__":
    sys.exit(main())
