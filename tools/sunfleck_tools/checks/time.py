"""Checks of frames against their neighbours in time."""

from collections.abc import Iterator
from statistics import median

from ..findings import Found, Severity, check
from ..summary import FrameSummary, Rendered

NEIGHBOURS = 5
"""Frames to either side in a median."""
SIZE_RATIO = 2.0
"""Maximum ratio of a file's size to the median."""
POP_RATIO = {"mean": 0.15, "p99": 0.5}
"""Minimum relative step of a pop, in one frame; the brightest hundredth may be a single turning leaf."""
POP_DEVIATIONS = 6.0
"""Minimum step relative to the usual one."""
REST_FRAMES = 3
"""Number of equal frames at the beginning or end that count as a rest; fewer are an error."""
FADED_RATIO = 0.1
"""Share of the usual mean at which the last frame of a slow fade may be."""
FADE_STEPS = 2.0
"""Maximum distance from black of the last frame of a quick fade, in steps like the previous one."""
FLICKER_FRAMES = 8
"""Consecutive alternating steps that are not chance: 2^-7."""
FLICKER_RATIO = 0.02
"""Median relative step of such a run."""


@check("black", Severity.ERROR, "a frame is black, and those around it are not", rerender=True)
def black(rendered: Rendered) -> Iterator[Found]:
    """A lost light or camera, but not a fade, an exit from the picture, or black at the beginning or end."""
    frames = rendered.decoded
    lit = [frame.mean for frame in frames if frame.mean is not None and not _is_black(frame)]
    for start, end in _black_runs(frames):
        # Two frames before and two after, the nearer first.
        sides = [side for side in (frames[max(start - 2, 0) : start][::-1], frames[end : end + 2]) if side]
        rests = len(sides) == 1 and end - start >= REST_FRAMES
        steps = [side[0] for side in sides if not _fades(side, median(lit))]
        if steps and not rests:
            for frame in frames[start:end]:
                yield frame.found(
                    f"every pixel is black, where frame {steps[0].number} has a mean of {steps[0].mean:.4g}"
                )


@check("all-black", Severity.WARNING, "no frame shows anything")
def all_black(rendered: Rendered) -> Iterator[Found]:
    """A scene without light, or a camera that misses it: rendered correctly, but hardly intended."""
    if rendered.decoded and all(map(_is_black, rendered.decoded)):
        yield Found("every pixel of every frame is black: is there a light, and is the camera right?")


def _is_black(frame: FrameSummary) -> bool:
    return frame.largest == 0 and frame.smallest == 0


def _fades(side: list[FrameSummary], usual: float) -> bool:
    """True if black is a gradual change from a frame and its predecessor. The frame is dark, or so much
    darker than the other that black may follow, or less than a hundredth of its pixels are lit, as when
    small objects leave."""
    near = side[0]
    if near.mean is None or near.p99 == 0 or near.mean <= FADED_RATIO * usual:
        return True
    return len(side) > 1 and side[1].mean is not None and near.mean <= FADE_STEPS * (side[1].mean - near.mean)


def _black_runs(frames: list[FrameSummary]) -> Iterator[tuple[int, int]]:
    """First index, and the one after the last."""
    start = None
    for index, frame in enumerate([*frames, None]):
        if frame is not None and _is_black(frame):
            start = index if start is None else start
        elif start is not None:
            yield start, index
            start = None


@check("constant", Severity.WARNING, "a frame has a single colour")
def constant(rendered: Rendered) -> Iterator[Found]:
    """A camera inside a wall, or fog alone."""
    for frame in rendered.decoded:
        if frame.constant and frame.largest != 0:
            yield frame.found("all pixels have one colour")


