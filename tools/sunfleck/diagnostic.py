"""Parser of the program's standard error. In go lines, out come diagnostics.

Invariant: the texts of all diagnostics together are the whole output.
"""

import re
from dataclasses import dataclass

SEVERITY = re.compile(r"(?:(?P<place>.+?): )?(?P<severity>error|warning|note)(?:\[(?P<id>[\w-]+)\])?: (?P<message>.*)")
FIELD = re.compile(r"\s+(?P<field>expected|remedy|tip): (?P<value>.*)")
"""`tip` is the command line parser's word for a remedy."""


@dataclass(frozen=True)
class Diagnostic:
    """One diagnostic."""

    severity: str
    """`error`, `warning`, `note`; `line` for any other line."""
    message: str
    """Finding."""
    place: str = ""
    """File and place in it; empty without one."""
    expected: str = ""
    remedy: str = ""
    id: str = ""
    """Id of the loss, as in docs/losses.md."""
    text: str = ""
    """Text as the program printed it."""


def diagnostics(said: str) -> tuple[Diagnostic, ...]:
    """Diagnostics in the order of output. Each goes on until the next line that begins one."""
    blocks: list[list[str]] = []
    for line in said.splitlines():
        if not blocks or SEVERITY.fullmatch(line):
            blocks.append([])
        blocks[-1].append(line)
    return tuple(_diagnostic(block) for block in blocks)


def _diagnostic(lines: list[str]) -> Diagnostic:
    text = "\n".join(lines).strip()
    begun = SEVERITY.fullmatch(lines[0])
    if begun is None:
        return Diagnostic("line", text, text=text)
    fields = {match["field"]: match["value"] for match in map(FIELD.fullmatch, lines[1:]) if match}
    return Diagnostic(
        begun["severity"], begun["message"], begun["place"] or "", fields.get("expected", ""),
        fields.get("remedy") or fields.get("tip", ""), begun["id"] or "", text,
    )  # fmt: skip
