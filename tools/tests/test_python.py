"""The packages are of the lowest Python that they say, and extras and lock agree."""

import ast
import re
import unittest
from pathlib import Path

TOOLS = Path(__file__).parents[1]
PROJECT = (TOOLS.parent / "pyproject.toml").read_text()
LOWEST = tuple(map(int, re.search(r'requires-python = ">=(\d+)\.(\d+)"', PROJECT).groups()))


class Sources(unittest.TestCase):
    def test_are_grammar_of_the_lowest_python(self):
        sources = [path for folder in ("sunfleck", "sunfleck_tools", "tests") for path in (TOOLS / folder).rglob("*.py")]
        self.assertGreater(len(sources), 100)
        for path in sources:
            # Raises SyntaxError with the place.
            ast.parse(path.read_text(), str(path), feature_version=LOWEST)
        with self.assertRaises(SyntaxError):
            ast.parse("type Pixel = int", feature_version=LOWEST)

    def test_the_lock_has_what_the_package_needs(self):
        locked = set(re.findall(r"^([\w-]+)==", (TOOLS / "requirements.lock").read_text(), re.MULTILINE))
        listed = re.findall(r"^(?:dependencies|usd|pictures|flip) = \[(.*)\]$", PROJECT, re.MULTILINE)
        needed = set(re.findall(r'"([\w-]+)>=', "".join(listed)))
        self.assertEqual(needed, {"numpy", "OpenEXR", "usd-core", "pillow", "flip-evaluator"})
        self.assertLessEqual(needed, locked)
