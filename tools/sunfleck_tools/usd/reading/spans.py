"""Spans of time in which a shape has constant faces. A mesh with changing faces becomes several, each visible
in its span.

Invariant: the spans of a shape are contiguous.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from pxr import Usd, UsdGeom

from .places import codes_of, is_carried, reach, while_carried
from .solids import sizes_of
from .source import Source

BEFORE_THE_NEXT = 1e-3
"""Distance from the next sample, in frames, at which points moved by velocities are last written."""


@dataclass(frozen=True)
class Span:
    """Codes of its points (one if they are constant), the code of constant values, and its start and end.

    `points_at` gives points moved by velocities; None for those with samples.
    """

    codes: np.ndarray
    rests_at: float
    start: float = -math.inf
    end: float = math.inf
    points_at: Callable[[float], np.ndarray] | None = None

    @property
    def is_always(self) -> bool:
        """True if it is the only span."""
        return math.isinf(self.start) and math.isinf(self.end)


def read_spans(prim: Usd.Prim, source: Source) -> list[Span]:
    """Spans of a shape within the shutters' reach."""
    if not prim.IsA(UsdGeom.Mesh):
        return [Span(codes_of(sizes_of(prim), source.codes), source.first)]
    attributes = [prim.GetAttribute(name) for name in ("points", "faceVertexCounts", "faceVertexIndices")]
    if not any(attribute.ValueMightBeTimeVarying() for attribute in attributes):
        if is_carried(prim):
            codes = while_carried(source.codes[:1], source.codes)
            return [Span(codes, source.first, points_at=_carried(UsdGeom.Mesh(prim)))]
        return [Span(source.codes[:1], source.first)]
    codes = codes_of(attributes[:1], source.codes)
    starts = _changes(attributes, source)
    if len(starts) == 1:
        return [Span(codes, source.first)]
    return [_span(UsdGeom.Mesh(prim), codes, start, end, source) for start, end in zip(starts, [*starts[1:], math.inf])]


def _changes(attributes: list[Usd.Attribute], source: Source) -> list[float]:
    """Times at which faces, or the number of points, change; the first have always existed."""
    first, last = reach(source.codes)
    samples = {code for attribute in attributes for code in attribute.GetTimeSamples()}
    points, *faces = attributes
    varying = [attribute for attribute in faces if attribute.ValueMightBeTimeVarying()]
    starts: list[float] = []
    before: tuple[object, ...] | None = None
    for code in sorted({first, *(code for code in samples if first < code <= last)}):
        here = (
            len(points.Get(code) or ()),
            *(np.array(attribute.Get(code)).tobytes() for attribute in varying),
        )
        if here != before:
            starts.append(code if starts else -math.inf)
        before = here
    return starts


def _span(mesh: UsdGeom.Mesh, codes: np.ndarray, start: float, end: float, source: Source) -> Span:
    first, _ = reach(source.codes)
    inside = codes[(codes >= start) & (codes < end)]
    rests_at = max(start, first)
    if not mesh.GetVelocitiesAttr().HasAuthoredValue():
        return Span(np.union1d(inside, [rests_at]), rests_at, start, end)
    frame = codes[1] - codes[0] if len(codes) > 1 else 1.0
    last = min(end, codes[-1] + frame) - BEFORE_THE_NEXT * frame
    return Span(np.union1d(inside, [rests_at, last]), rests_at, start, end, _carried(mesh))


def _carried(mesh: UsdGeom.Mesh) -> Callable[[float], np.ndarray]:
    """Function of a code that gives points moved by their velocities."""

    def points_at(code: float) -> np.ndarray:
        time = Usd.TimeCode(code)
        return np.array(mesh.ComputePointsAtTime(time, time), float).reshape(-1, 3)

    return points_at
