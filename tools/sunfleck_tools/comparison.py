"""Two frames, or two folders of sequences frame by frame, against each other.

Invariant: each number of either side has its entry, with errors or with the sentence that
says why there are none.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from .analysis import read_frame
from .difference import Difference, Overlap, are_of_one_space, difference, incomparable
from .difference_picture import difference_picture
from .disk import write_whole
from .display import Display
from .errors import ToolError
from .frame import Frame
from .limits import Limits
from .names import parts
from .parallel import in_processes
from .png import png
from .sequence import Listing, list_sequences


@dataclass(frozen=True)
class Pair:
    """Two files of one number, either of which may be missing."""

    number: int | None
    output: str | None
    reference: str | None
    picture: str | None = None
    sequence: str = ""
    """The pattern of its names, where there are several sequences."""


@dataclass(frozen=True)
class Compared:
    """What became of a pair."""

    pair: Pair
    difference: Difference | None = None
    fault: str | None = None
    white: float | None = None
    notes: tuple[str, ...] = ()
    """What of the files' colours is converted, or not honoured."""

    def exceeded(self, limits: Limits) -> list[str]:
        """A sentence for each limit that is not kept, as it is not where there is nothing to measure."""
        return (
            [self.fault or "it was not compared"]
            if self.difference is None
            else list(limits.exceeded(self.difference))
        )


def pair_up(output: Path, reference: Path, pictures: Path | None = None) -> list[Pair]:
    """Two files as one pair, whatever their numbers; else two sequences by number, of several those
    of the same names."""
    if output.is_file() and reference.is_file():
        found = parts(output.name)
        number, picture = int(found.number) if found else None, str(pictures) if pictures else None
        return [Pair(number, str(output), str(reference), picture)]
    for one, other in ((output, reference), (reference, output)):
        if one.is_file() and other.is_dir():
            raise ToolError(f"{one} is a file and {other} a folder: give two files, or two sequences")
    sides = [list_sequences(side) for side in (output, reference)]
    if len(sides[0]) == len(sides[1]) == 1:
        return _by_number(sides[0][0], sides[1][0], pictures)
    ours, theirs = ({listing.key: listing for listing in listings} for listings in sides)
    keys = [*ours, *(key for key in theirs if key not in ours)]
    return [
        pair for key in keys for pair in _by_number(ours.get(key), theirs.get(key), pictures, is_one=False)
    ]


def _by_number(
    output: Listing | None, reference: Listing | None, pictures: Path | None, is_one: bool = True
) -> list[Pair]:
    """The pairs of two sequences, either of which may be missing; `is_one` if there are no
    others beside them."""
    sides = [
        {f.number: str(f.path) for f in listing.frames} if listing else {} for listing in (output, reference)
    ]
    listing = output or reference
    assert listing is not None, "one of the two is there"

    def picture(number: int) -> str | None:
        name = (
            f"difference.{number:04d}.png"
            if is_one
            else f"difference.{Path(listing.name_of(number)).stem}.png"
        )
        return str(pictures / name) if pictures else None

    return [
        Pair(None if listing.is_still else n, sides[0].get(n), sides[1].get(n), picture(n), "" if is_one else listing.pattern)
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

    `pictures` is where difference pictures go: a file for two files, else a folder. `processes` is as in
    `Options`. Raises `ToolError` if there is nothing to compare.
    """
    pairs = pair_up(Path(output), Path(reference), pictures)
    processes = min(os.cpu_count() or 1 if processes is None else processes, len(pairs))
    results = []
    work = partial(_compare, wants_flip, display, white)
    for result in in_processes(
        work, pairs, processes, lambda pair: Compared(pair, fault="the decoder crashed")
    ):
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
    output, reference = frames
    if (why := incomparable(output, reference)) is not None:
        return Compared(pair, fault=why)
    found, overlap = difference(output, reference, wants_flip), Overlap(output, reference)
    if pair.picture is not None and all(frame.picture for frame in frames) and not overlap.is_empty:
        pixels, white = difference_picture(overlap, display, white)
        write_whole(Path(pair.picture), png(pixels))
    return Compared(pair, found, white=white if pair.picture is not None else None, notes=_notes(*frames))


def _notes(output: Frame, reference: Frame) -> tuple[str, ...]:
    """Sentences on the colours of two frames that were compared."""
    notes = [f"{frame.path}: {frame.space.doubt}" for frame in (output, reference) if frame.space.doubt]
    if not are_of_one_space(output, reference):
        notes.append(
            f"the pictures are in different colour spaces, {output.space} and {reference.space}: R, G and B are "
            "compared in linear Rec. 709, other channels as they are stored"
        )
    return tuple(notes)
