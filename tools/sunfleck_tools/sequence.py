"""Names to frames: a folder or pattern to the numbered files of one sequence.

Invariant: every EXR file of the folder is either a frame of the listing or named in `strangers`.
"""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from dataclasses import dataclass, field
from pathlib import Path

from .errors import ToolError

PLACE = re.compile(r"#+|%(\d*)d|\$F(\d*)")
# A minus is a sign at the beginning and behind `.` or `_`; elsewhere (`take-0007.exr`) it is a dash.
NUMBERED = re.compile(r"(?P<before>.*?)(?P<number>(?:(?:(?<=[._])|^)-)?\d+)(?P<after>\.exr)", re.IGNORECASE)
PART_SUFFIX = ".sunfleck-part"


class SequenceError(ToolError):
    """There are no frames to look at."""


@dataclass(frozen=True)
class Named:
    """A file and the number in its name."""

    number: int
    digits: str
    path: Path


@dataclass
class Listing:
    """The files of one sequence, by their names alone."""

    folder: Path
    before: str
    after: str
    digits: int
    files: list[Named]
    expected: list[int]
    strangers: list[Path] = field(default_factory=list)
    leftovers: list[Path] = field(default_factory=list)

    @property
    def pattern(self) -> str:
        """The sequence as `--out` would name it."""
        return str(self.folder / f"{self.before}{'#' * self.digits}{self.after}")

    def name_of(self, number: int) -> str:
        """The name that frame `number` should have."""
        return f"{self.before}{'-' if number < 0 else ''}{abs(number):0{self.digits}d}{self.after}"

    @property
    def frames(self) -> list[Named]:
        """One file a frame, ascending; of several the one that is named right."""
        chosen: dict[int, Named] = {}
        for file in sorted(self.files, key=lambda f: (f.number, f.path.name != self.name_of(f.number), f.path.name)):
            chosen.setdefault(file.number, file)
        return list(chosen.values())

    @property
    def missing(self) -> list[int]:
        """Expected frames without a file."""
        found = {file.number for file in self.files}
        return [number for number in self.expected if number not in found]


def list_sequence(target: str | Path, expected: tuple[int, ...] | None = None) -> Listing:
    """Finds the frames of `target`: a folder, a pattern such as `out/x.####.exr`, or one file.

    Raises `SequenceError` if there is nothing to validate.
    """
    path = Path(target)
    place = list(PLACE.finditer(path.name))
    if path.is_dir():
        folder, wanted = path, None
    elif len(place) == 1:
        at = place[0]
        folder, wanted = path.parent, (path.name[: at.start()], path.name[at.end() :])
    elif path.is_file() and (match := NUMBERED.fullmatch(path.name)):
        return _one_file(path, match, expected)
    elif not path.exists():
        raise SequenceError(f"there is no {target}: expected a folder, or a pattern such as out/name.####.exr", False)
    else:
        raise SequenceError(f"{target} has no place for the frame's number: expected a folder or out/name.####.exr")
    try:
        names = sorted(entry for entry in folder.iterdir() if not entry.is_dir())
    except OSError as error:
        raise SequenceError(f"cannot read the folder {folder}: {error.strerror}", False) from error
    groups, strangers = _groups(names)
    if not groups:
        raise SequenceError(f"{folder} holds no numbered EXR files, such as name.0001.exr", False)
    if wanted is None:
        wanted = max(groups, key=lambda key: (len(groups[key]), key))
        strangers += [file.path for key, files in groups.items() if key != wanted for file in files]
    else:
        # A pattern names its files; what else is in the folder is not asked about.
        strangers = []
    files = groups.get(wanted, [])
    if not files:
        raise SequenceError(f"no file matches {target}", False)
    leftovers = [entry for entry in names if entry.name.endswith(PART_SUFFIX) and entry.name.startswith(f".{wanted[0]}")]
    digits = _digits(place[0]) if place and not path.is_dir() else _usual_digits(files)
    return _listing(folder, wanted, digits, files, expected, sorted(strangers), leftovers)


def _one_file(path: Path, match: re.Match[str], expected: tuple[int, ...] | None) -> Listing:
    file = Named(int(match["number"]), match["number"].lstrip("-"), path)
    return _listing(path.parent, (match["before"], match["after"]), len(file.digits), [file], expected, [], [])


def _listing(folder, wanted, digits, files, expected, strangers, leftovers) -> Listing:
    numbers = [file.number for file in files]
    if expected is None:
        # Numbers far apart are a slip in a name, not a billion lost frames.
        first, last = min(numbers), max(numbers)
        expected = range(first, last + 1) if last - first < 100 * len(numbers) + 1000 else sorted(set(numbers))
    return Listing(folder, wanted[0], wanted[1], digits, files, list(expected), strangers, leftovers)


def _groups(names: list[Path]) -> tuple[dict[tuple[str, str], list[Named]], list[Path]]:
    groups: dict[tuple[str, str], list[Named]] = defaultdict(list)
    strangers = []
    for path in names:
        if path.name.startswith(".") or path.suffix.lower() != ".exr":
            continue
        match = NUMBERED.fullmatch(path.name)
        if match is None:
            strangers.append(path)
            continue
        digits = match["number"].lstrip("-")
        groups[match["before"], match["after"]].append(Named(int(match["number"]), digits, path))
    return groups, strangers


def _digits(place: re.Match[str]) -> int:
    written = place[1] or place[2]
    return int(written) if written else max(1, place[0].count("#"))


def _usual_digits(files: list[Named]) -> int:
    """The padding that explains most names; longer numbers than it explains are no fault."""
    widths = Counter(len(file.digits) for file in files)

    def explained(width: int) -> int:
        return sum(f"{abs(file.number):0{width}d}" == file.digits for file in files)

    return max(widths, key=lambda width: (explained(width), -width))
