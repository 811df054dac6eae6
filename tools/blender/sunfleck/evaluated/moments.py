"""Moments of a render: every frame, and those within the open shutter at which Cycles has its things.

In go Blender's settings, out come times in frames. Invariant: switches of visibility lie halfway between
two frames' shutters.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import bpy

from ..film import of_cycles

# Cycles' maximum of halvings of a shutter.
MOST_STEPS = 7
# Longer shutters overlap with those of other frames.
OFFSETS = {"START": 0.0, "CENTER": -0.5, "END": -1.0}


@dataclass(frozen=True)
class Shutter:
    """Opening and length in frames, relative to the frame."""

    length: float
    opening: float
    # Whether no other frame's moments may lie in it.
    is_alone: bool = False

    @classmethod
    def of(cls, scene: bpy.types.Scene, is_alone: bool = False) -> "Shutter":
        render = scene.render
        if not render.use_motion_blur or render.motion_blur_shutter <= 0.0:
            return cls(0.0, 0.0)
        length = render.motion_blur_shutter
        return cls(length, OFFSETS[render.motion_blur_position] * length, is_alone or length < 1.0)

    def moments(self, steps: int) -> list[float]:
        """Offsets from the frame: the frame itself, then the ends of the pieces of so many halvings."""
        if self.length == 0.0:
            return [0.0]
        pieces = 1 << max(1, steps)
        found = (round(self.opening + self.length * at / pieces, 9) for at in range(pieces + 1))
        return [0.0, *(moment for moment in found if moment != 0.0)]

    @property
    def ends(self) -> tuple[float, float]:
        """Offsets of its opening and closing, as those of its moments."""
        return round(self.opening, 9), round(self.opening + self.length, 9)

    def is_step(self, offset: float, steps: int) -> bool:
        """Whether a thing of so many halvings has that moment; the frame and what is outside of the shutter all have."""
        if self.length == 0.0 or offset == 0.0:
            return True
        at = (offset - self.opening) / self.length
        return not 0.0 <= at <= 1.0 or abs(math.remainder(at * (1 << steps), 1.0)) < 1e-6

    def holds(self, offset: float, steps: int) -> bool:
        """Whether a thing is there as at the frame: Cycles leaves those without steps as in the shutter's middle."""
        return steps == 0 and offset != 0.0 and self.can_hold and abs(offset) <= 0.5 * self.length

    @property
    def is_centred(self) -> bool:
        return abs(self.opening + 0.5 * self.length) < 1e-6

    @property
    def can_hold(self) -> bool:
        return self.is_centred and (self.is_alone or self.length == 0.0)

    @property
    def switch(self) -> float:
        """Offset from a frame at which visibility switches to it: between the shutters."""
        return self.opening + 0.5 * (self.length - 1.0)


def steps_of(*things: bpy.types.Object | None) -> int:
    """Cycles' halvings of the shutter for an object and its instancer; lights and what is not to be blurred have
    none."""
    found = [thing for thing in things if thing is not None]
    if found[0].type == "LIGHT" or not all(of_cycles(thing, "use_motion_blur", True) for thing in found):
        return 0
    steps: int = max(of_cycles(thing, "motion_steps", 1) for thing in found)
    return min(MOST_STEPS, steps)


@dataclass(frozen=True)
class Clock:
    """Times of the file. Files have no negative times: `first` is the frame at 0, and is 0 unless some
    moments are negative."""

    seconds_a_frame: float
    first: int

    @classmethod
    def of(cls, scene: bpy.types.Scene, frames: Sequence[int]) -> "Clock":
        shutter = Shutter.of(scene)
        earliest = frames[0] + min(shutter.opening, shutter.switch)
        return cls(seconds_a_frame(scene.render), math.floor(earliest) if earliest < 0.0 else 0)

    def seconds(self, frames: Any) -> Any:
        """Seconds of a frame, or of an array of them."""
        return (frames - self.first) * self.seconds_a_frame


def seconds_a_frame(render: bpy.types.RenderSettings) -> float:
    """Blender stores 1.001 in single precision; it means the fraction."""
    base: float = render.fps_base
    return (1.001 if abs(base - 1.001) < 1e-6 else base) / float(render.fps)


def frames(scene: bpy.types.Scene, only: int | None = None) -> range:
    """All frames, whatever the step, as simulations need each; or one alone."""
    return range(scene.frame_start, scene.frame_end + 1) if only is None else range(only, only + 1)
