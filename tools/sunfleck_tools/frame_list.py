"""Lists of frames as `sunfleck render --frames` takes them, such as `1-48x2,60`."""

import re
from collections.abc import Iterable

ITEM = re.compile(r"(-?\d+)(?:(?:-|\.\.)(-?\d+)(?:[x:](\d+))?)?")
MOST_FRAMES = 10_000_000


def parse_frames(text: str) -> list[int]:
    """Frames of a list, each once, in the order of first mention; raises `ValueError` with the fault."""
    frames: dict[int, None] = {}
    for item in text.split(","):
        match = ITEM.fullmatch(item.strip())
        if match is None:
            raise ValueError(f"`{item}` is no item of a list of frames: write for instance 7, 1-48 or 1-48x2")
        first = int(match[1])
        last = first if match[2] is None else int(match[2])
        step = 1 if match[3] is None else int(match[3])
        if last < first or step < 1 or last - first >= MOST_FRAMES:
            raise ValueError(f"`{item}` runs backwards, has a step of 0 or more than {MOST_FRAMES} frames")
        frames.update(dict.fromkeys(range(first, last + 1, step)))
    return list(frames)


def format_frames(frames: Iterable[int]) -> str:
    """Shortest list of ranges that `parse_frames` reads back as these frames, ascending."""
    parts: list[str] = []
    run: list[int] = []
    for frame in [*sorted(set(frames)), None]:
        if run and frame == run[-1] + 1:
            run.append(frame)
            continue
        if run:
            parts.append(str(run[0]) if len(run) == 1 else f"{run[0]}-{run[-1]}")
        run = [] if frame is None else [frame]
    return ",".join(parts)
