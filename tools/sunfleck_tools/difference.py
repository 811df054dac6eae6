"""How far one frame is from another, as `sunfleck diff` defines it.

Invariant: values that are not finite count as such and enter no mean; ids are equal or not, and enter none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .exr.header import window_size
from .frame import Frame
from .layers import holds_ids


@dataclass(frozen=True)
class Errors:
    """Of an output o against a reference r, over all values that are finite in both; `None` without such."""

    mean_ratio: float | None
    """mean(o) / mean(r); `None` where r is black."""
    rmse: float | None
    """sqrt(mean((o - r)^2))."""
    relative_mse: float | None
    """mean((o - r)^2 / (r^2 + (0.1 mean(r))^2))."""
    max_error: float | None
    """The largest |o - r|."""
    channel: str | None
    """Where that is; `None` if the two are equal."""
    pixel: tuple[int, int] | None
    """Column and row in the full picture."""
    not_finite: int
    """Values that are NaN or infinite in either frame, and not the same infinity in both."""


@dataclass(frozen=True)
class IdErrors:
    """Pixels of a channel of ids that name another thing than the reference's do."""

    different: int
    pixel: tuple[int, int] | None
    """The first of them, by row, then column; `None` without such."""
    pixels: int
    """That were compared."""


@dataclass(frozen=True)
class Difference:
    """Two frames that could be compared."""

    color: Errors | None
    """Red, green and blue of the picture together."""
    picture: tuple[str, ...]
    """The channels that these are."""
    channels: dict[str, Errors]
    """Every channel of amounts that both have."""
    ids: dict[str, IdErrors]
    """Every channel of ids that both have."""
    unmatched: list[str]
    """Channels that only one of them has."""
    shared: tuple[int, int] | None = None
    """Width and height of what was compared of the pictures, where one of them has pixels that
    the other has not."""
    flip: float | None = None
    """Mean HDR-FLIP of the colour; `None` where it was not asked for, or colours are not finite."""

    @property
    def measures(self) -> Errors | None:
        """What limits are for: the colour, else the first channel; `None` if there are ids alone."""
        return self.color or next(iter(self.channels.values()), None)

    @property
    def ids_share(self) -> float | None:
        """The largest share of a channel's ids that differ; `None` without such channels."""
        return max((found.different / found.pixels for found in self.ids.values()), default=None)


class Overlap:
    """The pixels that two frames have in common, of a channel or, without one, of the pictures."""

    def __init__(self, output: Frame, reference: Frame, name: str | None = None):
        self._frames, self._name = (output, reference), name
        self._headers = [frame.header if name is None else frame.header_of(name) for frame in self._frames]
        windows = [header.data_window for header in self._headers]
        self.left, self.top = (max(window[axis] for window in windows) for axis in (0, 1))
        self.right, self.bottom = (min(window[axis] for window in windows) for axis in (2, 3))
        self.is_empty = self.right < self.left or self.bottom < self.top

    def channel(self) -> list[np.ndarray]:
        """The channel of output and reference as float32, cut to what both have."""
        name = self._channel_name()
        return [_in_one_space(frame, self._frames, name)[place] for frame, place in zip(self._frames, self._places())]

    def stored(self) -> list[np.ndarray]:
        """The same as they are stored."""
        name = self._channel_name()
        return [frame.channels[name][place] for frame, place in zip(self._frames, self._places())]

    def colors(self) -> list[np.ndarray]:
        """Output and reference, colours in the last axis; those of different spaces in linear Rec. 709."""
        is_one = are_of_one_space(*self._frames)
        return [
            np.stack([color[place] for color in (frame.group() if is_one else frame.shown())], axis=-1)
            for frame, place in zip(self._frames, self._places())
        ]

    def shown(self) -> list[np.ndarray]:
        """Output and reference in linear Rec. 709, colours in the last axis."""
        return [
            np.stack([color[place] for color in frame.shown()], axis=-1)
            for frame, place in zip(self._frames, self._places())
        ]

    def _channel_name(self) -> str:
        assert self._name is not None, "it is of the pictures"
        return self._name

    def _places(self) -> list[tuple[slice, slice]]:
        corners = [header.data_window[:2] for header in self._headers]
        return [
            (slice(self.top - top, self.bottom - top + 1), slice(self.left - left, self.right - left + 1))
            for left, top in corners
        ]


def are_of_one_space(output: Frame, reference: Frame) -> bool:
    """True if the numbers of both pictures stand for the same colours."""
    return output.space == reference.space


def _in_one_space(frame: Frame, both: Sequence[Frame], name: str) -> np.ndarray:
    """A channel as float32; of pictures of different spaces red, green and blue are in linear Rec. 709."""
    if are_of_one_space(*both) or len(frame.picture) != 3 or name not in frame.picture:
        return frame.float(name)
    return frame.shown()[frame.picture.index(name)]


