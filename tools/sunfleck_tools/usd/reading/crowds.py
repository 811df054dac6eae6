"""PointInstancers: a node for each instance. Invariant: nothing is an instance of itself.

Instances are identified by their ids, or else by their indices. One that appears, disappears or is masked
becomes a node with animated visibility; one that changes its prototype becomes another node.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from pxr import Usd, UsdGeom

from ...errors import SceneError
from .crowd_colors import NAMES, instance_colors, say_other_primvars
from .losses import Losses, TooMuch
from .nodes import Nodes
from .places import codes_of, is_carried, parts, steady, while_carried
from .properties import SPACE
from .source import Source

MOST_MOMENTS = 10_000_000
"""Maximum instances of an instancer times codes: 160 bytes each during sorting."""


@dataclass(frozen=True)
class Member:
    """Instance: its prototype, its translation, rotation and scale at each code (ten numbers), and changes
    of its visibility."""

    name: str
    leaf_id: int | None
    prototype: Usd.Prim
    codes: np.ndarray
    placed: np.ndarray
    shown_codes: np.ndarray
    shown: np.ndarray
    color: tuple[float, ...] | None = None
    """Colour of the instance, RGB and opacity."""


def read_crowd(prim: Usd.Prim, source: Source, lost: Losses) -> list[Member]:
    """Instances of an instancer that are visible at any time. Raises `SceneError`."""
    return _Reader(prim, source, lost).members()


class _Reader:
    def __init__(self, prim: Usd.Prim, source: Source, lost: Losses):
        self.prim, self.source, self.lost = prim, source, lost
        self.instancer = UsdGeom.PointInstancer(prim)
        self.prototypes = self._prototypes()
        names = ("protoIndices", "ids", "invisibleIds", "positions", "orientations", "orientationsf", "scales",
                 "velocities", "accelerations", "angularVelocities")  # fmt: skip
        found = (UsdGeom.PrimvarsAPI(prim).GetPrimvar(name) for name, _ in NAMES)
        self.colored = [primvar for primvar in found if primvar and primvar.HasValue()]
        self._colors: dict[int, np.ndarray | None] = {}
        say_other_primvars(prim, lost)
        self.codes = codes_of([prim.GetAttribute(name) for name in names if prim.GetAttribute(name)], source.codes)
        if is_carried(prim):
            self.codes = while_carried(self.codes, source.codes)
        ids = self.instancer.GetIdsAttr()
        self.mixes = not self.instancer.GetVelocitiesAttr().HasAuthoredValue() and ids.ValueMightBeTimeVarying()

    def _prototypes(self) -> list[Usd.Prim]:
        path, stage = self.prim.GetPath(), self.prim.GetStage()
        targets = self.instancer.GetPrototypesRel().GetForwardedTargets()
        prototypes = [stage.GetPrimAtPath(target) for target in targets]
        missing = [str(target) for target, found in zip(targets, prototypes) if not found]
        if missing and not any(prototypes):
            raise SceneError(f"{path}: there is no prototype {', '.join(missing)}")
        for target in missing:
            self.lost.add("usd-missing", path, f"there is no prototype {target}; its instances are left out")
        if any(path.HasPrefix(target) for target in targets):
            raise SceneError(f"{path}: is an instance of itself")
        return prototypes

    def members(self) -> list[Member]:
        """One for each id and prototype."""
        here = len(self.instancer.GetProtoIndicesAttr().Get(self.source.first) or ())
        if here * len(self.codes) > MOST_MOMENTS:
            raise TooMuch(
                f"{self.prim.GetPath()}: {here} instances that change at {len(self.codes)} times are more "
                "than "
                f"{MOST_MOMENTS} places: read fewer frames by --frames"
            )
        moments = [self._moment(code) for code in self.codes.tolist()]
        if not any(len(each) for each, *_ in moments) and (
            problems := [what for *_, what in moments if what]
        ):
            raise SceneError(f"{self.prim.GetPath()}: {problems[0]}")
        for code, (*_, what) in zip(self.codes.tolist(), moments):
            if what:
                said = f"{what} at time code {code:g}; nothing is seen then"
                self.lost.add("usd-instances", self.prim, said)
        # A row for each instance at each code: id, prototype, index of the code, index in the arrays.
        each = [
            (keys, numbers, np.full(len(keys), at), np.arange(len(keys)))
            for at, (keys, numbers, *_) in enumerate(moments)
        ]
        rows = np.concatenate([np.column_stack(columns) for columns in each])
        placed = np.concatenate([placed for _, _, placed, _, _ in moments])
        shown = np.concatenate([shown for _, _, _, shown, _ in moments])
        order = np.lexsort((rows[:, 2], rows[:, 1], rows[:, 0]))
        rows, placed, shown = rows[order], placed[order], shown[order]
        starts = np.nonzero(np.diff(rows[:, :2], axis=0, prepend=rows[:1, :2] - 1).any(axis=1))[0]
        slices = [slice(first, last) for first, last in zip(starts, [*starts[1:], len(rows)])]
        there = [part for part in slices if shown[part].any() and self.prototypes[rows[part][0, 1]]]
        found = [self._member(rows[part], placed[part], shown[part]) for part in there]
        # By the time of appearance, then by the index in the arrays.
        return [member for _, member in sorted(found, key=lambda each: each[0])]

    def _member(
        self, rows: np.ndarray, placed: np.ndarray, shown: np.ndarray
    ) -> tuple[tuple[int, int], Member]:
        key, number, at, place = rows[0].tolist()
        is_seen = np.zeros(len(self.codes), bool)
        is_seen[rows[:, 2]] = shown
        # Before the range an instance is as at its first frame.
        turns = np.concatenate([[True], is_seen[1:] != is_seen[:-1]])
        names = self._names()
        name = names[place] if place < len(names) and not self._changes() else f"{self.prim.GetName()}.{key}"
        leaf_id = key if self._has_ids() and 0 <= key < 2**31 else None
        codes, color, seen = self.codes[rows[:, 2]], self._color(rows), (self.codes[turns], is_seen[turns])
        member = Member(name, leaf_id, self.prototypes[number], codes, placed, *seen, color)
        return (at, place), member

    def _color(self, rows: np.ndarray) -> tuple[float, ...] | None:
        """Colour of an instance, from its indices at the codes at which it exists."""
        found = [
            tuple(np.round(colors[place], 6).tolist())
            for at, place in rows[:, 2:].tolist()
            if (colors := self._colors_at(at)) is not None
        ]
        # NaN, for no colour, equals nothing.
        if any(not np.array_equal(each, found[0], equal_nan=True) for each in found):
            what = "colours of its instances change over time; each keeps that with which it comes"
            self.lost.add("usd-material-animated", self.prim, what)
        return found[0] if found else None

    def _colors_at(self, at: int) -> np.ndarray | None:
        if not self.colored:
            return None
        key = at if any(primvar.ValueMightBeTimeVarying() for primvar in self.colored) else -1
        if key not in self._colors:
            count = len(self.instancer.GetProtoIndicesAttr().Get(float(self.codes[at])) or ())
            self._colors[key] = instance_colors(self.prim, float(self.codes[at]), count, self.lost)
        return self._colors[key]

    def _changes(self) -> bool:
        attributes = (self.instancer.GetProtoIndicesAttr(), self.instancer.GetIdsAttr())
        return any(each.ValueMightBeTimeVarying() for each in attributes)

    def _has_ids(self) -> bool:
        return self.instancer.GetIdsAttr().HasAuthoredValue()

    def _names(self) -> list[str]:
        return list(self.prim.GetAttribute(f"{SPACE}sunfleck_names").Get() or [])

    def _moment(self, code: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, str]:
        """Key, prototype, transform and visibility of each instance at a code, or the fault."""
        time = Usd.TimeCode(code)
        numbers = np.array(self.instancer.GetProtoIndicesAttr().Get(time) or [], np.int64)
        if len(numbers) and (numbers.min() < 0 or numbers.max() >= len(self.prototypes)):
            return (
                *_nobody(),
                f"protoIndices go from {numbers.min()} to {numbers.max()}, of {len(self.prototypes)} "
                "prototypes",
            )
        placed = self._places(code)
        if len(placed) != len(numbers):
            return (
                *_nobody(),
                f"has {len(numbers)} protoIndices, which its positions, orientations or scales do not fit",
            )
        if not np.isfinite(placed).all():
            return *_nobody(), "its places are not all finite"
        ids = np.array(self.instancer.GetIdsAttr().Get(time) or [], np.int64)
        keys = (
            ids if len(ids) == len(numbers) and len(np.unique(ids)) == len(ids) else np.arange(len(numbers))
        )
        mask = np.array(list(self.instancer.ComputeMaskAtTime(time)), bool)
        return keys, numbers, placed, mask if len(mask) == len(numbers) else np.ones(len(numbers), bool), ""

    def _places(self, code: float) -> np.ndarray:
        """Ten numbers for each instance."""
        time, kind = Usd.TimeCode(self._unmixed(code)), UsdGeom.PointInstancer
        found = self.instancer.ComputeInstanceTransformsAtTime(
            time, time, kind.ExcludeProtoXform, kind.IgnoreMask
        )
        matrices = np.array(found, float).reshape(-1, 4, 4).transpose(0, 2, 1)
        if not len(matrices):
            return np.zeros((0, 10), np.float32)
        return np.concatenate(parts(matrices)[:3], axis=1).astype(np.float32)

    def _unmixed(self, code: float) -> float:
        """The code, or that of the sample before it if the next sample has other instances: USD would
        interpolate between unrelated ones."""
        attribute = self.instancer.GetIdsAttr()
        if not self.mixes:
            return code
        before, after = attribute.GetBracketingTimeSamples(code) or (code, code)
        if before < code < after and list(attribute.Get(before)) != list(attribute.Get(after)):
            return before
        return code


def _nobody() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    return np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros((0, 10), np.float32), np.zeros(0, bool)


def place_crowd(
    members: list[Member], nodes: Nodes, node: int, fill: Callable[[Member, int], None]
) -> None:
    """Adds a node for each instance below a node; `fill` adds the prototype."""
    for member in members:
        instance = nodes.add(member.name.partition("#")[0], node)
        nodes.move(
            instance, member.codes, member.placed[:, :3], steady(member.placed[:, 3:7]), member.placed[:, 7:]
        )
        nodes.show(instance, member.shown_codes, member.shown)
        if member.leaf_id is not None:
            nodes.extra(instance, "leaf_id", member.leaf_id)
        fill(member, instance)
