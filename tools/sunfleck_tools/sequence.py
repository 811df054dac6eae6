"""Listing of sequences. In goes a folder or pattern, out come the numbered files of its sequences.

Invariant: every EXR file of the folder is a frame of one listing; single files beside a sequence are also
its `strangers`.
"""

import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from .errors import ToolError
from .names import Parts, parts

PLACE = re.compile(r"#+|@+|%(\d*)[di]|\$\{?F(\d*)\}?|<F(\d*)>")
PART_SUFFIX = ".sunfleck-part"
STILL_NUMBER = 0
NEARLY_TOGETHER = 10
"""Two sequences belong together if one has at most this fraction of frames beyond the other."""
MOST_NAMED = 3
"""Maximum number of sequences in a message."""


class SequenceError(ToolError):
    """There are no frames to check."""


@dataclass(frozen=True)
class Named:
    """File with the number in its name."""

    number: int
    digits: str
    path: Path


@dataclass
class Listing:
    """Files of one sequence, by their names alone."""

    folder: Path
    before: str
    after: str
    digits: int
    files: list[Named]
    expected: list[int]
    strangers: list[Path] = field(default_factory=list)
    leftovers: list[Path] = field(default_factory=list)
    elsewhere: dict[str, list[int]] = field(default_factory=dict)
    """Frames of other sequences in the folder before the first or after the last of this one, by pattern."""
    is_still: bool = False
    """True for a single picture without a number in its name, which counts as frame 0."""

    @property
    def key(self) -> tuple[str, str]:
        """Common parts of all its names."""
        return self.before, self.after

    @property
    def pattern(self) -> str:
        """Pattern of the sequence, in the syntax of `--out`."""
        if self.is_still:
            return str(self.folder / self.before)
        return str(self.folder / f"{self.before}{'#' * self.digits}{self.after}")

    def name_of(self, number: int) -> str:
        """Expected name of frame `number`."""
        if self.is_still:
            return self.before
        return f"{self.before}{'-' if number < 0 else ''}{abs(number):0{self.digits}d}{self.after}"

    def is_padded(self, file: Named) -> bool:
        """True if a file's name is the expected one, or printf's: `%04d` counts the sign, as in `-001`."""
        printed = f"{self.before}{file.number:0{self.digits}d}{self.after}"
        return file.path.name in (self.name_of(file.number), printed)

    @property
    def frames(self) -> list[Named]:
        """One file a frame, ascending; of duplicates the one with the expected name."""
        chosen: dict[int, Named] = {}
        for file in sorted(
            self.files, key=lambda f: (f.number, f.path.name != self.name_of(f.number), f.path.name)
        ):
            chosen.setdefault(file.number, file)
        return list(chosen.values())

    @property
    def asked(self) -> list[Named]:
        """Frames that are expected; others are only named."""
        expected = set(self.expected)
        return [file for file in self.frames if file.number in expected]

    def expect(self, numbers: Iterable[int]) -> None:
        """Adds expected frames."""
        if not self.is_still:
            self.expected = sorted({*self.expected, *numbers})

    def confine(self, first: int, last: int) -> None:
        """Expects the frames between those found in a range alone, unless most lie outside: they were renumbered."""
        within = [file.number for file in self.files if first <= file.number <= last]
        if 2 * len(within) > len(self.files):
            self.expected = [number for number in self.expected if min(within) <= number <= max(within)]

    @property
    def missing(self) -> list[int]:
        """Expected frames without a file."""
        found = {file.number for file in self.files}
        return [number for number in self.expected if number not in found]


def list_sequence(target: str | Path, expected: tuple[int, ...] | None = None) -> Listing:
    """Single sequence of `target`, as in `list_sequences`; raises `SequenceError` if there are several."""
    listings = list_sequences(target, expected)
    long = [listing for listing in listings if len(listing.files) > 1]
    if len(long or listings) > 1:
        patterns = ", ".join(listing.pattern for listing in (long or listings)[:MOST_NAMED])
        raise SequenceError(
            f"{target} holds {len(long or listings)} sequences: name one of them, such as {patterns}"
        )
    return (long or listings)[0]


def list_sequences(target: str | Path, expected: tuple[int, ...] | None = None) -> list[Listing]:
    """Finds the frames of `target`: a folder, a pattern such as `out/x.####.exr`, or one file; the longest
    sequence first.

    Raises `SequenceError` if there are no frames.
    """
    path = Path(target)
    place = list(PLACE.finditer(path.name))
    if path.is_dir():
        return _all_of(path, expected)
    if path.is_file():
        return [_one_file(path, expected)]
    if len(place) == 1:
        return [_matching(path, place[0], expected)]
    if not path.exists():
        raise SequenceError(
            f"there is no {target}: expected a folder, a file, or a pattern such as out/name.####.exr", False
        )
    raise SequenceError(f"{target} is neither a folder nor a regular file", False)


