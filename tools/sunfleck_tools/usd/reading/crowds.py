"""PointInstancers: a node for each instance. Invariant: nothing is an instance of itself."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from pxr import Usd, UsdGeom

from ...errors import SceneError
from .nodes import Nodes
from .places import parts, steady
from .properties import SPACE
from .source import Source

DEEPEST = 64
"""Instancers within instancers."""


@dataclass(frozen=True)
class Crowd:
    """The instances of an instancer: for each one of `prototypes`, for each code and instance translation, turn and scale."""

    path: str
    prototypes: list[Usd.Prim]
    numbers: list[int]
    codes: np.ndarray
    placed: np.ndarray
    names: list[str]
    ids: list[int] | None
    mask: list[bool]


def read_crowd(prim: Usd.Prim, source: Source) -> Crowd:
    """All of an instancer."""
    instancer, path, code = UsdGeom.PointInstancer(prim), prim.GetPath(), Usd.TimeCode(source.first)
    targets = instancer.GetPrototypesRel().GetForwardedTargets()
    prototypes = [prim.GetStage().GetPrimAtPath(target) for target in targets]
    missing = [str(target) for target, found in zip(targets, prototypes) if not found]
    if missing:
        raise SceneError(f"{path}: there is no prototype {', '.join(missing)}")
    if any(path.HasPrefix(target) for target in targets):
        raise SceneError(f"{path}: is an instance of itself")
    numbers = np.array(instancer.GetProtoIndicesAttr().Get(code) or [], np.int64)
    if len(numbers) and (numbers.min() < 0 or numbers.max() >= len(prototypes)):
        raise SceneError(f"{path}: protoIndices go from {numbers.min()} to {numbers.max()}, of {len(prototypes)} prototypes")
    attributes = [prim.GetAttribute(name) for name in ("positions", "orientations", "orientationsf", "scales")]
    moves = any(attribute and attribute.ValueMightBeTimeVarying() for attribute in attributes)
    codes = source.codes if moves else source.codes[:1]
    placed = np.stack([_places(instancer, each, len(numbers)) for each in codes.tolist()])
    names = list(prim.GetAttribute(f"{SPACE}sunfleck_names").Get() or [])
    if len(names) != len(numbers):
        names = [f"{prim.GetName()}.{index}" for index in range(len(numbers))]
    ids = [int(each) for each in instancer.GetIdsAttr().Get(code) or []]
    mask = list(instancer.ComputeMaskAtTime(code)) or [True] * len(numbers)
    return Crowd(str(path), prototypes, numbers.tolist(), codes, placed, names, ids if len(ids) == len(numbers) else None, mask)


def _places(instancer: UsdGeom.PointInstancer, code: float, count: int) -> np.ndarray:
    """Ten numbers for each instance."""
    time, kind = Usd.TimeCode(code), UsdGeom.PointInstancer
    found = instancer.ComputeInstanceTransformsAtTime(time, time, kind.ExcludeProtoXform, kind.IgnoreMask)
    matrices = np.array(found, float).reshape(-1, 4, 4).transpose(0, 2, 1)
    if len(matrices) != count:
        raise SceneError(f"{instancer.GetPath()}: has {count} protoIndices and {len(matrices)} places at time code {code:g}")
    if count == 0:
        return np.zeros((0, 10), np.float32)
    return np.concatenate(parts(matrices)[:3], axis=1).astype(np.float32)


def place_crowd(crowd: Crowd, nodes: Nodes, node: int, depth: int, fill: Callable[[Usd.Prim, int], None]) -> None:
    """Adds a node for each instance below a node; `fill` puts a prototype there."""
    if depth >= DEEPEST:
        raise SceneError(f"{crowd.path}: instancers within instancers, {DEEPEST} deep: do they come round?")
    for index, number in enumerate(crowd.numbers):
        if not crowd.mask[index]:
            continue
        instance = nodes.add(crowd.names[index].partition("#")[0], node)
        place = crowd.placed[:, index]
        nodes.move(instance, crowd.codes, place[:, :3], steady(place[:, 3:7]), place[:, 7:])
        if crowd.ids is not None and 0 <= crowd.ids[index] < 2**31:
            nodes.extra(instance, "leaf_id", crowd.ids[index])
        fill(crowd.prototypes[number], instance)
