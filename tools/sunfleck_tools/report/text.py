"""Report for the terminal: the worst frame of each sequence first, the verdict in the last line."""

from collections import Counter
from collections.abc import Collection

from ..findings import Severity
from ..frame_list import format_frames
from ..validation import Checked, Report
from ..words import printable

MOST_OF_A_KIND = 8
"""Maximum number of printed findings of one check."""


def text_report(report: Report) -> str:
    """Lines, without the last line's end."""
    return "\n".join(printable(line) for checked in report.sequences for line in _lines(checked))


def _lines(checked: Checked) -> list[str]:
    lines: list[str] = []
    seen: Counter[str] = Counter()
    for finding in checked.findings:
        seen[finding.check] += 1
        if seen[finding.check] <= MOST_OF_A_KIND:
            lines.append(finding.line())
    for check, count in seen.items():
        if count > MOST_OF_A_KIND:
            same = (finding.frame for finding in checked.findings if finding.check == check)
            frames = {frame for frame in same if frame is not None}
            lines.append(f"... {count - MOST_OF_A_KIND} more [{check}]{_named(', in all frames ', frames)}")
    return [*lines, verdict(checked)]


def verdict(checked: Checked) -> str:
    """One line: the subject, and the verdict."""
    seen = [] if checked.listing.is_still else [frame.number for frame in checked.frames]
    numbers = _named(", ", seen)
    looked = f"{checked.listing.pattern}: {_counted(len(checked.frames), 'frame')}{numbers}"
    errors = _counted(checked.count(Severity.ERROR), "error")
    warnings = _counted(checked.count(Severity.WARNING), "warning")
    if not checked.findings:
        return f"{looked}: nothing found"
    again = _named("; render again: ", checked.rerender)
    return f"{looked}: {errors}, {warnings}{again}"


def _named(before: str, frames: Collection[int]) -> str:
    return before + format_frames(frames) if frames else ""


def _counted(count: int, what: str) -> str:
    return f"{count} {what}" if count == 1 else f"{count} {what}s"
