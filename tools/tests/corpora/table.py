"""Verdicts in, texts out: a table of counts, what is refused by its reason, and what must not be."""

from collections import Counter, defaultdict
from collections.abc import Sequence

from .outcomes import Outcome, group_of
from .probes import Verdict

INVALID = "{kind}, invalid"
LARGEST_SHOWN = 5
"""Files that are named of those that take most."""


def as_json(verdicts: Sequence[Verdict]) -> list[dict[str, object]]:
    """A row a file, in their order."""
    return [
        {
            "file": verdict.file.name,
            "kind": verdict.file.kind,
            "invalid": verdict.file.is_invalid,
            "outcome": verdict.outcome.value,
            "step": verdict.step,
            "sentence": verdict.sentence,
            "refused_by": list(verdict.refused_by),
            "losses": list(verdict.losses),
            "mean": verdict.mean,
            "cpu_s": round(verdict.cpu_s, 2),
            "peak_mb": verdict.peak_bytes >> 20,
        }
        for verdict in verdicts
    ]


def as_text(verdicts: Sequence[Verdict]) -> str:
    """All of it, for eyes."""
    parts = [_counts(verdicts), _refused(verdicts), _faults(verdicts), _most(verdicts)]
    return "\n\n".join(part for part in parts if part) + "\n"


def _row_of(verdict: Verdict) -> str:
    kind = verdict.file.kind
    return INVALID.format(kind=kind) if verdict.file.is_invalid else kind


def _counts(verdicts: Sequence[Verdict]) -> str:
    """A row a kind, a column an outcome that there is."""
    counts: dict[str, Counter[Outcome]] = defaultdict(Counter)
    for verdict in verdicts:
        counts[_row_of(verdict)][verdict.outcome] += 1
    outcomes = [outcome for outcome in Outcome if any(count[outcome] for count in counts.values())]
    rows = [["", "files", *(outcome.value for outcome in outcomes)]]
    for kind, count in sorted(counts.items()):
        rows.append([kind, str(count.total()), *(str(count[outcome]) for outcome in outcomes)])
    widths = [max(map(len, column)) for column in zip(*rows)]
    return "\n".join("  ".join(cell.rjust(width) for cell, width in zip(row, widths)) for row in rows)


def _refused(verdicts: Sequence[Verdict]) -> str:
    """By kind, step and reason, the most frequent first, each with the first file as an example."""
    groups: dict[tuple[str, str, str], list[Verdict]] = defaultdict(list)
    for verdict in verdicts:
        if verdict.outcome is Outcome.REFUSED:
            groups[_row_of(verdict), verdict.step, group_of(verdict.sentence)].append(verdict)
    lines = ["refused:"] if groups else []
    for (kind, step, sentence), members in sorted(
        groups.items(), key=lambda group: (-len(group[1]), group[0])
    ):
        lines += [f"{len(members):5}  {kind}, {step}: {sentence}", f"       such as {members[0].file.name}"]
    return "\n".join(lines)


def _faults(verdicts: Sequence[Verdict]) -> str:
    """Each file on a line."""
    faults = [verdict for verdict in verdicts if verdict.outcome.is_fault]
    lines = ["faults of the program:"] if faults else []
    for verdict in sorted(faults, key=lambda verdict: verdict.outcome.value):
        mean = "" if verdict.mean is None else f"mean {verdict.mean:.3g}"
        step = verdict.step if verdict.mean is None else ""
        lines.append(
            "  ".join(
                part
                for part in (verdict.outcome.value, verdict.file.name, step, mean, verdict.sentence)
                if part
            )
        )
    return "\n".join(lines)


def _most(verdicts: Sequence[Verdict]) -> str:
    """The files that took most time and memory."""
    if not verdicts:
        return "no files of these kinds"
    slowest = sorted(verdicts, key=lambda verdict: -verdict.cpu_s)[:LARGEST_SHOWN]
    largest = sorted(verdicts, key=lambda verdict: -verdict.peak_bytes)[:LARGEST_SHOWN]
    lines = [
        "most processor seconds:",
        *(f"{verdict.cpu_s:8.1f} s   {verdict.file.name}" for verdict in slowest),
    ]
    lines += [
        "most memory:",
        *(f"{verdict.peak_bytes >> 20:8} MB  {verdict.file.name}" for verdict in largest),
    ]
    return "\n".join(lines)
