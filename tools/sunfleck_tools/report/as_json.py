"""Report as the JSON that validate.schema.json describes."""

import json
import math

from ..findings import CHECKS, Finding, Severity
from ..frame_list import format_frames
from ..summary import FrameSummary
from ..validation import Checked, Report

FORMAT_VERSION = 1


def json_report(report: Report) -> str:
    """Report as JSON text; numbers that JSON cannot represent are null."""
    return json.dumps(as_object(report), indent=1, allow_nan=False)


def as_object(report: Report) -> dict:
    """Report as dictionaries and lists."""
    return {
        "format_version": FORMAT_VERSION,
        "sequence": _sequence(report.sequences[0]),
        "sequences": [_sequence(checked) for checked in report.sequences],
        "errors": report.count(Severity.ERROR),
        "warnings": report.count(Severity.WARNING),
        "findings": [_finding(finding) for finding in report.findings],
        "frames": [_frame(frame, checked) for checked in report.sequences for frame in checked.frames],
        "checks": [
            {"id": check.id, "severity": check.severity.value, "about": check.about}
            for check in CHECKS.values()
            if check.id not in report.options.skip_checks
        ],
    }


def _sequence(checked: Checked) -> dict:
    return {
        "pattern": checked.listing.pattern,
        "frames": "" if checked.listing.is_still else format_frames(frame.number for frame in checked.frames),
        "missing": format_frames(checked.listing.missing),
        "rerender": format_frames(checked.rerender),
    }


def _finding(finding: Finding) -> dict:
    return {
        "check": finding.check,
        "severity": finding.severity.value,
        "frame": finding.frame,
        "path": finding.path,
        "channel": finding.channel,
        "pixel": None if finding.pixel is None else list(finding.pixel),
        "message": finding.message,
    }


def _frame(frame: FrameSummary, checked: Checked) -> dict:
    return {
        "frame": None if checked.listing.is_still else frame.number,
        "path": frame.path,
        "bytes": frame.bytes,
        "pixel_hash": frame.hash,
        "mean": _number(frame.mean),
        "p99": _number(frame.p99),
        "largest": _number(frame.largest),
        "render_seconds": _number(frame.render_seconds),
        "relative_mse": _number(frame.relmse),
        "flip": _number(frame.flip),
    }


def _number(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None
