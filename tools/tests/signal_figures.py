"""How soon `sunfleck render` ends after a signal: `SUNFLECK=... python -m tests.signal_figures [MOMENTS] [INPUT]` in tools/.

A heavy frame gets SIGTERM at moments spread evenly from its start on, through loading, baking, the building of trees and
rendering. Printed: the median and the worst time from the signal to the end of the process, and what the ends were.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np

PROGRAM = os.environ.get("SUNFLECK", "../target/release/sunfleck")
HEAVY = Path(__file__).parents[2] / "sequences/title.ron"
SPAN_S = 8.0
"""Moments lie within so many seconds from the start: a frame of `title` takes longer."""


def seconds_to_end(scene: Path, moment_s: float, folder: str) -> tuple[float, int]:
    """From SIGTERM to the end of the process, and its exit code."""
    command = [PROGRAM, "render", str(scene), "--frames", "24", "--samples", "4096", "--out", folder, "--progress", "none"]
    process = subprocess.Popen(command, stderr=subprocess.DEVNULL)
    time.sleep(moment_s)
    sent = time.perf_counter()
    process.send_signal(signal.SIGTERM)
    code = process.wait()
    return time.perf_counter() - sent, code


def main() -> None:
    """Prints the figures."""
    moments = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    scene = Path(sys.argv[2]) if len(sys.argv) > 2 else HEAVY
    with tempfile.TemporaryDirectory() as folder:
        # The golden ratio's multiples are spread evenly, however many there are.
        ends = [seconds_to_end(scene, 0.02 + SPAN_S * (number * 0.618033988749895 % 1), f"{folder}/") for number in range(moments)]
        left = [name for name in os.listdir(folder) if name.endswith(".sunfleck-part")]
    seconds = 1e3 * np.array([each for each, _ in ends])
    codes = ", ".join(f"{code} {count} times" for code, count in sorted(Counter(code for _, code in ends).items()))
    print(f"{moments} signals: median {np.median(seconds):.0f} ms, worst {seconds.max():.0f} ms; exit codes {codes}; {len(left)} part files left")


if __name__ == "__main__":
    main()
