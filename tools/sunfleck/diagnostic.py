"""Parser of the program's standard error. In go lines, out come diagnostics.

Invariant: the texts of all diagnostics together are the whole output.
"""

import re
from dataclasses import dataclass

SEVERITY = re.compile(r"(?:(?P<place>.+?): )?(?P<severity>error|warning|note)(?:\[(?P<id>[\w-]+)\])?: (?P<message>.*)")
FIELD = re.compile(r"\s+(?P<field>expected|remedy|tip): (?P<value>.*)")
"""`tip` is what the parser of command lines calls a remedy."""


@dataclass(frozen=True)
class Diagnostic:
    """One diagnostic."""

    severity: str
    """`error`, `warning`, `note`; `line` of what is none of these."""
    message: str
    """What was found."""
    place: str = ""
    """The file and the place in it; empty where there is none."""
    expected: str = ""
    remedy: str = ""
    id: str = ""
    """The kind of loss, as docs/losses.md lists them."""
    text: str = ""
    """As the program said it."""


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