def _all_of(folder: Path, expected: tuple[int, ...] | None) -> list[Listing]:
    names = _names(folder)
    groups = _groups(names)
    if not groups:
        raise SequenceError(f"{folder} holds no EXR files, such as name.0001.exr", False)
    long = {key: files for key, files in groups.items() if len(files) > 1}
    alone = sorted(file.path for key, files in groups.items() if key not in long for file in files)
    keys = sorted(groups, key=lambda key: (-len(groups[key]), key))
    listings = []
    for key in keys:
        is_first = key == keys[0]
        # Each leftover is reported once: by the sequence with the longest matching name.
        leftovers = [entry for entry in names if _leftover_of(entry, groups) == key]
        # A single file beside sequences has lost its name, or is foreign; it has no expected range.
        listed = _listing(folder, key, groups[key], None if long and key not in long else expected, leftovers)
        listed.strangers = alone if is_first and long else []
        listings.append(listed)
    _look_beside([listing for listing in listings if len(listing.files) > 1])
    return listings


def _look_beside(listings: list[Listing]) -> None:
    """Compares sequences that begin and end nearly together, where one has more frames."""
    for listing in listings:
        own = {file.number for file in listing.files}
        for other in listings:
            theirs = {file.number for file in other.files}
            beyond = sorted(number for number in theirs if not min(own) <= number <= max(own))
            if (
                other is not listing
                and own & theirs
                and 0 < len(beyond) <= max(1, len(own) // NEARLY_TOGETHER)
            ):
                listing.elsewhere[other.pattern] = beyond


def _matching(path: Path, place: re.Match[str], expected: tuple[int, ...] | None) -> Listing:
    before, after = path.name[: place.start()], path.name[place.end() :]
    names = _names(path.parent)
    found = [(entry, _number_between(entry.name, before, after)) for entry in names]
    files = [Named(int(number), number.lstrip("-"), entry) for entry, number in found if number is not None]
    if not files:
        raise SequenceError(f"no file matches {path}", False)
    leftovers = [
        entry for entry in names if entry.name.endswith(PART_SUFFIX) and entry.name.startswith(f".{before}")
    ]
    listing = _listing(path.parent, (before, after), files, expected, leftovers)
    listing.digits = _digits(place)
    return listing


def _number_between(name: str, before: str, after: str) -> str | None:
    """Number in a name between the text of a pattern, if that is all there is."""
    if len(name) < len(before) + len(after) or not (name.startswith(before) and name.endswith(after)):
        return None
    number = name[len(before) : len(name) - len(after)]
    return number if re.fullmatch(r"-?\d{1,18}", number, re.ASCII) else None


def _one_file(path: Path, expected: tuple[int, ...] | None) -> Listing:
    key, file = _named(path)
    return _listing(path.parent, key, [file], expected, [])


def _named(path: Path) -> tuple[tuple[str, str], Named]:
    """Common parts of a file's name and its sequence's, and its number."""
    found: Parts | None = parts(path.name)
    if found is None:
        return (path.name, ""), Named(STILL_NUMBER, "", path)
    return (found.before, found.after), Named(int(found.number), found.digits, path)


def _listing(
    folder: Path, key: tuple[str, str], files: list[Named], expected: Sequence[int] | None, leftovers: list[Path]
) -> Listing:
    before, after = key
    if not files[0].digits:
        return Listing(folder, before, after, 0, files, [STILL_NUMBER], leftovers=leftovers, is_still=True)
    numbers = [file.number for file in files]
    if expected is None:
        # Very distant numbers are an error in a name, not a billion lost frames.
        first, last = min(numbers), max(numbers)
        expected = (
            range(first, last + 1) if last - first < 100 * len(numbers) + 1000 else sorted(set(numbers))
        )
    return Listing(folder, before, after, _usual_digits(files), files, list(expected), leftovers=leftovers)


def _names(folder: Path) -> list[Path]:
    try:
        return sorted(entry for entry in (folder or Path(".")).iterdir() if not entry.is_dir())
    except OSError as error:
        raise SequenceError(f"cannot read the folder {folder}: {error.strerror}", False) from error


def _groups(names: list[Path]) -> dict[tuple[str, str], list[Named]]:
    groups: dict[tuple[str, str], list[Named]] = defaultdict(list)
    for path in names:
        if not path.name.startswith(".") and path.suffix.lower() == ".exr":
            key, file = _named(path)
            groups[key].append(file)
    return groups


def _leftover_of(entry: Path, groups: Iterable[tuple[str, str]]) -> tuple[str, str] | None:
    if not entry.name.endswith(PART_SUFFIX):
        return None
    owners = [key for key in groups if entry.name.startswith(f".{key[0]}")]
    return max(owners, key=lambda key: (len(key[0]), key), default=None)


def _digits(place: re.Match[str]) -> int:
    written = place[1] or place[2] or place[3]
    return int(written[:2]) if written else max(1, place[0].count("#") + place[0].count("@"))


def _usual_digits(files: list[Named]) -> int:
    """Padding that fits most names; longer numbers are no fault."""
    widths = Counter(len(file.digits) for file in files)

    def explained(width: int) -> int:
        return sum(f"{abs(file.number):0{width}d}" == file.digits for file in files)

    return max(widths, key=lambda width: (explained(width), -width))
