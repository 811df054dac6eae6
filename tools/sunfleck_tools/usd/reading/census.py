"""Number of instances in a stage, before any is created. In go instancers, out come counts, multiplied for
nested ones.

Invariant: instances of nested instancers are counted once for each instance of the outer ones, at any
depth.
"""

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from .losses import TooMuch
from .source import Source

MOST_INSTANCES = 1_000_000
"""Maximum instances of a stage, as for leaves of a scene. They take half a minute, and up to 2 gigabytes."""
DEEPEST = 64
"""Maximum depth of nested instancers."""


class Census:
    """Counts the instances of a stage, one instancer after the other."""

    def __init__(self, source: Source):
        self.source = source
        self._found = 0
        self._known: dict[Sdf.Path, int] = {}

    def add(self, prim: Usd.Prim) -> None:
        """Adds a top-level instancer with all nested ones. Raises `TooMuch`."""
        self._found += self._instances(prim, 0)
        if self._found > MOST_INSTANCES:
            raise TooMuch(
                f"{prim.GetPath()}: with it there are {self._found} instances, those within others "
                "multiplied; "
                f"a file holds {MOST_INSTANCES}: make it smaller or inactive, or read parts of the stage by "
                "--mask"
            )

    def _instances(self, prim: Usd.Prim, depth: int) -> int:
        """Instances of an instancer: each counts as one, plus those in its prototype."""
        if depth >= DEEPEST:
            raise TooMuch(
                f"{prim.GetPath()}: instancers within instancers, {DEEPEST} deep: do they come round?"
            )
        path = prim.GetPath()
        if path not in self._known:
            counts = self._counts(prim)
            targets = UsdGeom.PointInstancer(prim).GetPrototypesRel().GetForwardedTargets()[: len(counts)]
            # A self-instancing prototype is dropped when it is read.
            prototypes = [
                None if path.HasPrefix(target) else prim.GetStage().GetPrimAtPath(target)
                for target in targets
            ]
            self._known[path] = sum(
                count * (1 + self._below(each, depth)) for count, each in zip(counts, prototypes)
            )
        return self._known[path]

    def _counts(self, prim: Usd.Prim) -> list[int]:
        """Maximum number of each prototype's instances at any time."""
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
        """Instances of the instancers in a prototype."""
        if not prototype:
            return 0
        found = 0
        prims = iter(Usd.PrimRange(prototype, Usd.TraverseInstanceProxies(Usd.PrimIsActive & Usd.PrimIsLoaded)))
        for prim in prims:
            if prim.IsA(UsdGeom.PointInstancer):
                found += self._instances(prim, depth + 1)
                prims.PruneChildren()
        return found