@check("stuck", Severity.ERROR, "a frame has the pixels of the one before, where --static does not allow it")
def stuck(rendered: Rendered) -> Iterator[Found]:
    """One finding a run of equal frames. A sequence may rest at its beginning and end; black frames are
    all alike."""
    if rendered.options.static:
        return
    frames = rendered.decoded
    start = 0
    for end in range(1, len(frames) + 1):
        if end < len(frames) and frames[end].hash == frames[start].hash:
            continue
        run = frames[start:end]
        rests = (start == 0 or end == len(frames)) and REST_FRAMES <= len(run) < len(frames)
        if len(run) > 1 and not rests and not _is_black(run[0]):
            until = f", and so do all until frame {run[-1].number}" if len(run) > 2 else ""
            meant = "" if len(run) < len(frames) else "; if nothing moves, say so by --static"
            yield run[1].found(f"it has the pixels of frame {run[0].number}{until}{meant}")
        start = end


@check("file-size", Severity.WARNING, "a file is much smaller or larger than its neighbours")
def file_size(rendered: Rendered) -> Iterator[Found]:
    """Partial and empty pictures compress well."""
    # Black frames are reported by `black`.
    for frame, around in _surrounded([frame for frame in rendered.frames if not _is_black(frame)]):
        usual = median(other.bytes for other in around)
        if frame.bytes * SIZE_RATIO < usual or frame.bytes > usual * SIZE_RATIO:
            yield frame.found(f"the file has {frame.bytes} bytes where its neighbours have about {usual:.0f}")


@check("pop", Severity.WARNING, "a frame alone is brighter or darker than both neighbours")
def pop(rendered: Rendered) -> Iterator[Found]:
    """Second difference of mean and 99th percentile, relative to the usual one nearby."""
    frames = [frame for frame in rendered.decoded if frame.mean is not None]
    for name, label in (("mean", "mean"), ("p99", "99th percentile")):
        values = [getattr(frame, name) for frame in frames]
        bends = [_bend(values, i) if 0 < i < len(values) - 1 else 0.0 for i in range(len(values))]
        for i, frame in enumerate(frames):
            around = [abs(bends[j]) for j in _around(i, len(frames), NEIGHBOURS) if abs(j - i) > 1]
            level = max(
                values[i], median(values[j] for j in _around(i, len(frames), 2)) if len(frames) > 1 else 0.0
            )
            if len(around) >= 3 and abs(bends[i]) > max(
                POP_RATIO[name] * level, POP_DEVIATIONS * median(around)
            ):
                message = f"{label} {values[i]:.4g} between {values[i - 1]:.4g} and {values[i + 1]:.4g}"
                yield frame.found(f"it pops: {message}")


@check("flicker", Severity.WARNING, "brightness goes up and down from frame to frame")
def flicker(rendered: Rendered) -> Iterator[Found]:
    """Runs of steps whose signs alternate."""
    frames = [frame for frame in rendered.decoded if frame.mean is not None]
    means = [frame.mean for frame in rendered.decoded if frame.mean is not None]
    steps = [after - before for before, after in zip(means, means[1:])]
    start = 0
    for i in range(1, len(steps) + 1):
        if i < len(steps) and steps[i] * steps[i - 1] < 0:
            continue
        run = steps[start:i]
        level = median(means[start : i + 1])
        if len(run) >= FLICKER_FRAMES and median(map(abs, run)) > FLICKER_RATIO * level:
            first, last = frames[start], frames[i]
            share = 100 * median(map(abs, run)) / level if level else 0.0
            yield first.found(f"its mean goes up and down by {share:.1f} % until frame {last.number}")
        start = i


def _bend(values: list[float], i: int) -> float:
    """Distance of a value from the range of its neighbours: 0 in steps and ramps, large in a pop."""
    low, high = sorted((values[i - 1], values[i + 1]))
    return min(values[i] - low, 0.0) + max(values[i] - high, 0.0)


def _around(i: int, count: int, reach: int) -> list[int]:
    return [j for j in range(max(0, i - reach), min(count, i + reach + 1)) if j != i]


def _surrounded(frames: list[FrameSummary]) -> Iterator[tuple[FrameSummary, list[FrameSummary]]]:
    for i, frame in enumerate(frames):
        around = [frames[j] for j in _around(i, len(frames), NEIGHBOURS)]
        if len(around) >= 3:
            yield frame, around
