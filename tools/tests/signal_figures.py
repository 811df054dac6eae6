"""How soon `sunfleck render` ends after a signal:
`SUNFLECK=... python -m tests.signal_figures [MOMENTS] [INPUT]` in tools/.

A heavy frame gets SIGTERM at moments spread evenly over its first seconds. These are loading, baking, the
building of trees, and rendering until all its memory is in use, which the system wants back at the end.
Printed are the median, the 99th hundredth and the worst time from the signal to the end of the process, and
what the ends were. A machine that does other work makes it wait: look at the median first.
"""

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
SPAN_S = 1.2
"""Moments lie within so many seconds from the start: a frame of `title` has all its memory after one
(`VmRSS`: 25 MB after .1 s, 170 after .3, 338 after .6, 436 after 1, 385 from then on)."""
GOLDEN = 0.618033988749895
"""Its multiples are spread evenly, however many there are."""


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
        ends = [
            seconds_to_end(scene, 0.02 + SPAN_S * (number * GOLDEN % 1), f"{folder}/")
            for number in range(moments)
        ]
        left = [name for name in os.listdir(folder) if name.endswith(".sunfleck-part")]
    took_ms = 1e3 * np.array([each for each, _ in ends])
    middle, most, worst = np.quantile(took_ms, (0.5, 0.99, 1))
    codes = ", ".join(
        f"{code} {count} times" for code, count in sorted(Counter(code for _, code in ends).items())
    )
    print(
        f"{moments} signals: median {middle:.0f} ms, 99 % within {most:.0f}, worst {worst:.0f}; "
        f"{np.count_nonzero(took_ms > 100)} over 100 ms"
    )
    print(f"exit codes {codes}; {len(left)} part files left")


if __name__ == "__main__":
    main()
