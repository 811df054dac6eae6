"""Report as a self-contained page: contact sheet, curves, findings linked to their frames.

Invariant: names and messages are always text of the page, never markup.
"""

import base64
from html import escape

import numpy as np

from ..findings import Finding
from ..summary import FrameSummary
from ..validation import Checked, Report
from ..words import printable
from .curves import curve
from .png import png
from .text import verdict

STYLE = """
body { font: 14px/1.4 system-ui, sans-serif; margin: 2em auto; max-width: 76em; padding: 0 1em; color: #222; background: #fff }
h1 { font-size: 1.4em } h2 { font-size: 1.1em; margin-top: 2em }
table { border-collapse: collapse } th, td { text-align: left; padding: 2px 12px 2px 0; vertical-align: top }
.error { color: #b00020 } .warning { color: #8a5a00 }
.sheet { display: flex; flex-wrap: wrap; gap: 6px }
figure { margin: 0; padding: 3px; border: 2px solid transparent } figure.error { border-color: #b00020 }
figure.warning { border-color: #e0a000 } figure:target { background: #ffec99 }
figure img, figure .none { display: block; width: 96px; min-height: 12px } figcaption { font-size: 11px; text-align: center }
.none { background: repeating-linear-gradient(45deg, #ddd 0 6px, #fff 6px 12px); height: 54px }
svg { display: block; width: 100%; height: 130px } svg text { font-size: 11px; fill: #555 }
polyline { fill: none; stroke: #2a6f97; stroke-width: 1.5; vector-effect: non-scaling-stroke } circle { fill: #b00020 }
"""


def html_report(report: Report) -> str:
    """The page."""
    title = _text(", ".join(checked.listing.pattern for checked in report.sequences))
    sections = "".join(_sequence(checked, number) for number, checked in enumerate(report.sequences, 1))
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{title}</title>'
        f'<meta name="viewport" '
        f'content="width=device-width"><style>{STYLE}</style></head>\n<body>{sections}</body></html>\n'
    )


def _sequence(checked: Checked, number: int) -> str:
    """Section of a sequence; `number` makes its links unique."""
    anchor = "frame" if number == 1 else f"sequence-{number}-frame"
    worst = _worst(checked)
    curves = "".join(
        curve(title, [(frame.number, value(frame)) for frame in checked.frames], worst, anchor)
        for title, value in (
            ("Mean luminance", lambda frame: frame.mean),
            ("99th percentile of luminance", lambda frame: frame.p99),
            ("File size, bytes", lambda frame: frame.bytes),
            ("Render time, seconds", lambda frame: frame.render_seconds),
        )
    )
    rows = "".join(_row(finding, anchor) for finding in checked.findings)
    table = f"<table><thead><tr><th>Severity</th><th>Frame</th><th>Check</th><th>What</th></tr></thead><tbody>{rows}</tbody></table>"
    listing = checked.listing
    missing = [FrameSummary(number, listing.name_of(number)) for number in listing.missing[:MOST_MISSING]]
    gain = _gain(checked.frames)
    frames = sorted([*checked.frames, *missing], key=lambda frame: frame.number)
    cells = "".join(_cell(frame, gain, worst, anchor) for frame in frames)
    return (
        f"<h1>{_text(listing.pattern)}</h1><p>{_text(verdict(checked))}</p>\n"
        f"<h2>Findings</h2>{table if rows else '<p>None.</p>'}\n"
        f"<h2>Curves</h2>{curves}\n"
        f'<h2>Frames</h2><div class="sheet">{cells}</div>\n'
    )


def _text(text: str) -> str:
    """Escaped text, without characters that text cannot have."""
    return escape(printable(text))


MOST_MISSING = 1000
"""Maximum number of missing frames in the contact sheet."""


def _worst(checked: Checked) -> dict[int, str]:
    """Severity of the worst finding of each frame that has one."""
    worst: dict[int, str] = {}
    for finding in checked.findings:
        if finding.frame is not None:
            worst.setdefault(finding.frame, finding.severity.value)
    return worst


def _row(finding: Finding, anchor: str) -> str:
    severity = finding.severity.value
    frame = "" if finding.frame is None else f'<a href="#{anchor}-{finding.frame}">{finding.frame}</a>'
    return (
        f'<tr><td class="{severity}">{severity}</td><td>{frame}</td><td>{escape(finding.check)}</td>'
        f"<td>{_text(finding.message)}</td></tr>"
    )


def _gain(frames: list[FrameSummary]) -> float:
    """One exposure for the whole sheet, so that flicker shows: the usual 99th percentile becomes white."""
    levels = [frame.p99 for frame in frames if frame.p99]
    return 1.0 / float(np.median(levels)) if levels else 1.0


def _cell(frame: FrameSummary, gain: float, worst: dict[int, str], anchor: str) -> str:
    severity = worst.get(frame.number, "")
    if frame.thumbnail is None:
        picture = '<div class="none"></div>'
    else:
        data = base64.b64encode(png(frame.thumbnail * np.float32(gain))).decode()
        picture = f'<img alt="frame {frame.number}" src="data:image/png;base64,{data}">'
    return (
        f'<figure id="{anchor}-{frame.number}" class="{severity}" title="{_text(frame.path)}">{picture}'
        f"<figcaption>{frame.number}</figcaption></figure>"
    )
