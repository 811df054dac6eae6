"""Moments of a render: every frame, and as many within the open shutter as motion needs.

In go Blender's settings, out come times in frames. Invariant: switches of visibility lie halfway between
two frames' shutters.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import bpy

# Maximum number of halvings: 33 moments.
MOST_HALVINGS = 4
# Longer shutters overlap with those of other frames.
OFFSETS = {"START": 0.0, "CENTER": -0.5, "END": -1.0}


@dataclass(frozen=True)
class Shutter:
    """Opening and length in frames, relative to the frame."""

    length: float
    opening: float

    @classmethod
    def of(cls, scene: bpy.types.Scene) -> "Shutter":
        render = scene.render
        if not render.use_motion_blur or render.motion_blur_shutter <= 0.0:
            return cls(0.0, 0.0)
        length = render.motion_blur_shutter
        return cls(length, OFFSETS[render.motion_blur_position] * length)

    def rounds(self) -> Iterator[list[float]]:
        """Offsets from the frame: the frame itself, the ends and the middle, then rounds of midpoints."""
        yield [0.0]
        if self.length == 0.0:
            return
        known, share = {0.0}, [0.0, 0.5, 1.0]
        for halvings in range(MOST_HALVINGS + 1):
            found = [
                moment
                for moment in (round(self.opening + self.length * at, 9) for at in share)
                if moment not in known
            ]
            known.update(found)
            yield found
            pieces = 4 << halvings
            share = [at / pieces for at in range(1, pieces, 2)]

    @property
    def is_centred(self) -> bool:
        return abs(self.opening + 0.5 * self.length) < 1e-6

    @property
    def switch(self) -> float:
        """Offset from a frame at which visibility switches to it: between the shutters."""
        return self.opening + 0.5 * (self.length - 1.0)


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
