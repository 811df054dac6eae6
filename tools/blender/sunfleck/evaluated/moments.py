"""The moments that a render looks at: every frame, and while the shutter is open several for each.

In go Blender's settings, out come times in frames. Invariant: moments of a frame lie within half a frame of the middle of its
shutter's opening, where switches of visibility are put halfway between two frames' shutters.
"""

import math
from dataclasses import dataclass

# Straight lines between so many moments of a shutter are what things do while it is open; Cycles takes three unless told otherwise.
MOMENTS_OF_A_SHUTTER = 5
# Longer shutters overlap with those of the next frames.
OFFSETS = {"START": 0.0, "CENTER": -0.5, "END": -1.0}


@dataclass(frozen=True)
class Shutter:
    """Both in frames; the opening counts from the frame."""

    length: float
    opening: float

    @classmethod
    def of(cls, scene):
        render = scene.render
        if not render.use_motion_blur or render.motion_blur_shutter <= 0.0:
            return cls(0.0, 0.0)
        length = render.motion_blur_shutter
        return cls(length, OFFSETS[render.motion_blur_position] * length)

    def moments(self):
        """From the frame; 0 among them."""
        if self.length == 0.0:
            return [0.0]
        step = self.length / (MOMENTS_OF_A_SHUTTER - 1)
        return sorted({0.0, *(round(self.opening + step * index, 9) for index in range(MOMENTS_OF_A_SHUTTER))})

    @property
    def switch(self):
        """Where, from a frame, what is seen from this frame on begins to be: between the shutters."""
        return self.opening + 0.5 * (self.length - 1.0)


@dataclass(frozen=True)
class Clock:
    """Times of the file from frames. Files have no times before 0: `first` is the frame at 0, 0 unless some are negative."""

    seconds_a_frame: float
    first: int

    @classmethod
    def of(cls, scene):
        shutter = Shutter.of(scene)
        earliest = scene.frame_start + min(shutter.moments()[0], shutter.switch)
        return cls(seconds_a_frame(scene.render), math.floor(earliest) if earliest < 0.0 else 0)

    def seconds(self, frames):
        return (frames - self.first) * self.seconds_a_frame


def seconds_a_frame(render):
    """Blender has 1.001 in single precision, and means it."""
    base = render.fps_base
    return (1.001 if abs(base - 1.001) < 1e-6 else base) / render.fps


def frames(scene):
    """All of them, whatever the step: simulations want every one."""
    return range(scene.frame_start, scene.frame_end + 1)
