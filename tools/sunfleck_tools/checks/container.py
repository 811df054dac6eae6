"""Checks of the file around the pixels: header, chunks, and the decoder's errors."""

from collections.abc import Iterator

from ..exr import file_hash as whole
from ..exr.colors import color_space
from ..exr.header import Header
from ..exr.mapped import mapped
from ..findings import Found, Severity, check
from ..frame import FileBytes, Frame
from ..layers import Kind, kind

NAME = "sunfleck:pixelHash"


@check("unreadable", Severity.ERROR, "the system does not let the file be read", rerender=True)
def unreadable(file: FileBytes) -> Iterator[Found]:
    """Missing permissions, failing disks, links to nothing and FIFOs: a render replaces them."""
    if file.read_error:
        yield Found(f"it cannot be read: {file.read_error}")


@check("empty-file", Severity.ERROR, "the file has no bytes", rerender=True)
def empty_file(file: FileBytes) -> Iterator[Found]:
    """Placeholders that a farm created and never filled."""
    if file.bytes == 0 and not file.read_error:
        yield Found("the file is empty")


@check("header", Severity.ERROR, "the header is damaged or cut off", rerender=True)
def header(file: FileBytes) -> Iterator[Found]:
    """A file with a damaged header allows no other check."""
    if file.header_error and file.bytes:
        yield Found(file.header_error)


@check("size-claim", Severity.ERROR, "the header claims more pixels than the file can hold", rerender=True)
def size_claim(file: FileBytes) -> Iterator[Found]:
    """Checked before the decoder allocates memory."""
    if file.claim:
        yield Found(file.claim)


@check("unsupported", Severity.ERROR, "deep data")
def unsupported(file: FileBytes) -> Iterator[Found]:
    """Deep pixels have any number of values, and are no picture."""
    if file.unsupported:
        yield Found(f"{file.unsupported} cannot be checked: flatten it")


@check("chunks", Severity.ERROR, "a chunk of pixels is missing, misplaced or cut off", rerender=True)
def chunks(file: FileBytes) -> Iterator[Found]:
    """The first faulty chunk; a truncated file has many."""
    if file.chunk_faults:
        first, *others = file.chunk_faults
        more = "1 more chunk is" if len(others) == 1 else f"{len(others)} more chunks are"
        yield Found(first + (f", and {more} damaged" if others else ""))


@check("decode", Severity.ERROR, "a chunk cannot be decompressed", rerender=True)
def decode(file: FileBytes) -> Iterator[Found]:
    """Checksums of deflate, and every other error of OpenEXR."""
    if file.decode_error:
        yield Found(f"it cannot be decoded: {file.decode_error}")


@check("pixel-hash", Severity.ERROR, "the pixels are not those that the file was written with", rerender=True)
def pixel_hash(frame: Frame) -> Iterator[Found]:
    """Damage that decodes without complaint, as in uncompressed or PIZ files."""
    if not _has_its_pixels(frame):
        stored = frame.headers[0].text(NAME) or ""
        yield Found(f"the pixels' hash is {frame.hash[:12]}..., the header says {stored[:12]}...")


@check("file-hash", Severity.ERROR, "a byte is not the one that the file was written with", rerender=True)
def file_hash(frame: Frame) -> Iterator[Found]:
    """Damage outside the pixels: in the header, or bytes at the end. `pixel-hash` reports the pixels."""
    if whole.NAME not in frame.headers[0].values or not _has_its_pixels(frame):
        return
    try:
        with mapped(frame.path) as data:
            hashes = whole.file_hash(data)
    except OSError as error:
        yield Found(f"it cannot be read a second time: {error.strerror or error}")
        return
    if hashes is None:
        yield Found("the file's hash is no 64 digits: its header is damaged")
    elif hashes[0] != hashes[1]:
        said, has = hashes
        yield Found(
            f"the file's hash is {has[:12]}..., its header says {said[:12]}...: it is damaged, or saved by "
            "another program"
        )


def _has_its_pixels(frame: Frame) -> bool:
    return frame.headers[0].text(NAME) in (None, frame.hash)


@check("colour-space", Severity.WARNING, "what a file says of its colours is not known, or not one")
def colour_space(file: FileBytes) -> Iterator[Found]:
    """Programs use `colorInteropID`, `chromaticities`, or neither: if the two disagree, colours differ
    between programs."""
    for header in file.headers:
        if (doubt := color_space(header).doubt) is not None and not (header.is_deep or _is_data(header)):
            where = f"part {header.name}: " if header.name else ""
            yield Found(f"{where}{doubt}")


def _is_data(header: Header) -> bool:
    """True for a part that declares itself as data, and for one without light."""
    light = any(kind(f"{header.name}.{channel.name}") is Kind.LIGHT for channel in header.channels)
    return header.text("colorInteropID") == "data" and not light
