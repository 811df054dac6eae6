"""`tools/links`: links that lead nowhere are named, others are not."""

import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

PROGRAM = Path(__file__).parents[1] / "links"
PAGE = """# A page

[well](other.md), [well](other.md#a-heading-code-and-all), [well](#a-page), [well](https://nowhere.invalid/).
[well](other.md#named), `[code](is/no/link.md)`, [well](other.md#twice-1).

```md
[code](is/no/link.md)
```

[a file](missing.md), [a heading](other.md#missing), ![a picture](missing.png), `render.rs`, `no/such/render.rs`,
`Path::follow`, `optical_depth`, `Path::GONE`, `depth_GONE`

What lost: `draco_decoder`
"""
OTHER = """# A heading: `code`, and all

<a id="named"></a>

## Twice

## Twice
"""


class Links(unittest.TestCase):
    def test_what_leads_nowhere_is_named(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            page = Path(folder, "page.md")
            # Put together here, or this file would be a source that has the name.
            gone = "x".join("abc")
            page.write_text(PAGE.replace("GONE", gone), encoding="utf-8")
            Path(folder, "other.md").write_text(OTHER, encoding="utf-8")
            command = [sys.executable, PROGRAM, page]
            done = subprocess.run(command, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 1)
        faults = [line.split(".md:", 1)[1] for line in done.stdout.splitlines()]
        missing = ["there is no missing.md", "other.md has no #missing", "there is no missing.png"]
        missing.append("there is no source file no/such/render.rs")
        unknown = [f"11: no source has {name}{gone}" for name in ("Path::", "depth_")]
        self.assertEqual(faults, [f"10: {fault}" for fault in missing] + unknown)


if __name__ == "__main__":
    unittest.main()
