"""Analysis of one file, in a process of its own. In goes a job, out comes a summary.

Invariant: memory is bounded by one frame (two with a reference, three for fireflies), and every file gives
a summary.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from mmap import mmap
from pathlib import Path

import numpy as np

from . import checks  # noqa: F401  (registers them)
from .checks import blocks, fireflies, order, reference
from .difference import mean_flip, relative_mse
from .exr.chunks import chunk_faults
from .exr.decode import DecodeError, claims_too_much, decode_parts, full_size
from .exr.header import Header, HeaderError, parse_headers
from .exr.mapped import mapped
from .exr.pixel_hash import pixel_hash
from .findings import Finding, findings_in
from .frame import FileBytes, Frame
from .layers import part_of_picture
from .summary import FrameSummary, Suspicion, describe, measure, thumbnail


@dataclass(frozen=True)
class Job:
    """Frame to analyse."""

    number: int
    path: str
    compares: bool = False
    reference: str | None = None
    wants_flip: bool = False
    thumbnail_width: int = 0
    skip_checks: frozenset[str] = frozenset()


def read_frame(number: int, path: str) -> tuple[FileBytes, Frame | None]:
    """Pixels of a file, or the first fault that prevents reading."""
    file = FileBytes(number, Path(path))
    try:
        with mapped(file.path) as data:
            headers = _parse(file, data)
    except OSError as error:
        file.read_error = error.strerror or str(error)
        return file, None
    if not headers:
        return file, None
    try:
        channels, part_of = _named(
            headers, decode_parts(file.path, sum(header.pixel_bytes for header in headers))
        )
    except DecodeError as error:
        file.decode_error = str(error)
        return file, None
    return file, Frame(number, file.path, headers, channels, part_of, pixel_hash(channels))


def read_picture(path: str | Path) -> tuple[Frame | None, str | None]:
    """Frame with colour, or the sentence why there is none."""
    file, frame = read_frame(0, str(path))
    if frame is None:
        return None, file.fault
    if not frame.picture:
        return None, f"it has no picture (R, G and B of a layer, or Y), only {', '.join(frame.channels)}"
    return frame, None


def _named(
    headers: Sequence[Header], parts: list[dict[str, np.ndarray]]
) -> tuple[dict[str, np.ndarray], dict[str, int]]:
    """Channels of all parts by unique names, and the part of each. Names in the picture's part stay plain,
    whatever its index."""
    if len(parts) != len(headers):
        raise DecodeError(f"{len(parts)} parts can be decoded, of {len(headers)}")
    plain = part_of_picture([(header.name, list(stored)) for header, stored in zip(headers, parts)])
    channels: dict[str, np.ndarray] = {}
    part_of: dict[str, int] = {}
    for number in sorted(range(len(parts)), key=lambda number: number != plain):
        header, stored = headers[number], parts[number]
        described = {channel.name: channel for channel in header.channels}
        for own_name, pixels in stored.items():
            is_whole = number == plain or own_name.startswith(f"{header.name}.")
            name = own_name if is_whole else f"{header.name}.{own_name}"
            if name in channels:
                name = f"part {number + 1}.{own_name}"
            if own_name not in described:
                raise DecodeError(f"the decoder names a channel {own_name} that the header does not")
            channels[name] = full_size(header, described[own_name], pixels)
            part_of[name] = number
    return channels, part_of


def _parse(file: FileBytes, data: mmap | bytes) -> tuple[Header, ...]:
    """Runs the checks that need no decoding; returns the headers unless a fault prevents decoding."""
    file.bytes = len(data)
    try:
        headers = file.headers = parse_headers(data)
    except HeaderError as error:
        file.header_error = str(error)
        return ()
    if deep := [header for header in headers if header.is_deep]:
        named = ", ".join(channel.name for channel in deep[0].channels)
        file.unsupported = f"deep data ({named}{f' in part {deep[0].name}' if deep[0].name else ''})"
    file.claim = claims_too_much(headers, len(data))
    if file.unsupported or file.claim:
        return ()
    file.chunk_faults = [
        fault for part, header in enumerate(headers) for fault in chunk_faults(header, data, part)
    ]
    return () if file.chunk_faults else headers


def analyse(job: Job) -> FrameSummary:
    """Runs every check that needs only this file, and keeps the data for others."""
    summary = FrameSummary(job.number, job.path)
    file, frame = read_frame(job.number, job.path)
    summary.bytes = file.bytes
    if file.headers:
        describe(summary, file.headers)
    summary.findings += _run(file, job)
    if frame is None:
        return summary
    if (luminance := frame.luminance()) is not None:
        left, top = frame.header.data_window[:2]
        summary.suspicion.fireflies = [
            (x + left, y + top, value, around) for x, y, value, around in fireflies.candidates(luminance)
        ]
        summary.suspicion.blocks = blocks.candidates(frame)
        summary.suspicion.window = frame.header.data_window
        summary.signature = order.signature(frame, luminance)
    measure(summary, frame, luminance)
    summary.findings += _run(frame, job)
    if job.thumbnail_width:
        summary.thumbnail = thumbnail(frame, job.thumbnail_width)
    if job.compares:
        _compare(summary, frame, job)
    return summary


def without_pixels(job: Job, reason: str) -> FrameSummary:
    """Summary of a frame whose process crashed."""
    summary = FrameSummary(job.number, job.path)
    file = FileBytes(job.number, Path(job.path), bytes=Path(job.path).stat().st_size, decode_error=reason)
    summary.bytes = file.bytes
    summary.findings += _run(file, job)
    return summary


def confirm(suspicion: Suspicion, neighbours: list[str]) -> Suspicion:
    """Suspicion without the parts that a neighbouring frame shows too."""
    found = suspicion
    seen = 0
    for path in neighbours:
        if found:
            _, frame = read_frame(0, path)
            if frame is not None and (luminance := frame.luminance()) is not None:
                corner = frame.header.data_window[:2]
                spikes = fireflies.absent_in(luminance, found.fireflies, corner)
                found = replace(
                    found, fireflies=spikes, blocks=blocks.lit_in(luminance, found.blocks, corner)
                )
                seen += 1
    # Without other frames, the block's own shape decides.
    return found if seen else replace(found, blocks=blocks.unlikely_alone(found.blocks, found.window))


def _run(subject: FileBytes | Frame, job: Job) -> list[Finding]:
    return [replace(found, frame=job.number, path=job.path) for found in findings_in(subject, job.skip_checks)]


def _compare(summary: FrameSummary, frame: Frame, job: Job) -> None:
    if job.reference is None:
        summary.reference_error = "there is no reference frame of its number"
        return
    _, other = read_frame(job.number, job.reference)
    if other is None:
        summary.reference_error = f"the reference {job.reference} cannot be read"
    elif (why := reference.comparable(frame, other)) is not None:
        summary.reference_error = f"it cannot be compared: {why}"
    else:
        summary.relmse = relative_mse(frame, other)
        if job.wants_flip:
            summary.flip = mean_flip(frame, other)