def incomparable(output: Frame, reference: Frame) -> str | None:
    """A sentence if two frames cannot be compared."""
    ours, theirs = (window_size(frame.header.display_window) for frame in (output, reference))
    if ours != theirs:
        return f"the pictures differ in size: {ours[0]}x{ours[1]} against {theirs[0]}x{theirs[1]} pixels"
    both = [name for name in output.channels if name in reference.channels]
    if not both:
        return "the two pictures have no channel in common"
    if all(Overlap(output, reference, name).is_empty for name in both):
        return "the two crops have no pixel in common"
    return None


def difference(output: Frame, reference: Frame, wants_flip: bool = False) -> Difference:
    """Compares frames that are comparable."""
    overlap = Overlap(output, reference)
    overlaps = {
        name: Overlap(output, reference, name) for name in output.channels if name in reference.channels
    }
    names = [name for name, shared in overlaps.items() if not shared.is_empty]
    has_color = len(output.picture) == 3 and output.picture == reference.picture and not overlap.is_empty
    color = color_errors(overlap, output.picture) if has_color else None
    finite = color is not None and color.not_finite == 0 and color.rmse is not None
    return Difference(
        color=color,
        picture=output.picture if has_color else (),
        channels={name: errors(overlaps[name], overlaps[name].channel(), [name]) for name in names if not holds_ids(name)},
        ids={name: id_errors(overlaps[name]) for name in names if holds_ids(name)},
        unmatched=sorted(output.channels.keys() ^ reference.channels.keys()),
        shared=_shared(overlap, output, reference),
        flip=mean_flip(*overlap.shown()) if wants_flip and finite else None,
    )


def _shared(overlap: Overlap, output: Frame, reference: Frame) -> tuple[int, int] | None:
    if output.header.data_window == reference.header.data_window or overlap.is_empty:
        return None
    return overlap.right - overlap.left + 1, overlap.bottom - overlap.top + 1


def color_errors(overlap: Overlap, names: Sequence[str]) -> Errors:
    """The errors of red, green and blue, of these names, taken together."""
    return errors(overlap, [np.moveaxis(colors, -1, 0) for colors in overlap.colors()], names)


def errors(overlap: Overlap, values: Sequence[np.ndarray], names: Sequence[str]) -> Errors:
    """The errors of an output's values against a reference's: a plane for each name, or one plane."""
    with np.errstate(invalid="ignore"):
        o, r = (planes.reshape(len(names), *planes.shape[-2:]).astype(np.float64) for planes in values)
    both = np.isfinite(o) & np.isfinite(r)
    not_finite = int(np.count_nonzero(~both & ~(o == r)))
    count = int(np.count_nonzero(both))
    if count == 0:
        return Errors(None, None, None, None, None, None, not_finite)
    o, r = np.where(both, o, 0.0), np.where(both, r, 0.0)
    squares = np.square(o - r)
    floor = (0.1 * r.sum() / count) ** 2
    with np.errstate(all="ignore"):
        # Where both are black, 0 / 0 would be no error at all.
        relative = np.where(squares > 0, squares / (np.square(r) + floor), 0.0)
    at = int(np.argmax(squares))
    largest = float(np.sqrt(squares.flat[at]))
    channel, rest = divmod(at, squares[0].size)
    y, x = divmod(rest, squares.shape[2])
    return Errors(
        mean_ratio=float(o.sum() / r.sum()) if r.sum() != 0 else None,
        rmse=float(np.sqrt(squares.sum() / count)),
        relative_mse=float(relative.sum() / count),
        max_error=largest,
        channel=names[channel] if largest > 0 else None,
        pixel=(x + overlap.left, y + overlap.top) if largest > 0 else None,
        not_finite=not_finite,
    )


def id_errors(overlap: Overlap) -> IdErrors:
    """How many ids differ: as bits, of which some are no numbers, unless the two are stored
    in different ways."""
    o, r = overlap.stored()
    if o.dtype == r.dtype:
        o, r = (np.ascontiguousarray(ids).view(f"u{ids.itemsize}") for ids in (o, r))
    apart = o != r
    count = int(np.count_nonzero(apart))
    y, x = divmod(int(np.argmax(apart)), apart.shape[1])
    return IdErrors(count, (x + overlap.left, y + overlap.top) if count else None, apart.size)


def mean_flip(output: np.ndarray, reference: np.ndarray) -> float:
    """HDR-FLIP (Andersson et al. 2021), its mean over the picture, by the authors' own package."""
    import flip_evaluator

    arrays = [np.ascontiguousarray(colors, np.float32) for colors in (reference, output)]
    return float(flip_evaluator.evaluate(*arrays, "HDR")[1])
