"""`peers`: what other renderers are given, and that what they give is what sunfleck gives."""

from __future__ import annotations

import csv
import importlib.util
import json
import struct
import tempfile
import unittest
from pathlib import Path

import numpy as np

from sunfleck_tools import SceneError
from sunfleck_tools.peers import Point, write_table
from sunfleck_tools.peers.scene import read_scene

from .command import run

LEAVES500 = Path(__file__).parents[2] / "tests/data/leaves500"


def changed(source: Path, target: Path, change) -> Path:
    """A binary glTF file with a changed document."""
    data = source.read_bytes()
    (length,) = struct.unpack_from("<I", data, 12)
    document = json.loads(data[20 : 20 + length])
    change(document)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    rest = data[20 + length :]
    head = struct.pack("<4sIIII", b"glTF", 2, 20 + len(text) + len(rest), len(text), 0x4E4F534A)
    target.write_bytes(head + text + rest)
    return target


class Scenes(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.scratch = Path(scratch.name)

    def test_what_other_renderers_get(self):
        scene = read_scene(LEAVES500 / "leaves500.glb")
        (sun,) = scene.suns
        self.assertAlmostEqual(float(np.linalg.norm(sun.to_sun)), 1.0)
        self.assertGreater(float(sun.irradiance.min()), 0.0)
        self.assertEqual(np.shape(scene.fog.density_per_m), (3,))
        self.assertGreater(sum(len(surface.triangles) for surface in scene.surfaces), 1000)
        for surface in scene.surfaces:
            self.assertLess(int(surface.triangles.max()), len(surface.positions))

    def test_what_they_cannot_be_given_is_refused(self):
        def sun(document):
            return document["extensions"]["KHR_lights_punctual"]["lights"][0]

        for change, why in (
            (lambda d: sun(d).update(type="point"), "get suns only"),
            (lambda d: sun(d).update(color=[1]), "expected 3 numbers"),
            (lambda d: d["cameras"][0].update(type="orthographic"), "pinhole camera"),
            (lambda d: d["cameras"].clear(), "no camera 0"),
            (lambda d: d["accessors"][0].update(count=10**9), "accessors[0]"),
            (lambda d: d["nodes"][0].update(children=[0]), "nodes[0]"),
        ):
            path = changed(LEAVES500 / "leaves500.glb", self.scratch / "changed.glb", change)
            with self.assertRaisesRegex(SceneError, r"changed\.glb") as caught:
                read_scene(path)
            self.assertIn(why, str(caught.exception))

    def test_what_cannot_be_used_says_why(self):
        glb = LEAVES500 / "leaves500.glb"
        for code, *arguments in (
            (2, glb),
            (2, glb, "--out", self.scratch / "x.csv"),
            (2, glb, "--reference", LEAVES500 / "box.exr"),
            (2, glb, "--renderers", "luxcore", "--pictures", self.scratch),
            (2, glb, "--samples", "0", "--pictures", self.scratch),
            (2, glb, "--size", "0x3", "--pictures", self.scratch),
        ):
            found, _, err = run("peers", *arguments)
            self.assertEqual(found, code, (arguments, err))
            self.assertIn("error: ", err)

    def test_renderers_that_are_not_there_are_named_with_the_remedy(self):
        absent = [name for name, package in (("mitsuba-scalar", "mitsuba"), ("cycles", "bpy")) if not _is_there(package)]
        for name in absent:
            code, _, err = run("peers", LEAVES500 / "leaves500.glb", "--renderers", name, "--pictures", self.scratch)
            self.assertEqual(code, 2)
            self.assertRegex(err, r"is not here .*pip install './tools\[(mitsuba|cycles)\]'")

    def test_the_table_is_what_bench_reads(self):
        path = self.scratch / "table.csv"
        with path.open("w", newline="") as file:
            write_table(file, [Point("Cycles", "5.0.1", 16, 3.25, 0.0518, 0.999)], "a remark")
        lines = path.read_text().splitlines()
        self.assertEqual(lines[0], "# a remark")
        (row,) = csv.DictReader(lines[1:])
        self.assertEqual((row["renderer"], row["spp"], row["cpu_s"], row["rmse"]), ("Cycles", "16", "3.25", "0.0518"))


def _is_there(package: str) -> bool:
    return importlib.util.find_spec(package) is not None


class Rendered(unittest.TestCase):
    """Where a renderer is installed, its picture is the reference within its noise."""

    def check(self, renderer: str, samples: int) -> None:
        with tempfile.TemporaryDirectory() as folder:
            table = Path(folder, "x.csv")
            arguments = ["--reference", LEAVES500 / "box.exr", "--out", table, "--pictures", Path(folder, "frames")]
            code, out, err = run(
                "peers", LEAVES500 / "leaves500.glb", "--renderers", renderer, "--samples", samples, *arguments
            )
            self.assertEqual(code, 0, err)
            self.assertAlmostEqual(float(out.split("mean ratio")[1]), 1.0, delta=0.02)
            (row,) = csv.DictReader(table.read_text().splitlines()[1:])
            self.assertLess(float(row["rmse"]), 0.6)
            again, out, _ = run("compare", next(Path(folder, "frames").iterdir()), LEAVES500 / "box.exr", "--max-rmse", "0.6")
            self.assertEqual(again, 0, out)

    @unittest.skipUnless(_is_there("mitsuba"), "mitsuba is not installed")
    def test_mitsuba(self):
        self.check("mitsuba-scalar", 4)

    @unittest.skipUnless(_is_there("bpy"), "bpy is not installed")
    def test_cycles(self):
        self.check("cycles", 4)
