"""How many instances a stage asks for, before any is made. In: instancers. Out: counts, those of instancers
within them multiplied.

Invariant: what an instancer within others asks for is counted once for each of its own
instances, however deep.
"""

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from .losses import TooMuch
from .source import Source

MOST_INSTANCES = 1_000_000
"""Of a stage: as many leaves as a scene may have. They take half a minute, and up to 2 gigabytes."""
DEEPEST = 64
"""Instancers within instancers."""


class Census:
    """Counts the instances of a stage as its instancers are met."""

    def __init__(self, source: Source):
        self.source = source
        self._found = 0
        self._known: dict[Sdf.Path, int] = {}

    def add(self, prim: Usd.Prim) -> None:
        """Takes in an instancer that stands in no other, with all within it. Raises `TooMuch`."""
        self._found += self._instances(prim, 0)
        if self._found > MOST_INSTANCES:
            raise TooMuch(
                f"{prim.GetPath()}: with it there are {self._found} instances, those within others "
                "multiplied; "
                f"a file holds {MOST_INSTANCES}: make it smaller or inactive, or read parts of the stage by "
                "--mask"
            )

    def _instances(self, prim: Usd.Prim, depth: int) -> int:
        """Of an instancer: each counts one, and what its prototype asks for."""
        if depth >= DEEPEST:
            raise TooMuch(
                f"{prim.GetPath()}: instancers within instancers, {DEEPEST} deep: do they come round?"
            )
        path = prim.GetPath()
        if path not in self._known:
            counts = self._counts(prim)
            targets = UsdGeom.PointInstancer(prim).GetPrototypesRel().GetForwardedTargets()[: len(counts)]
            # One that is an instance of itself is left out when it is read.
            prototypes = [
                None if path.HasPrefix(target) else prim.GetStage().GetPrimAtPath(target)
                for target in targets
            ]
            self._known[path] = sum(
                count * (1 + self._below(each, depth)) for count, each in zip(counts, prototypes)
            )
        return self._known[path]

    def _counts(self, prim: Usd.Prim) -> list[int]:
        """How often each prototype is there, at the time at which it is there most often."""
        attribute = UsdGeom.PointInstancer(prim).GetProtoIndicesAttr()
        codes = [self.source.first, *attribute.GetTimeSamples()] if attribute else []
        most: np.ndarray = np.zeros(0, np.int64)
        for code in codes:
            numbers = np.array(attribute.Get(code) or [], np.int64)
            here = np.bincount(numbers[numbers >= 0])
            size = max(len(most), len(here))
            most = np.maximum(np.pad(most, (0, size - len(most))), np.pad(here, (0, size - len(here))))
        return most.tolist()

    def _below(self, prototype: Usd.Prim | None, depth: int) -> int:
        """What the instancers ask for that are in a prototype."""
        if not prototype:
            return 0
        found, prims = (
            0,
            iter(Usd.PrimRange(prototype, Usd.TraverseInstanceProxies(Usd.PrimIsActive & Usd.PrimIsLoaded))),
        )
        for prim in prims:
            if prim.IsA(UsdGeom.PointInstancer):
                found += self._instances(prim, depth + 1)
                prims.PruneChildren()
        return found
