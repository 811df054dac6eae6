"""One file: the extension that tools/blender/build makes, installed in a Blender that knows nothing of it."""

import os
import shutil
import subprocess
import sys
import tempfile
import unittest
import zipfile
from pathlib import Path

import bpy  # noqa: F401 (finds Blender's own modules)

import addon_utils  # isort: skip

BUILD = Path(__file__).parents[1] / "build"
PROGRAM = shutil.which(os.environ.get("SUNFLECK", "sunfleck"))
# From nothing to the first frame: install the zip, choose the engine, render.
FIRST_FRAME = """
import sys, bpy
bpy.ops.extensions.package_install_files(filepath=sys.argv[1], repo="user_default", enable_on_install=True)
render = bpy.context.scene.render
render.engine = "SUNFLECK"
render.resolution_x, render.resolution_y, render.resolution_percentage = 32, 18, 100
render.image_settings.file_format, render.filepath = "OPEN_EXR", sys.argv[2]
bpy.context.scene.sunfleck_settings.bounces = 0
print(bpy.ops.render.render(write_still=True))
from bl_ext.user_default.sunfleck import command, program
print("program", program.find())
print("tools", command.main(["tools", "--version"]))
"""


class Extension(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        command = [sys.executable, str(BUILD), "--program", PROGRAM, "--out", str(cls.folder), "--no-wheels"]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        cls.zip = Path(done.stdout.strip())

    def test_blenders_own_tool_finds_nothing_wrong(self):
        cli = next(Path(folder, "bl_pkg/cli/blender_ext.py") for folder in addon_utils.paths() if Path(folder, "bl_pkg").is_dir())
        done = subprocess.run([sys.executable, str(cli), "validate", str(self.zip)], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_the_same_input_gives_the_same_bytes(self):
        again = self.folder / "again"
        command = [sys.executable, str(BUILD), "--program", PROGRAM, "--out", str(again), "--no-wheels"]
        subprocess.run(command, capture_output=True, check=True)
        self.assertEqual((again / self.zip.name).read_bytes(), self.zip.read_bytes())

    def test_the_program_can_be_run_and_sources_are_all_there(self):
        with zipfile.ZipFile(self.zip) as archive:
            self.assertEqual(archive.getinfo("bin/sunfleck").external_attr >> 16, 0o100755)
            self.assertLessEqual({"__init__.py", "engine/__init__.py", "tools/sunfleck_tools/cli.py"}, set(archive.namelist()))

    def test_from_nothing_to_the_first_frame(self):
        profile, frame = self.folder / "profile", self.folder / "first.exr"
        surroundings = {name: value for name, value in os.environ.items() if name not in {"SUNFLECK", "PYTHONPATH"}}
        surroundings |= {"BLENDER_USER_RESOURCES": str(profile), "PATH": "/usr/bin:/bin"}
        done = subprocess.run(
            [sys.executable, "-c", FIRST_FRAME, str(self.zip), str(frame)],
            env=surroundings, capture_output=True, text=True, cwd=self.folder,
        )  # fmt: skip
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("{'FINISHED'}", done.stdout)
        self.assertTrue(frame.is_file())
        self.assertIn("tools 0", done.stdout)
        program = next(line for line in done.stdout.splitlines() if line.startswith("program "))
        self.assertTrue(program.split(" ", 1)[1].startswith(str(profile)), program)


if __name__ == "__main__":
    unittest.main()
