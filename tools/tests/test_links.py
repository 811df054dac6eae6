"""Links between documents, and from comments to documents, lead somewhere."""

from __future__ import annotations

import re
import subprocess
import unittest
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LINK = re.compile(r"\]\(([^)\s]+)\)")
NAMED = re.compile(r"\bdocs/[\w/-]+\.md(?:#[\w-]+(?:\.[\w-]+)*)?")
"""A document in a comment."""
CODE = re.compile(r"^```.*?^```|`[^`\n]*`", re.DOTALL | re.MULTILINE)


def committed(*endings: str) -> list[Path]:
    """Files that git knows, or could."""
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard"]
    listed = subprocess.check_output(command, cwd=ROOT, text=True).splitlines()
    paths = [ROOT / line for line in listed if line.endswith(endings)]
    return [path for path in paths if path.is_file()]


@cache
def anchors(page: Path) -> set[str]:
    """Of headings, as GitHub makes them, and those that are set by hand."""
    text = page.read_text(encoding="utf-8")
    headings = re.findall(r"(?m)^#+ (.*)", re.sub(r"(?ms)^```.*?^```", "", text))
    plain = [re.sub(r"<[^>]*>|\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower().strip() for heading in headings]
    made = {re.sub(r"[^\w -]", "", heading).replace(" ", "-") for heading in plain}
    return made | set(re.findall(r'<a (?:id|name)="([^"]+)"', text))


def leads_nowhere(folder: Path, target: str, page: Path) -> bool:
    """Whether a link of a page has no file, or its file no such anchor."""
    name, _, anchor = target.partition("#")
    path = (folder / name).resolve() if name else page
    return not path.exists() or bool(anchor and path.suffix == ".md" and anchor not in anchors(path))


@unittest.skipUnless((ROOT / ".git").exists(), "git says which files are the project's")
class Links(unittest.TestCase):
    """What is committed."""

    def test_links_of_documents(self):
        for page in committed(".md"):
            with self.subTest(page.relative_to(ROOT)):
                targets = LINK.findall(CODE.sub("", page.read_text(encoding="utf-8")))
                own = [target for target in targets if not re.match(r"https?:|mailto:", target)]
                self.assertEqual([target for target in own if leads_nowhere(page.parent, target, page)], [])

    def test_documents_that_comments_name(self):
        for page in committed(".rs", ".py", ".toml"):
            named = NAMED.findall(page.read_text(encoding="utf-8"))
            with self.subTest(page.relative_to(ROOT)):
                self.assertEqual([target for target in named if leads_nowhere(ROOT, target, page)], [])

    def test_what_is_not_there_is_found(self):
        page = ROOT / "docs/figures.md"
        self.assertTrue(leads_nowhere(page.parent, "no_such.md", page))
        self.assertTrue(leads_nowhere(page.parent, "figures.md#no-such-row", page))
        self.assertTrue(leads_nowhere(page.parent, "#no-such-row", page))
        self.assertFalse(leads_nowhere(page.parent, "figures.md#title-frame", page))
        self.assertFalse(leads_nowhere(page.parent, "#how-time-grows", page))


if __name__ == "__main__":
    unittest.main()
