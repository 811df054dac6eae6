"""Two frames, or two sequences frame by frame, against each other.

Invariant: each number of either side has its entry, with errors or with the sentence that says why there are none.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from .analysis import read_frame
from .difference import Difference, Overlap, difference, incomparable
from .difference_picture import difference_picture
from .display import Display
from .errors import ToolError
from .parallel import in_processes
from .png import png
from .sequence import NUMBERED, list_sequence


@dataclass(frozen=True)
class Limits:
    """What makes two frames too different; `None` is no limit."""

    rmse: float | None = None
    relative_mse: float | None = None
    flip: float | None = None
    max_error: float | None = None
    ids: float | None = None


@dataclass(frozen=True)
class Pair:
    """Two files of one number, either of which may be missing."""

    number: int | None
    output: str | None
    reference: str | None
    picture: str | None = None


@dataclass(frozen=True)
class Compared:
    """What became of a pair."""

    pair: Pair
    difference: Difference | None = None
    fault: str | None = None
    white: float | None = None

    def exceeded(self, limits: Limits) -> list[str]:
        """A sentence for each limit that is not kept, as it is not where there is nothing to measure."""
        if self.difference is None:
            return [self.fault or "it was not compared"]
        found = self.difference
        measures = found.measures
        sentences = []
        if any(errors.not_finite for errors in found.channels.values()):
            sentences.append("values are not finite")
        for name, value, limit in (
            ("RMSE", measures and measures.rmse, limits.rmse),
            ("relative mean square error", measures and measures.relative_mse, limits.relative_mse),
            ("mean FLIP", found.flip, limits.flip),
            ("largest difference", measures and measures.max_error, limits.max_error),
            ("share of ids that differ", found.ids_share, limits.ids),
        ):
            # Not `>`: an error that is no number is too large as well.
            if limit is not None and not (value is not None and value <= limit):
                said = "unknown" if value is None else f"{value:.4g}"
                sentences.append(f"{name} {said}, allowed {limit:g}")
        return sentences


def pair_up(output: Path, reference: Path, pictures: Path | None = None) -> list[Pair]:
    """Two files as one pair, whatever their numbers; else two sequences by number."""
    if output.is_file() and reference.is_file():
        match = NUMBERED.fullmatch(output.name)
        return [Pair(int(match["number"]) if match else None, str(output), str(reference), pictures and str(pictures))]
    for one, other in ((output, reference), (reference, output)):
        if one.is_file() and other.is_dir():
            raise ToolError(f"{one} is a file and {other} a folder: give two files, or two sequences")
    listings = [list_sequence(output), list_sequence(reference)]
    sides = [{file.number: str(file.path) for file in listing.frames} for listing in listings]
    return [
        Pair(n, sides[0].get(n), sides[1].get(n), pictures and str(pictures / f"difference.{n:04d}.png"))
        for n in sorted(sides[0].keys() | sides[1].keys())
    ]


def compare(
    output: str | Path,
    reference: str | Path,
    wants_flip: bool = False,
    pictures: Path | None = None,
    display: Display = Display(),
    white: float | None = None,
    processes: int | None = None,
    progress: Callable[[int, int], None] = lambda done, of: None,
) -> list[Compared]:
    """Compares two files, or two folders or patterns frame by frame.

    `pictures` is where difference pictures go: a file for two files, else a folder. `processes` is as in `Options`. Raises
    `ToolError` if there is nothing to compare.
    """
    pairs = pair_up(Path(output), Path(reference), pictures)
    processes = min(os.cpu_count() or 1 if processes is None else processes, len(pairs))
    results = []
    work = partial(_compare, wants_flip, display, white)
    for result in in_processes(work, pairs, processes, lambda pair: Compared(pair, fault="the decoder crashed")):
        results.append(result)
        progress(len(results), len(pairs))
    return results


def _compare(wants_flip: bool, display: Display, white: float | None, pair: Pair) -> Compared:
    frames = []
    for side, path in (("output", pair.output), ("reference", pair.reference)):
        if path is None:
            return Compared(pair, fault=f"the {side} has no such frame")
        file, frame = read_frame(pair.number or 0, path)
        if frame is None:
            return Compared(pair, fault=f"{path}: {file.fault}")
        frames.append(frame)
    if (why := incomparable(*frames)) is not None:
        return Compared(pair, fault=why)
    found = difference(*frames, wants_flip)
    if pair.picture is not None and found.color is not None:
        pixels, white = difference_picture(Overlap(*frames), display, white)
        Path(pair.picture).write_bytes(png(pixels))
    return Compared(pair, found, white=white if pair.picture is not None else None)
