"""A report for the terminal: the worst frame in the first line, the verdict in the last."""

from __future__ import annotations

from collections import Counter

from ..findings import Severity
from ..frame_list import format_frames
from ..validation import Report

MOST_OF_A_KIND = 8
"""Findings of one check that are printed before the rest is counted."""


def text_report(report: Report) -> str:
    """Lines, without the last line's end."""
    lines, seen = [], Counter()
    for finding in report.findings:
        seen[finding.check] += 1
        if seen[finding.check] <= MOST_OF_A_KIND:
            lines.append(finding.line())
    for check, count in seen.items():
        if count > MOST_OF_A_KIND:
            frames = {finding.frame for finding in report.findings if finding.check == check and finding.frame is not None}
            lines.append(f"... {count - MOST_OF_A_KIND} more [{check}], in all frames {format_frames(frames)}")
    lines.append(verdict(report))
    return "\n".join(lines)


def verdict(report: Report) -> str:
    """One line: what was looked at, and how it is."""
    numbers = format_frames(frame.number for frame in report.frames)
    plural = "" if len(report.frames) == 1 else "s"
    looked = f"{report.listing.pattern}: {len(report.frames)} frame{plural}, {numbers}"
    errors, warnings = (report.count(severity) for severity in (Severity.ERROR, Severity.WARNING))
    if not report.findings:
        return f"{looked}: nothing found"
    again = f"; render again: {format_frames(report.rerender)}" if report.rerender else ""
    return f"{looked}: {errors} errors, {warnings} warnings{again}"
