"""`tools/words`: known texts give known counts."""

import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

PROGRAM = Path(__file__).parents[1] / "words"

MARKDOWN = """---
title: Not read, however long it may be.
---
# A heading is no sentence

One two three. `sunfleck render x.ron --frames 1-2` is five words here!
Is [a link](with/a/very/long/target.md) four words?
Words such as e.g. these end nothing, nor does 1.5: this has fourteen words.

    an indented block is code and has no words at all

- an item of a list
- another, which goes on
  in the next line. And a third.

| a table | is not read |
|---|---|

```sh
nor is. this. one
```
<p>HTML</p> counts by its text. ![no picture](a.png)
"""
LENGTHS = [3, 5, 5, 14, 5, 8, 3, 5]


def counts(name: str, text: str) -> tuple[int, list[str]]:
    """Exit code of `tools/words` and the columns that it prints for a file of that name."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        path.write_text(text, encoding="utf-8")
        done = subprocess.run([sys.executable, PROGRAM, path], capture_output=True, text=True, check=False)
    return done.returncode, done.stdout.split()


class Words(unittest.TestCase):
    def test_markdown(self) -> None:
        code, (mean, longest, sentences, *_) = counts("page.md", MARKDOWN)
        self.assertEqual(code, 0)
        self.assertEqual((int(longest), int(sentences)), (max(LENGTHS), len(LENGTHS)))
        self.assertEqual(float(mean), round(sum(LENGTHS) / len(LENGTHS), 1))

    def test_heads_of_modules(self) -> None:
        rust = "//! One sentence of\n//! just six words. Two words.\n\n/// Not this one, of an item.\nfn item() {}\n"
        self.assertEqual(counts("head.rs", rust)[1][:3], ["4.0", "6", "2"])
        python = '"""Four words stand here."""\n\n\ndef item():\n    """Not this one."""\n'
        self.assertEqual(counts("head.py", python)[1][:3], ["4.0", "4", "1"])
        self.assertEqual(counts("none.py", "pass\n"), (0, []))

    def test_limits(self) -> None:
        for lengths, code in (([20], 0), ([21], 1), ([50, 10], 1), ([50, 1, 1], 0), ([51, 1, 1, 1], 1)):
            text = " ".join("word " * (length - 1) + "word." for length in lengths)
            self.assertEqual(counts("page.md", text)[0], code, lengths)


if __name__ == "__main__":
    unittest.main()
