"""`tools/in_turns`: which scene two builds in turns are given."""

import contextlib
import os
import tempfile
import unittest
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path

ROOT = Path(__file__).parents[2]
LOADER = SourceFileLoader("in_turns", str(ROOT / "tools/in_turns"))


@contextlib.contextmanager
def working_in(folder: Path):
    before = os.getcwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


class Scenes(unittest.TestCase):
    def test_the_callers_come_first_and_each_checkout_has_its_own(self):
        spec = spec_from_loader(LOADER.name, LOADER)
        in_turns = module_from_spec(spec)
        LOADER.exec_module(in_turns)
        with tempfile.TemporaryDirectory() as folder, working_in(Path(folder)):
            Path("my.ron").touch()
            self.assertEqual(in_turns.scene("my.ron"), str(Path.cwd() / "my.ron"))
            self.assertEqual(in_turns.scene("title"), "sequences/title.ron")
            self.assertEqual(in_turns.scene("sequences/title.ron"), "sequences/title.ron")
        with working_in(ROOT / "sequences"):
            self.assertEqual(in_turns.scene("title.ron"), "sequences/title.ron")


if __name__ == "__main__":
    unittest.main()
