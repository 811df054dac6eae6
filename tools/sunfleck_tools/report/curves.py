"""Values over frames as an SVG."""

import math
from html import escape

WIDTH, HEIGHT, LEFT, TOP = 1000, 130, 70, 20
MOST_DOTS = 500


def curve(
    title: str, points: list[tuple[int, float | None]], marked: dict[int, str], anchor: str = "frame"
) -> str:
    """Titled polyline, interrupted at missing values; dots mark frames with findings. Empty without
    values."""
    known = [(frame, value) for frame, value in points if value is not None and math.isfinite(value)]
    if not known:
        return ""
    first, last = min(frame for frame, _ in points), max(frame for frame, _ in points)
    top = max(value for _, value in known) or 1.0

    def place(frame: int, value: float) -> str:
        x = LEFT + (WIDTH - LEFT - 10) * (frame - first) / max(1, last - first)
        y = HEIGHT - 20 - (HEIGHT - 20 - TOP) * value / top
        return f"{x:.1f},{y:.1f}"

    known_frames = dict(known)
    runs: list[list[str]] = []
    before = None
    for frame, value in known:
        if before is None or frame != before + 1:
            runs.append([])
        runs[-1].append(place(frame, value))
        before = frame
    lines = "".join(f'<polyline points="{" ".join(run)}"/>' for run in runs)
    dots = ""
    for frame in [frame for frame in marked if frame in known_frames][:MOST_DOTS]:
        x, y = place(frame, known_frames[frame]).split(",")
        dots += f'<a href="#{anchor}-{frame}"><circle cx="{x}" cy="{y}" r="4"><title>frame {frame}</title></circle></a>'
    return (
        f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{escape(title)}">'
        f'<text x="0" y="12">{escape(title)}</text><text x="0" y="{TOP + 12}">{top:.4g}</text>'
        f'<text x="0" y="{HEIGHT - 20}">0</text><text x="{LEFT}" y="{HEIGHT - 4}">{first}</text>'
        f'<text x="{WIDTH - 10}" y="{HEIGHT - 4}" text-anchor="end">{last}</text>{lines}{dots}</svg>'
    )
