"""A render farm by discrete events: nodes, a manager, a disk that all share, and nodes that fail.

In go a farm and its work, out comes where the time of all nodes went. Invariants: the same seed gives the
same outcome. The shares of an outcome add up to 1. Frames that are whole are never rendered again, as with
`--skip valid`. `python -m tests.farm_simulation` in `tools/` prints the table of docs/farm.md.
"""

import heapq
import math
from collections import deque
from dataclasses import dataclass
from random import Random

HOUR_S = 3600.0
HOPELESS = 4.0
"""Failures that a node may expect while it starts and renders a frame; beyond, hardly a frame gets done."""


@dataclass(frozen=True)
class Farm:
    """Machines, and how they start tasks."""

    nodes: int
    dispatch_s: float = 0.002
    """Of the manager, which hands out one task after the other."""
    start_s: float = 2.0
    """From the manager's word until the program runs."""
    load_s: float = 1.0
    """Of the scene, beside reading its files."""
    scene_mb: float = 0.0
    frame_mb: float = 0.0
    disk_mb_per_s: float = math.inf
    """Of all nodes together; what they ask for is served in the order in which they ask."""
    failures_per_h: float = 0.0
    """Of a node. Failures have no memory: the times between them are exponential."""
    restart_s: float = 300.0
    """From a node's failure until it takes tasks again."""


@dataclass(frozen=True)
class Work:
    """Frames, and how they are handed out."""

    frames: int
    frame_s: float
    """Mean time of a frame on a node, without writing it."""
    spread: float = 0.0
    """Standard deviation of that time by its mean. Times are log-normal, and the same whoever renders."""
    chunk: int = 1


@dataclass(frozen=True)
class Outcome:
    """Shares are of the time of all nodes together, from the first task to the last whole frame."""

    seconds: float
    frames_per_h: float
    rendering: float
    """Of frames that were kept: the share of the ideal."""
    starting: float
    """Waiting for the manager, start of the program, load of the scene."""
    writing: float
    """Frames to the disk, and waiting for it."""
    lost: float
    """What failures undid, and restarts of nodes."""
    idle: float
    """No task is left."""
    failures: int


def simulate(farm: Farm, work: Work, seed: int = 0) -> Outcome:
    """Raises `ValueError` if nodes fail too often for frames to get done."""
    times = _frame_times(work, Random(seed))
    disk_s = (farm.scene_mb + farm.frame_mb) / farm.disk_mb_per_s * farm.nodes
    longest = farm.start_s + farm.load_s + max(times) + disk_s
    if farm.failures_per_h * longest / HOUR_S > HOPELESS:
        raise ValueError(
            f"a node with {farm.failures_per_h:g} failures an hour hardly starts and renders a frame in "
            f"{longest:.0f} s between two of them: fewer failures, or shorter frames"
        )
    return _Run(farm, work, times, Random(seed + 1)).outcome()


def _frame_times(work: Work, random: Random) -> list[float]:
    if work.spread == 0:
        return [work.frame_s] * work.frames
    variance = math.log1p(work.spread**2)
    middle, width = math.log(work.frame_s) - variance / 2, math.sqrt(variance)
    return [random.lognormvariate(middle, width) for _ in range(work.frames)]


class _Node:
    """What it does since when, and the frames of its task that are not whole yet."""

    __slots__ = ("doing", "since", "frame", "end", "fails_at", "rendered_s")

    def __init__(self) -> None:
        self.doing, self.since = "starting", 0.0
        self.frame = self.end = 0
        self.fails_at = math.inf
        self.rendered_s = 0.0


