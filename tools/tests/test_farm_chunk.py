"""`sunfleck farm --chunk auto` beside the best chunk of the same farm by simulation."""

import re
import subprocess
import unittest
from dataclasses import replace
from statistics import mean

from .command import PROGRAM
from .farm_simulation import Farm, Work, simulate
from .test_farm import FRAMES, SHOT, WithShot

CHUNKS = (1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 48, 64, 100, 150)
CASES = [  # machines, frames, seconds a frame, seeds
    (10, 1000, 2.0, 6), (10, 1000, 60.0, 6), (20, 5000, 4.0, 4), (100, 2400, 10.0, 8), (300, 9000, 6.0, 3),
    (300, 7200, 5.0, 8), (10_000, 20_000, 120.0, 1),
]  # fmt: skip
START_S, SPREAD, FAILURES_PER_H = 2.0, 0.25, 0.01
"""What `src/cli/farm/chunk.rs` takes for granted of managers and machines; this scene loads at once."""


class Chosen(WithShot):
    def chosen(self, machines: int, frames: int, frame_s: float) -> int:
        self.shot.write_text(SHOT.replace(f"(1, {FRAMES})", f"(1, {frames})"))
        done = subprocess.run(
            [PROGRAM, "farm", self.shot, "--out", self.folder / "job", "--chunk", "auto",
             "--machines", str(machines), "--frame-seconds", str(frame_s)],
            check=True, capture_output=True, text=True,
        )  # fmt: skip
        return int(re.search(r"in tasks of (\d+),", done.stdout)[1])

    def test_it_is_within_a_hundredth_of_the_best(self):
        usual_loss = []
        for machines, frames, frame_s, seeds in CASES:
            with self.subTest(machines=machines, frames=frames, frame_s=frame_s):
                farm = Farm(machines, start_s=START_S, load_s=0.0, failures_per_h=FAILURES_PER_H)
                work = Work(frames, frame_s, SPREAD)

                def seconds(chunk: int) -> float:
                    return mean(simulate(farm, replace(work, chunk=chunk), 2 * seed).seconds for seed in range(seeds))

                chosen = self.chosen(machines, frames, frame_s)
                # Beyond twice the frames that a machine has, most machines have none.
                wanted = [chunk for chunk in CHUNKS if chunk <= 2 * frames / machines]
                taken = {chunk: seconds(chunk) for chunk in {*wanted, chosen, 8}}
                best = min(taken.values())
                self.assertLess(taken[chosen] / best, 1.01, f"{chosen} of {sorted(taken.items())}")
                usual_loss.append(taken[8] / best - 1)
        # What is chosen without thought is worse.
        self.assertGreater(max(usual_loss), 0.5)


if __name__ == "__main__":
    unittest.main()
