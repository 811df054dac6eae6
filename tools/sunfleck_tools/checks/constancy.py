"""Checks of values that should be the same in all frames, and of frame counters against file names."""

import re
from collections import Counter
from collections.abc import Callable, Hashable, Iterator
from fractions import Fraction
from itertools import pairwise

from ..exr.header import TimeCode
from ..findings import Found, Severity, check
from ..summary import FrameSummary, Rendered

RANGE = re.compile(r"(-?\d{1,10})-(-?\d{1,10})")
STRUCTURE = ("channels", "display window", "compression", "layout", "colour space", "pixel aspect")


def odd_ones(
    rendered: Rendered, what: str, value_of: Callable[[FrameSummary], Hashable], expected: Hashable = None
) -> Iterator[Found]:
    """Frames whose value differs from that of most frames (the earliest of equals), or from the expected
    one."""
    frames = [frame for frame in rendered.frames if frame.structure]
    values = {frame.number: value_of(frame) for frame in frames}
    if expected is None:
        if not (counts := Counter(values.values()).most_common(1)):
            return
        expected = counts[0][0]
        share = f"{counts[0][1]} of {len(frames)} frames have"
    else:
        share = "was asked for:"
    for frame in frames:
        if (value := values[frame.number]) != expected:
            yield frame.found(f"its {what} is {_shown(value)} where {share} {_shown(expected)}")


def _shown(value: object) -> str:
    if value is None:
        return "not said"
    if isinstance(value, str) and len(value) == 64:
        return f"{value[:12]}..."
    text = str(value)
    return text if len(text) <= 120 else f"{text[:117]}..."


@check("structure", Severity.ERROR, "channels, windows, compression or colour space differ from the other frames'")
def structure(rendered: Rendered) -> Iterator[Found]:
    """Readers take the structure from the first frame. Other renderers fit the data window to the
    contents."""
    is_own = any(frame.provenance for frame in rendered.frames)
    for part in STRUCTURE + (("data window",) if is_own else ()):
        yield from odd_ones(rendered, part, lambda frame: frame.structure[part])


def same(id: str, severity: Severity, what: str, key: str, about: str) -> None:
    """Registers a check of one value of the files' provenance."""

    @check(id, severity, f"frames {about}")
    def mixed(rendered: Rendered) -> Iterator[Found]:
        yield from odd_ones(rendered, what, lambda frame: frame.provenance.get(key))


# Some machines of a farm have an older version; or some frames alone were rendered again.
same("mixed-version", Severity.ERROR, "version", "version", "were rendered by different versions")
same("mixed-scene", Severity.ERROR, "scene's hash", "sceneHash", "show different states of the scene")
same("mixed-settings", Severity.ERROR, "settings' hash", "settingsHash", "were rendered with different settings")
# Harmless in a picture, but a sign of two runs.
same("mixed-seed", Severity.WARNING, "seed", "seed", "were rendered with different seeds")


@check("unsigned", Severity.WARNING, "a file carries no hash: damage may go unseen")
def unsigned(rendered: Rendered) -> Iterator[Found]:
    """One finding, unless no frame has a hash: then another program wrote them."""
    frames = [frame for frame in rendered.frames if frame.structure]
    without = [frame for frame in frames if "pixelHash" not in frame.provenance]
    if frames and len(without) == len(frames):
        yield Found("no frame carries a pixel hash: damage that decodes goes unseen")
    else:
        for frame in without:
            yield frame.found("it carries no pixel hash")
    sealed = [frame for frame in frames if "fileHash" in frame.provenance]
    if sealed:
        for frame in frames:
            if "fileHash" not in frame.provenance:
                yield frame.found("it carries no hash of the file, as the others do")


def scene_frames(frames: list[FrameSummary]) -> tuple[int, int] | None:
    """First and last frame of the scene, as frames of this renderer store them."""
    texts = {frame.provenance.get("sequenceFrames", "") for frame in frames}
    ranges = [(int(match[1]), int(match[2])) for text in texts if (match := RANGE.fullmatch(text))]
    return (min(first for first, _ in ranges), max(last for _, last in ranges)) if ranges else None


@check("ends-early", Severity.WARNING, "the scene's own frames go on before or after those that are there")
def ends_early(rendered: Rendered) -> Iterator[Found]:
    """A missing first or last frame leaves no gap. Frames store the range of their scene, whichever frames
    a run rendered. If one end exists and the other does not, it may be lost; a partial render is
    deliberate."""
    numbers = [frame.number for frame in rendered.frames]
    found = scene_frames(rendered.frames)
    if rendered.options.frames is not None or len(numbers) < 2 or found is None:
        return
    first, last = found
    step = min(after - before for before, after in pairwise(numbers))
    is_first_there, is_last_there = numbers[0] - step < first, numbers[-1] + step > last
    if is_first_there != is_last_there:
        lost = f"after {numbers[-1]}" if is_first_there else f"before {numbers[0]}"
        yield Found(
            f"the scene's frames are {first}-{last}, and none {lost} is there: say by --frames if that is "
            "right"
        )


@check("frame-rate", Severity.ERROR, "the frame rate differs from the other frames', or from --fps")
def frame_rate(rendered: Rendered) -> Iterator[Found]:
    """Editors take the frame rate from any frame."""
    yield from odd_ones(
        rendered, "frame rate", lambda frame: frame.attributes.get("framesPerSecond"), rendered.options.fps
    )


@check("image-counter", Severity.ERROR, "the file's frame number is not that of its name", rerender=True)
def image_counter(rendered: Rendered) -> Iterator[Found]:
    """Swapped, copied and renumbered frames. Other renderers' frames may be renumbered consistently."""
    if rendered.is_still:
        return
    is_own = any(frame.provenance for frame in rendered.frames)
    if not is_own:
        said = [frame for frame in rendered.frames if number_said(frame) is not None]
        ahead = "own number ahead of its name by"
        yield from odd_ones(Rendered(said, rendered.options), ahead, lambda frame: (number_said(frame) or 0) - frame.number)
    for frame in rendered.frames:
        counter = frame.attributes.get("imageCounter")
        if is_own and counter is not None and counter != frame.number:
            yield frame.found(f"the file says that it is frame {counter}")


def number_said(frame: FrameSummary) -> int | None:
    """Frame number of other renderers: OpenEXR's attribute, or Blender's text `Frame`."""
    counter, text = frame.attributes.get("imageCounter"), frame.attributes.get("Frame")
    if isinstance(counter, int):
        return counter
    return (
        int(text) if isinstance(text, str) and text.isascii() and text.isdigit() and len(text) < 10 else None
    )


@check("time-code", Severity.ERROR, "time codes do not advance as the names do")
def time_code(rendered: Rendered) -> Iterator[Found]:
    """The start is the author's choice; the majority of frames decides it."""

    def offset(frame: FrameSummary) -> int | None:
        code, rate = frame.attributes.get("timeCode"), frame.attributes.get("framesPerSecond")
        if not isinstance(code, TimeCode) or not isinstance(rate, Fraction):
            return None
        return code.frame(round(rate)) - frame.number

    yield from odd_ones(rendered, "time code ahead of its name by", offset)