class _Run:
    """The queue of events, each a time, a number that settles ties, what happens, and the node."""

    def __init__(self, farm: Farm, work: Work, times: list[float], random: Random):
        self.farm, self.times, self.random = farm, times, random
        self.tasks = deque(
            (first, min(first + work.chunk, work.frames)) for first in range(0, work.frames, work.chunk)
        )
        self.left = work.frames
        self.nodes = [_Node() for _ in range(farm.nodes)]
        self.waiting: deque[_Node] = deque()
        self.spent = dict.fromkeys(("rendering", "starting", "writing", "lost", "idle"), 0.0)
        self.manager_free = self.disk_free = self.end = 0.0
        self.events: list = []
        self.count = self.failures = 0

    def outcome(self) -> Outcome:
        for node in self.nodes:
            self._at(0.0, self._asks, node)
        while self.left:
            time, _, happens, node = heapq.heappop(self.events)
            happens(time, node)
        for node in self.nodes:
            self._account(self.end, node, node.doing)
        total = self.end * self.farm.nodes
        shares = {name: spent / total for name, spent in self.spent.items()}
        return Outcome(
            seconds=self.end, frames_per_h=len(self.times) / self.end * HOUR_S, failures=self.failures, **shares
        )

    def _at(self, time: float, happens, node: _Node) -> None:
        """Unless the node fails before."""
        if time >= node.fails_at:
            time, happens = node.fails_at, self._fails
        self.count += 1
        heapq.heappush(self.events, (time, self.count, happens, node))

    def _account(self, time: float, node: _Node, name: str) -> None:
        self.spent[name] += time - node.since
        node.since = time

    def _asks(self, time: float, node: _Node) -> None:
        """A node is free."""
        node.fails_at = math.inf
        if not self.tasks:
            node.doing = "idle"
            self.waiting.append(node)
            return
        node.doing = "starting"
        node.frame, node.end = self.tasks.popleft()
        if self.farm.failures_per_h:
            node.fails_at = time + self.random.expovariate(self.farm.failures_per_h / HOUR_S)
        self.manager_free = max(time, self.manager_free) + self.farm.dispatch_s
        self._at(self.manager_free + self.farm.start_s, self._loads, node)

    def _loads(self, time: float, node: _Node) -> None:
        self._at(self._disk(time, self.farm.scene_mb) + self.farm.load_s, self._renders, node)

    def _renders(self, time: float, node: _Node) -> None:
        self._account(time, node, "starting")
        self._begins(time, node)

    def _begins(self, time: float, node: _Node) -> None:
        node.doing = "lost"  # until it is whole
        self._at(time + self.times[node.frame], self._writes, node)

    def _writes(self, time: float, node: _Node) -> None:
        node.rendered_s = time - node.since
        self._at(self._disk(time, self.farm.frame_mb), self._is_whole, node)

    def _is_whole(self, time: float, node: _Node) -> None:
        self.spent["rendering"] += node.rendered_s
        self.spent["writing"] += time - node.since - node.rendered_s
        node.since = self.end = time
        self.left -= 1
        node.frame += 1
        if node.frame < node.end:
            self._begins(time, node)
        else:
            self._asks(time, node)

    def _fails(self, time: float, node: _Node) -> None:
        self.failures += 1
        self._account(time, node, "lost")
        node.doing, node.fails_at = "lost", math.inf
        self.tasks.appendleft((node.frame, node.end))
        self._at(time + self.farm.restart_s, self._restarts, node)
        if self.waiting:
            idle = self.waiting.popleft()
            self._account(time, idle, "idle")
            self._asks(time, idle)

    def _restarts(self, time: float, node: _Node) -> None:
        self._account(time, node, "lost")
        self._asks(time, node)

    def _disk(self, time: float, megabytes: float) -> float:
        """When so much is read or written."""
        self.disk_free = max(time, self.disk_free) + megabytes / self.farm.disk_mb_per_s
        return self.disk_free if megabytes else time


def main() -> None:
    """Prints what becomes of a thousand nodes by size of chunk."""
    farm = Farm(1000, scene_mb=100.0, frame_mb=4.0, disk_mb_per_s=5000.0, failures_per_h=0.01)
    columns = ("chunk", "hours", "frames/h", "ideal", "start", "write", "lost", "idle", "failures")
    print("".join(f"{name:>10}" for name in columns))
    for chunk in (1, 4, 10, 32):
        found = simulate(farm, Work(100_000, 60.0, 0.25, chunk))
        shares = (found.rendering, found.starting, found.writing, found.lost, found.idle)
        cells = [f"{chunk}", f"{found.seconds / HOUR_S:.3f}", f"{found.frames_per_h:.0f}"]
        cells += [f"{100 * share:.1f} %" for share in shares] + [f"{found.failures}"]
        print("".join(f"{cell:>10}" for cell in cells), flush=True)


if __name__ == "__main__":
    main()
