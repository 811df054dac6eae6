"""What a farm's job takes beyond a plain run: the same frames by `openjd run` in chunks of 8, and at once.

    SUNFLECK=../target/release/sunfleck python -m tests.farm_overhead          (in tools/)

Both take turns. Writing the job, which is done once, does not count; starting a session does.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from .command import NO_PROGRAM, PROGRAM, SEQUENCES
from .test_farm import OPENJD


def seconds(command: list[str | Path]) -> float:
    """By the clock."""
    start = time.monotonic()
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"{command} ended with {done.returncode}: {done.stdout[-500:]}{done.stderr[-500:]}")
    return time.monotonic() - start


def main() -> int:
    """Prints both, round by round, and their ratio by the least of each."""
    plain = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=plain)
    parser.add_argument("--sequence", type=Path, default=SEQUENCES / "falling_leaves.ron")
    parser.add_argument("--frames", default="1-16", help="default: %(default)s")
    parser.add_argument("--rounds", type=int, default=2)
    arguments = parser.parse_args()
    if PROGRAM is None or OPENJD is None:
        print(f"error: {NO_PROGRAM if PROGRAM is None else 'openjd is not installed'}", file=sys.stderr)
        return 2
    program, sequence, frames = Path(PROGRAM).resolve(), arguments.sequence.resolve(), arguments.frames
    found: dict[str, list[float]] = {"at once": [], "in chunks of 8": []}
    for number in range(arguments.rounds):
        with tempfile.TemporaryDirectory() as scratch:
            folder = Path(scratch)
            once = [program, "render", sequence, "--frames", frames, "--progress", "none", "--out", folder / "once/"]
            found["at once"].append(seconds(once))
            job = folder / "job"
            seconds([program, "farm", sequence, "--frames", frames, "--out", job, "--chunk", "8"])
            chunks = [OPENJD, "run", job / "template.json", "--step", "Render", "-p", f"Input={sequence}"]
            found["in chunks of 8"].append(seconds([*chunks, "-p", f"Sunfleck={program}"]))
        print(f"round {number + 1}: " + ", ".join(f"{name} {times[-1]:.1f} s" for name, times in found.items()), flush=True)
    once, chunks = (min(times) for times in found.values())
    print(f"overhead {100 * (chunks / once - 1):.1f} %")
    return 0


if __name__ == "__main__":
    sys.exit(main())
