"""Checks of names alone: missing, unexpected and foreign files."""

from collections.abc import Iterator

from ..findings import Found, Severity, check
from ..frame_list import format_frames
from ..sequence import Listing


@check("missing-frame", Severity.ERROR, "a frame of the range has no file", rerender=True)
def missing_frame(listing: Listing) -> Iterator[Found]:
    """Frames lost on a farm."""
    for number in listing.missing:
        yield Found(f"there is no {listing.name_of(number)}", frame=number)


@check("shorter-sequence", Severity.WARNING, "another sequence of the folder goes on where this one ends")
def shorter_sequence(listing: Listing) -> Iterator[Found]:
    """A missing last frame leaves no gap, but other passes of the same render have it."""
    for pattern, numbers in listing.elsewhere.items():
        if not set(numbers) <= set(listing.missing):
            yield Found(f"{pattern} has frames {format_frames(numbers)} too, and {listing.pattern} has not")


@check("unexpected-frame", Severity.WARNING, "a file's number lies outside of the range asked for, or the scene's; nothing else of it is checked")
def unexpected_frame(listing: Listing) -> Iterator[Found]:
    """Without either range every frame is expected."""
    expected = set(listing.expected)
    for file in listing.frames:
        if file.number not in expected:
            message = f"it is none of {format_frames(expected) or 'no frame'}, and was not looked at"
            yield Found(message, frame=file.number, path=str(file.path))


@check("duplicate-frame", Severity.ERROR, "two files have one frame's number")
def duplicate_frame(listing: Listing) -> Iterator[Found]:
    """x.1.exr beside x.0001.exr: programs read either of them."""
    chosen = {file.number: file for file in listing.frames}
    for file in listing.files:
        first = chosen[file.number]
        if file is not first:
            said = f"{file.path.name} has the number of {first.path.name}"
            yield Found(said, frame=file.number, path=str(file.path))


@check("mixed-padding", Severity.WARNING, "a number is padded otherwise than the sequence's")
def mixed_padding(listing: Listing) -> Iterator[Found]:
    """Programs with the pattern x.####.exr do not find x.7.exr."""
    for file in listing.frames:
        if not listing.is_padded(file):
            message = f"{file.path.name} should be {listing.name_of(file.number)}"
            yield Found(message, frame=file.number, path=str(file.path))


@check("foreign-file", Severity.WARNING, "an EXR file beside the sequence belongs to no frame of it")
def foreign_file(listing: Listing) -> Iterator[Found]:
    """Renamed frames, and other sequences in the same folder."""
    for path in listing.strangers:
        yield Found(f"{path.name} is no frame of {listing.pattern}", path=str(path))


@check("temporary-file", Severity.WARNING, "a render that was killed left a temporary file")
def temporary_file(listing: Listing) -> Iterator[Found]:
    """`sunfleck render --skip valid` removes them."""
    for path in listing.leftovers:
        yield Found(f"{path.name} is what a killed render left", path=str(path))
