"""What makes two frames too different: limits of the picture and of every channel.

Invariants: each channel of amounts keeps one limit of each measure: that of the last pattern that names it,
else the one for all. A pattern that names no channel is not kept.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fnmatch import fnmatchcase

from .difference import Difference
from .layers import Kind, kind

MEASURES = {
    "rmse": "RMSE",
    "relative_mse": "relative mean square error",
    "max_error": "largest difference",
    "ids": "share of ids that differ",
}


@dataclass(frozen=True)
class ChannelLimit:
    """A limit of one measure, of `MEASURES`, for the channels whose names fit a pattern
    such as `diffuse.*`."""

    measure: str
    channels: str
    limit: float


@dataclass(frozen=True)
class Limits:
    """Those for all; `None` is no limit. `channels` are those of single channels, the later
    before the earlier."""

    rmse: float | None = None
    relative_mse: float | None = None
    flip: float | None = None
    max_error: float | None = None
    ids: float | None = None
    channels: tuple[ChannelLimit, ...] = ()

    @property
    def any(self) -> bool:
        """True if there is one."""
        return bool(self.channels) or any(
            limit is not None for limit in (self.rmse, self.relative_mse, self.flip, self.max_error, self.ids)
        )

    def exceeded(self, found: Difference) -> Iterator[str]:
        """A sentence for each limit that is not kept, as it is not where there is nothing to measure."""
        if any(
            errors.not_finite
            for name, errors in found.channels.items()
            if kind(name) in (Kind.LIGHT, Kind.ALPHA)
        ):
            yield "values are not finite"
        for measure in ("rmse", "relative_mse"):
            yield from self._of_measure(measure, found)
        yield from _too_much("mean FLIP", found.flip, self.flip)
        for measure in ("max_error", "ids"):
            yield from self._of_measure(measure, found)

    def _of_measure(self, measure: str, found: Difference) -> Iterator[str]:
        label, general = MEASURES[measure], getattr(self, measure)
        values = _values(measure, found)
        limits = {name: general for name in values if name not in found.picture}
        if measure != "ids" and found.color is not None:
            yield from _too_much(label, getattr(found.color, measure), general)
        elif not values:
            yield from _too_much(label, None, general)
        for channel in self.channels:
            if channel.measure == measure:
                named = [name for name in values if fnmatchcase(name, channel.channels)]
                limits.update(dict.fromkeys(named, channel.limit))
                if not named:
                    yield f"no channel that both have is named {channel.channels}"
        for name, limit in limits.items():
            yield from _too_much(f"{label} of {name}", values[name], limit)


def _values(measure: str, found: Difference) -> dict[str, float | None]:
    if measure == "ids":
        return {name: errors.different / errors.pixels for name, errors in found.ids.items()}
    return {name: getattr(errors, measure) for name, errors in found.channels.items()}


def _too_much(what: str, value: float | None, limit: float | None) -> Iterator[str]:
    # Not `>`: an error that is no number is too large as well.
    if limit is not None and not (value is not None and value <= limit):
        yield f"{what} {'unknown' if value is None else f'{value:.4g}'}, allowed {limit:g}"
