"""Farms by simulation, against what can be said of them in closed form."""

import math
import unittest
from dataclasses import replace
from statistics import mean

from .farm_simulation import HOUR_S, Farm, Work, simulate

PLAIN = Farm(nodes=1, dispatch_s=0.0, start_s=3.0, load_s=2.0)


def shares(outcome) -> tuple[float, ...]:
    return outcome.rendering, outcome.starting, outcome.writing, outcome.lost, outcome.idle


class WithoutChance(unittest.TestCase):
    """Sums of times."""

    def test_one_node_does_one_thing_after_the_other(self):
        farm = replace(PLAIN, dispatch_s=0.5, scene_mb=100, frame_mb=20, disk_mb_per_s=200)
        outcome = simulate(farm, Work(10, 7.0, chunk=4))
        self.assertAlmostEqual(outcome.seconds, 3 * (0.5 + 3 + 2 + 100 / 200) + 10 * (7 + 20 / 200))
        self.assertAlmostEqual(outcome.rendering, 70 / outcome.seconds)
        self.assertAlmostEqual(outcome.starting, 3 * 6 / outcome.seconds)
        self.assertAlmostEqual(outcome.writing, 1 / outcome.seconds)
        self.assertEqual((outcome.lost, outcome.idle, outcome.failures), (0, 0, 0))
        self.assertAlmostEqual(outcome.frames_per_h, 10 / outcome.seconds * HOUR_S)

    def test_chunks_beyond_frames_by_nodes_leave_nodes_idle(self):
        outcome = simulate(replace(PLAIN, nodes=10), Work(100, 1.0, chunk=25))
        self.assertAlmostEqual(outcome.seconds, 5 + 25)
        self.assertAlmostEqual(outcome.idle, 6 / 10)

    def test_the_last_wave_leaves_nodes_idle(self):
        # 25 chunks on 10 nodes are three waves, the last with half of the nodes.
        outcome = simulate(replace(PLAIN, nodes=10), Work(100, 1.0, chunk=4))
        self.assertAlmostEqual(outcome.seconds, 3 * (5 + 4))
        self.assertAlmostEqual(outcome.idle, 5 / 30)

    def test_the_manager_and_the_disk_are_limits(self):
        many = replace(PLAIN, nodes=1000)
        slow_manager = simulate(replace(many, dispatch_s=0.1), Work(4000, 1.0))
        self.assertAlmostEqual(slow_manager.seconds, 4000 * 0.1 + 5 + 1)
        slow_disk = simulate(replace(many, frame_mb=50, disk_mb_per_s=500), Work(4000, 1.0))
        self.assertAlmostEqual(slow_disk.seconds, 4000 * 50 / 500 + 5 + 1)


class Failures(unittest.TestCase):
    """Of no memory: a frame of x s, after which a failure costs R s, takes (exp(rate x) - 1) (1 / rate + R) s
    in the mean (J. T. Daly, Future Generation Computer Systems 22, 2006, section 3)."""

    def test_lost_work_is_as_daly_says(self):
        frame_s, restart_s, rate = 60.0, 30.0, 1 / 200
        farm = Farm(1, 0.0, 0.0, 0.0, failures_per_h=rate * HOUR_S, restart_s=restart_s)
        frames = 20_000
        outcome = simulate(farm, Work(frames, frame_s, chunk=50))
        expected = frames * math.expm1(rate * frame_s) * (1 / rate + restart_s)
        # Failures are a Poisson process, some 7,000 of them.
        self.assertLess(abs(outcome.seconds / expected - 1), 3 / math.sqrt(outcome.failures))
        self.assertAlmostEqual(outcome.lost, 1 - frames * frame_s / outcome.seconds)

    def test_of_a_chunk_that_fails_only_the_frame_in_hand_is_rendered_again(self):
        farm = Farm(1, 0.0, 0.0, 0.0, failures_per_h=6.0, restart_s=0.0)
        small, large = (simulate(farm, Work(20_000, 60.0, chunk=chunk)) for chunk in (1, 1000))
        self.assertLess(abs(small.lost / large.lost - 1), 4 / math.sqrt(small.failures))
        self.assertLess(large.lost, 0.08)

    def test_nodes_that_fail_too_often_are_said(self):
        with self.assertRaisesRegex(ValueError, "failures an hour"):
            simulate(Farm(10, failures_per_h=1000.0), Work(10, 60.0))


class Properties(unittest.TestCase):
    FARM = Farm(20, 0.01, scene_mb=50, frame_mb=5, disk_mb_per_s=500, failures_per_h=0.2)
    WORK = Work(2000, 20.0, 0.4, 6)

    def seconds(self, farm: Farm, work: Work | None = None) -> float:
        return mean(simulate(farm, work or self.WORK, seed).seconds for seed in range(5))

    def test_shares_add_up_and_the_seed_says_all(self):
        outcome = simulate(self.FARM, self.WORK, 7)
        self.assertAlmostEqual(sum(shares(outcome)), 1)
        self.assertGreater(min(shares(outcome)), 0)
        self.assertEqual(outcome, simulate(self.FARM, self.WORK, 7))
        self.assertNotEqual(outcome, simulate(self.FARM, self.WORK, 8))

    def test_what_is_worse_takes_longer(self):
        usual = self.seconds(self.FARM)
        for worse in (
            {"nodes": 15}, {"dispatch_s": 0.5}, {"start_s": 20.0}, {"load_s": 20.0}, {"scene_mb": 1000.0},
            {"frame_mb": 50.0}, {"disk_mb_per_s": 50.0}, {"failures_per_h": 4.0}, {"restart_s": 3000.0},
        ):  # fmt: skip
            self.assertGreater(self.seconds(replace(self.FARM, **worse)), usual, worse)

    def test_no_farm_is_better_than_ideal(self):
        for nodes in (1, 10, 100):
            outcome = simulate(replace(self.FARM, nodes=nodes), self.WORK)
            self.assertLess(outcome.frames_per_h, nodes * HOUR_S / self.WORK.frame_s * 1.03)


if __name__ == "__main__":
    unittest.main()
