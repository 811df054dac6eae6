"""Types of arguments that commands share. In goes text, out come values, or the sentence that argparse
prints."""

from argparse import ArgumentParser, ArgumentTypeError
from fractions import Fraction
from pathlib import Path

from ..frame_list import parse_frames


def add_reading(parser: ArgumentParser) -> None:
    """Adds the options for reading an input."""
    parser.add_argument(
        "--allow", metavar="DIR", type=Path, action="append", default=[], help="a folder to read from too (the input's own alone)"
    )
    parser.add_argument(
        "--sunfleck", metavar="PROGRAM", help="the program sunfleck (environment's SUNFLECK, else the PATH)"
    )


def frames(text: str) -> tuple[int, ...]:
    """List of frames, ascending, or the contents of the file after `@`; `none` is an empty list."""
    try:
        if text.startswith("@"):
            text = Path(text[1:]).read_text()
        return () if text.strip() == "none" else tuple(sorted(parse_frames(text.strip())))
    except OSError as error:
        raise ArgumentTypeError(f"{text}: {error.strerror}") from None
    except ValueError as error:
        raise ArgumentTypeError(str(error)) from None


def frame_range(text: str) -> tuple[int, int]:
    """First and last frame of a contiguous range."""
    listed = frames(text)
    if not listed or len(listed) != listed[-1] - listed[0] + 1:
        raise ArgumentTypeError(f"`{text}` leaves frames out: write the first and the last, 1-48")
    return listed[0], listed[-1]


def frame_rate(text: str) -> Fraction:
    """Frames a second, as an exact fraction."""
    try:
        rate = Fraction(text)
    except (ValueError, ZeroDivisionError):
        rate = Fraction(0)
    if rate <= 0:
        raise ArgumentTypeError(f"`{text}` is no frame rate: write for instance 24 or 24000/1001")
    return rate


def positive(text: str) -> float:
    """A number above 0."""
    number = limit(text)
    if number == 0:
        raise ArgumentTypeError(f"`{text}` is no number above 0")
    return number


def limit(text: str) -> float:
    """A number from 0 on; 0 asks for equality, as in `sunfleck diff`."""
    try:
        number = float(text)
    except ValueError:
        number = -1.0
    if not 0 <= number < float("inf"):
        raise ArgumentTypeError(f"`{text}` is no number from 0 on")
    return number


def count(text: str) -> int:
    """From 1 to 1024."""
    if not text.isascii() or not text.isdigit() or not 1 <= int(text) <= 1024:
        raise ArgumentTypeError(f"`{text}` is no number from 1 to 1024")
    return int(text)
