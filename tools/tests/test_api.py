"""`import sunfleck`: frames as arrays, and what is said of them."""

import io
import os
import re
import subprocess
import sys
import tempfile
import threading
import unittest
import warnings
from fractions import Fraction
from pathlib import Path
from unittest import mock

import numpy as np

import sunfleck
import sunfleck_tools
from sunfleck.passes import PASSES, held
from sunfleck.progress import EventBar
from sunfleck_tools.exr.decode import decode

from .command import NO_PROGRAM, PROGRAM, SEQUENCES, run
from .files import write_frame

ROOT = Path(__file__).parents[2]
FIRST_LEAF = SEQUENCES / "first_leaf.ron"
SIZE = (48, 27)
DARK = """Scene(version: 1, meshes: { "quad": Quad(size_m: 1.0) }, materials: { "grey": (base_color: 0.5) },
    objects: { "quad": (mesh: "quad", material: "grey") },
    cameras: { "main": (position_m: (0.0, 1.0, 3.0), look_at_m: (0.0, 0.0, 0.0), fov_deg: 40.0) })"""


class WithFolder(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = Path(scratch.name)
        # What is there for the time being goes here too, so that tests see it.
        self.temporary = self.folder / "temporary"
        self.temporary.mkdir()
        for patch in (mock.patch.object(tempfile, "tempdir", str(self.temporary)),):
            patch.start()
            self.addCleanup(patch.stop)


class Tables(unittest.TestCase):
    def test_passes_are_those_of_the_program(self):
        row = re.compile(r'^    \w+ "([\w-]+)" ".*?" \[(.*?)\] \w+ \w+ \w+ "(.*?)" \S+;$', re.MULTILINE)
        rows = {
            name: (tuple(re.findall(r'"(.*?)"', channels)), unit)
            for name, channels, unit in row.findall((ROOT / "src/passes.rs").read_text())
        }
        self.assertIn("shafts", rows)
        self.assertEqual({name: row for name, row in PASSES.items() if name != "beauty"}, rows)

    def test_versions_are_one(self):
        version = re.search(r'^version = "(.*)"', (ROOT / "Cargo.toml").read_text(), re.MULTILINE)[1]
        self.assertEqual((sunfleck.__version__, sunfleck_tools.__version__), (version, version))
        self.assertEqual(run("--version")[:2], (0, f"sunfleck-tools {version}\n"))

    def test_a_pass_is_held_with_all_its_channels_alone(self):
        matte = [f"CryptoObject{layer:02d}.{component}" for layer in (0, 1) for component in "RGBA"]
        found = held(["A", "B", "G", "R", "Normal.X", "Z", *sorted(matte)])
        self.assertEqual(list(found), ["beauty", "depth", "cryptomatte"])
        self.assertEqual(found["cryptomatte"][0], tuple(matte))
        self.assertEqual(held(["B", "G", "R"])["beauty"][0], ("R", "G", "B"))
        self.assertEqual(held(["B", "R", "A"]), {})

    def test_all_that_is_exported_is_there_and_documented(self):
        for name in sunfleck.__all__:
            self.assertTrue(getattr(sunfleck, name).__doc__, name)
        with self.assertRaises(AttributeError):
            sunfleck.nonsense


@unittest.skipUnless(PROGRAM, NO_PROGRAM)
class Frames(WithFolder):
    def test_every_pass_has_its_shape_and_unit(self):
        frame = sunfleck.render(FIRST_LEAF, frame=12, size=SIZE, passes="all", progress=False)
        self.assertEqual((frame.number, frame.size, frame.window), (12, SIZE, (0, 0, *SIZE)))
        self.assertEqual(list(frame.passes), list(PASSES))
        for name, found in frame.passes.items():
            shape = (27, 48) if len(found.channels) == 1 else (27, 48, len(found.channels))
            self.assertEqual((found.pixels.shape, found.pixels.dtype), (shape, np.float32), name)
            self.assertIs(getattr(frame, name.replace("-", "_")), found.pixels)
        self.assertEqual((frame.passes["depth"].unit, frame.passes["beauty"].unit), ("m", "W m^-2 sr^-1"))
        np.testing.assert_array_equal(frame["Normal.Y"], frame.normal[..., 1])
        # The floor of the scene: a normal upwards, in the camera's reach.
        self.assertAlmostEqual(float(frame.normal[-1, 24, 1]), 1.0, places=4)
        self.assertEqual(list(self.temporary.iterdir()), [])

    def test_pixels_and_metadata_are_those_of_the_command_line(self):
        path = self.folder / "x.exr"
        line = ["render", FIRST_LEAF, "--frames", "7", "--size", "48x27", "--passes", "depth", "--out", path]
        subprocess.run([PROGRAM, *map(str, line)], check=True, capture_output=True)
        ours = sunfleck.render(str(FIRST_LEAF), 7, size="48x27", passes=["depth"])
        theirs, stored = sunfleck.read(path), decode(path)
        self.assertEqual(ours.metadata.keys(), theirs.metadata.keys())
        self.assertEqual(ours.metadata["sunfleck:fileHash"], theirs.metadata["sunfleck:fileHash"])
        self.assertEqual((theirs.number, ours.metadata["framesPerSecond"]), (7, Fraction(24)))
        self.assertEqual(ours.channels, tuple(sorted(stored)))
        for name, values in stored.items():
            np.testing.assert_array_equal(ours[name], values)

    def test_the_camera_is_a_matrix_of_columns(self):
        camera = sunfleck.render(FIRST_LEAF, 1, size=SIZE, samples=1, bounces=0).metadata["worldToCamera"]
        # By the scene at (0.2, 0.45, 2.5): what is there is the origin.
        np.testing.assert_allclose(camera @ [0.2, 0.45, 2.5, 1.0], [0.0, 0.0, 0.0, 1.0], atol=1e-5)

    def test_a_crop_has_the_whole_picture_around_it(self):
        frame = sunfleck.render(FIRST_LEAF, 12, size=SIZE, crop=(10, 5, 30, 20))
        self.assertEqual((frame.size, frame.window, frame.beauty.shape), (SIZE, (10, 5, 30, 20), (15, 20, 4)))

    def test_a_sequence_comes_frame_by_frame_and_is_kept_where_it_is_wanted(self):
        out = self.folder / "kept"
        numbers = [frame.number for frame in sunfleck.render_frames(FIRST_LEAF, range(3, 9, 2), size=SIZE, bounces=0, out=f"{out}/")]
        self.assertEqual(numbers, [3, 5, 7])
        self.assertEqual(sorted(path.name for path in out.iterdir()), [f"first_leaf.000{number}.exr" for number in numbers])
        self.assertEqual([frame.number for frame in sunfleck.render_frames(FIRST_LEAF, "2,1", size=SIZE, bounces=0)], [2, 1])
        self.assertEqual(list(self.temporary.iterdir()), [])

    def test_what_a_frame_has_not_is_said_with_a_remedy(self):
        frame = sunfleck.render(FIRST_LEAF, size=SIZE, samples=1, bounces=0)
        with self.assertRaisesRegex(AttributeError, r"render it with passes=\['leaf-id'\]"):
            frame.leaf_id
        with self.assertRaisesRegex(AttributeError, "has no nonsense: its passes are beauty"):
            frame.nonsense
        with self.assertRaisesRegex(KeyError, r"render it with passes=\['leaf-id'\]"):
            frame.passes["leaf_id"]
        with self.assertRaisesRegex(KeyError, "no channel Z: the frame has A, B, G, R"):
            frame["Z"]
        self.assertEqual(repr(frame), "<sunfleck.Frame 1: 48x27, beauty>")
        self.assertIn("beauty", dir(frame))

    def test_a_frame_goes_over_a_plate_as_the_page_has_it(self):
        page = (ROOT / "docs/over-a-plate.md").read_text("utf-8")
        script = re.search(r"```python\n(.*?)```", page, re.DOTALL)[1]
        leaves = sunfleck.render(FIRST_LEAF, 24, size=SIZE, samples=1, bounces=0, out=self.folder / "out/shot.0024.exr").beauty
        plate = np.full((27, 48), 0.25, np.float16)
        write_frame(self.folder / "plate.0024.exr", dict.fromkeys("RGB", plate))
        environment = {**os.environ, "PYTHONPATH": str(ROOT / "tools")}
        subprocess.run([sys.executable, "-c", script], cwd=self.folder, env=environment, check=True)
        over = sunfleck.read(self.folder / "over.0024.exr").beauty
        np.testing.assert_allclose(over, leaves[..., :3] + (1 - leaves[..., 3:]) * 0.25, rtol=1e-3)

    def test_channels_that_are_no_pass_are_named(self):
        path = write_frame(self.folder / "x.exr", {"Y": np.ones((4, 4), np.float32)})
        with self.assertRaisesRegex(AttributeError, r"holds no pass: take a channel by its name, frame\[NAME\], of Y"):
            sunfleck.read(path).beauty

    def test_inspect_is_what_the_program_says(self):
        found = sunfleck.inspect(FIRST_LEAF, [1, 2.5], size="50%")
        self.assertEqual((found["frame_start"], found["frame_end"], found["size"]), (1, 48, [160, 90]))
        self.assertEqual(len(found["frames"]), 2)

    def test_a_dark_frame_is_warned_of(self):
        scene = self.folder / "dark.ron"
        scene.write_text(DARK)
        with warnings.catch_warnings(record=True) as heard:
            warnings.simplefilter("always")
            sunfleck.render(scene, size=SIZE, samples=1)
        self.assertEqual({warning.category for warning in heard}, {sunfleck.SunfleckWarning})
        self.assertRegex("\n".join(str(warning.message) for warning in heard), r"(?s)warning\[dark-frame\].*remedy: ")

    def test_threads_render_at_the_same_time_and_leave_the_output_where_it_was(self):
        before, found = os.fstat(1), {}

        def work(number: int) -> None:
            found[number] = sunfleck.render(FIRST_LEAF, number, size=SIZE, samples=1, bounces=0, threads=1, progress=False).number

        threads = [threading.Thread(target=work, args=(number,)) for number in range(1, 7)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(found, {number: number for number in range(1, 7)})
        self.assertEqual((os.fstat(1).st_ino, os.fstat(1).st_dev), (before.st_ino, before.st_dev))


@unittest.skipUnless(PROGRAM, NO_PROGRAM)
class Progress(WithFolder):
    def test_a_function_hears_every_event(self):
        heard: list[dict] = []
        list(sunfleck.render_frames(FIRST_LEAF, "1-2", size=SIZE, bounces=0, progress=heard.append))
        kinds = [event["event"] for event in heard]
        self.assertEqual((kinds[0], kinds[-1], kinds.count("frame_written")), ("started", "finished", 2))
        self.assertIn("frame_progress", kinds)

    def test_a_bar_is_drawn_on_a_terminal_alone(self):
        for is_terminal in (True, False):
            stream = io.StringIO()
            stream.isatty = lambda: is_terminal
            with mock.patch("sys.stderr", stream):
                sunfleck.render(FIRST_LEAF, size=SIZE)
            self.assertEqual("[####" in stream.getvalue(), is_terminal, stream.getvalue())
            self.assertEqual(stream.getvalue().endswith("\r\x1b[K"), is_terminal)

    def test_frames_and_their_shares_make_one_bar(self):
        bar = EventBar()
        bar._bar = mock.Mock()
        for event in (
            {"event": "started", "frames": 4}, {"event": "frame_written", "frame": 1},
            {"event": "frame_progress", "frame": 2, "fraction": 0.5}, {"event": "frame_progress", "frame": 2, "fraction": 0.25},
            {"event": "frame_progress", "frame": 3, "fraction": 0.25}, {"event": "frame_written", "frame": 2},
            {"event": "finished"},
        ):  # fmt: skip
            bar(event)
        shown = [call.args for call in bar._bar.show.call_args_list]
        self.assertEqual([share for share, _ in shown], [0.0, 0.25, 0.375, 0.375, 0.4375, 0.5625, 1.0])
        self.assertEqual(shown[2][1], "frame 2 of 4")
