"""One file to its summary: the work of a process of its own.

Invariant: memory is bounded by one frame (two with a reference, three for fireflies), and the outcome is a summary
whatever the file holds.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import nan
from mmap import mmap
from pathlib import Path

from . import checks  # noqa: F401  (registers them)
from .checks import fireflies, reference
from .difference import Overlap, errors, mean_flip
from .exr.chunks import chunk_faults
from .exr.decode import DecodeError, claims_too_much, decode
from .exr.header import DEEP, MULTIPART, TILED, Header, HeaderError, parse_header
from .exr.mapped import mapped
from .exr.pixel_hash import pixel_hash
from .findings import Finding, Scope, checks_of
from .frame import FileBytes, Frame
from .summary import FrameSummary, describe, measure, thumbnail


@dataclass(frozen=True)
class Job:
    """A frame to look at."""

    number: int
    path: str
    compares: bool = False
    reference: str | None = None
    wants_flip: bool = False
    thumbnail_width: int = 0
    skip_checks: frozenset[str] = frozenset()


def read_frame(number: int, path: str) -> tuple[FileBytes, Frame | None]:
    """A file's pixels, or in the first what stood in the way."""
    file = FileBytes(number, Path(path))
    try:
        with mapped(file.path) as data:
            header = _parse(file, data)
    except OSError as error:
        file.read_error = error.strerror or str(error)
        return file, None
    if header is None:
        return file, None
    try:
        channels = decode(file.path)
    except DecodeError as error:
        file.decode_error = str(error)
        return file, None
    return file, Frame(number, file.path, header, channels, pixel_hash(channels))


def _parse(file: FileBytes, data: mmap | bytes) -> Header | None:
    """Everything that can be said without decoding; the header only if nothing speaks against that."""
    file.bytes = len(data)
    try:
        header = file.header = parse_header(data)
    except HeaderError as error:
        file.header_error = str(error)
        return None
    if header.flags & MULTIPART:
        file.unsupported = "a file of several parts"
    elif header.flags & DEEP:
        file.unsupported = "deep data"
    elif any(channel.sampling != (1, 1) for channel in header.channels):
        file.unsupported = "a subsampled channel"
    file.claim = claims_too_much(header, len(data))
    if file.unsupported or file.claim:
        return None
    if not header.flags & TILED:
        file.chunk_faults = list(chunk_faults(header, data))
    return None if file.chunk_faults else header


def analyse(job: Job) -> FrameSummary:
    """Runs every check that needs this file alone, and keeps what the others need."""
    summary = FrameSummary(job.number, job.path)
    file, frame = read_frame(job.number, job.path)
    summary.bytes = file.bytes
    if file.header:
        describe(summary, file.header)
    summary.findings += _run(Scope.FILE, file, job)
    if frame is None:
        return summary
    if (luminance := frame.luminance()) is not None:
        summary.firefly_candidates = fireflies.candidates(luminance)
    measure(summary, frame, luminance)
    summary.findings += _run(Scope.FRAME, frame, job)
    if job.thumbnail_width:
        summary.thumbnail = thumbnail(frame, job.thumbnail_width)
    if job.compares:
        _compare(summary, frame, job)
    return summary


def without_pixels(job: Job, reason: str) -> FrameSummary:
    """The summary of a frame whose process did not survive it."""
    summary = FrameSummary(job.number, job.path)
    file = FileBytes(job.number, Path(job.path), bytes=Path(job.path).stat().st_size, decode_error=reason)
    summary.bytes = file.bytes
    summary.findings += _run(Scope.FILE, file, job)
    return summary


def confirm_fireflies(found: list[fireflies.Candidate], neighbours: list[str]) -> list[fireflies.Candidate]:
    """The candidates that none of the frames before and after shows too."""
    for path in neighbours:
        if found:
            _, frame = read_frame(0, path)
            if frame is not None and (luminance := frame.luminance()) is not None:
                found = fireflies.absent_in(luminance, found)
    return found


def _run(scope: Scope, subject: FileBytes | Frame, job: Job) -> list[Finding]:
    return [
        Finding(f.check, f.severity, f.message, job.number, job.path, f.channel, f.pixel)
        for check in checks_of(scope)
        if check.id not in job.skip_checks
        for f in check.run(subject)
    ]


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
        overlap = Overlap(frame, other)
        color = errors(overlap, list("RGB"))
        # One value that is not finite spoils the picture, whatever the others are.
        summary.relmse = nan if color.not_finite or color.relative_mse is None else color.relative_mse
        if job.wants_flip:
            summary.flip = mean_flip(*overlap.colors())
