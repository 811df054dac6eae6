"""Frames of other renderers: several parts, layers, windows, passes of all kinds, names. Inputs in data/exr;
see each test for what is right."""

import json
import tempfile
import unittest
from pathlib import Path

import numpy as np

from sunfleck_tools import Options, SequenceError, validate
from sunfleck_tools.analysis import read_frame, read_picture
from sunfleck_tools.difference import relative_mse
from sunfleck_tools.layers import Kind, holds_ids, kind, picture
from sunfleck_tools.names import parts
from sunfleck_tools.sequence import list_sequence, list_sequences
from sunfleck_tools.summary import thumbnail

from .command import run
from .files import DATA, good_sequence, scene, write_frame, write_parts, write_sampled

CASES = DATA / "exr"
HERE = Options(processes=0)


def found(target: Path, **options: object) -> list[tuple[str, int | None]]:
    """Check and frame of all findings but the one that another program wrote the frames."""
    findings = validate(target, Options(processes=0, **options)).findings
    return [(finding.check, finding.frame) for finding in findings if finding.check != "unsigned"]


def boxes(display: tuple[int, int, int, int], data: tuple[int, int, int, int]) -> dict[str, object]:
    """Windows as OpenEXR's module takes them."""

    def box(window):
        return np.array(window[:2], np.int32), np.array(window[2:], np.int32)

    return {"displayWindow": box(display), "dataWindow": box(data)}


class WithFolder(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = Path(scratch.name)

    def sequence(
        self, change=lambda number, channels: channels, count: int = 8, name: str = "f", **header: object
    ) -> Path:
        """Frames of `scene`, each changed."""
        for number in range(1, count + 1):
            write_frame(self.folder / f"{name}.{number:04d}.exr", change(number, scene(number)), **header)
        return self.folder


class Cases(unittest.TestCase):
    def test_clean_frames_raise_nothing(self):
        for name in ("arnold_aov", "autocrop", "multipart_blender"):
            self.assertEqual(found(CASES / name), [], name)

    def test_blenders_parts_are_read_and_measured(self):
        file, frame = read_frame(2, str(CASES / "multipart_blender/f.0002.exr"))
        self.assertIsNone(file.fault)
        self.assertEqual((len(frame.headers), len(frame.channels)), (9, 30))
        self.assertEqual(frame.picture, tuple(f"ViewLayer.Combined.{letter}" for letter in "RGB"))
        self.assertGreater(validate(CASES / "multipart_blender", HERE).frames[0].mean, 0.03)

    def test_of_two_sequences_each_is_checked(self):
        self.assertEqual(found(CASES / "two_sequences"), [("chunks", 1002)])
        code, out, _ = run("validate", CASES / "two_sequences", "--json")
        report = json.loads(out)
        self.assertEqual(code, 1)
        self.assertEqual(
            [Path(one["pattern"]).name for one in report["sequences"]], ["beauty.####.exr", "depth.####.exr"]
        )
        self.assertEqual([one["rerender"] for one in report["sequences"]], ["1002", ""])

    def test_the_page_keeps_sequences_apart(self):
        with tempfile.TemporaryDirectory() as scratch:
            page = Path(scratch) / "page.html"
            run("validate", CASES / "two_sequences", "--html", page)
            text = page.read_text()
        for anchor in ("frame-1002", "sequence-2-frame-1002"):
            self.assertEqual(text.count(f'id="{anchor}"'), 1)
        self.assertIn('href="#frame-1002"', text)
        self.assertNotIn('href="#sequence-2-', text)

    def test_all_can_be_compared_and_shown(self):
        for name in ("arnold_aov", "autocrop", "multipart_blender"):
            for path in sorted((CASES / name).iterdir()):
                frame, fault = read_picture(path)
                self.assertEqual((fault, relative_mse(frame, frame)), (None, 0.0), path)
                self.assertGreater(thumbnail(frame, 96).max(), 0.1)


class Parts(WithFolder):
    def test_channels_are_named_by_their_parts(self):
        beauty, other = scene(1), scene(2)
        depth = {"Z": np.full((24, 32), np.inf, np.float32)}
        names = {
            "rgba": beauty,
            "diffuse": other,
            "depth": depth,
            "N": {f"N.{axis}": other["R"] for axis in "XYZ"},
        }
        _, frame = read_frame(1, str(write_parts(self.folder / "x.0001.exr", names)))
        self.assertEqual(
            sorted(frame.channels),
            ["A", "B", "G", "N.X", "N.Y", "N.Z", "R", "depth.Z", "diffuse.A", "diffuse.B", "diffuse.G", "diffuse.R"],
        )
        np.testing.assert_array_equal(frame.channels["diffuse.R"], other["R"])
        self.assertEqual(frame.channels["depth.Z"].shape, (24, 32))
        self.assertEqual(found(self.folder), [])

    def test_a_part_that_is_cut_off_is_named(self):
        path = write_parts(self.folder / "x.0001.exr", {"rgba": scene(1), "diffuse": scene(2)})
        path.write_bytes(path.read_bytes()[:-40])
        (finding,) = [f for f in validate(self.folder, HERE).findings if f.check == "chunks"]
        self.assertIn("chunk 3 of 3 of part `diffuse` (rows 32 to 47)", finding.message)


class Passes(WithFolder):
    def test_kinds_by_name(self):
        for names, expected in (
            ("R diffuse.R ViewLayer.Combined.G albedo.R Y error.Y transmission.red", Kind.LIGHT),
            ("A diffuse.A ViewLayer.Combined.a", Kind.ALPHA),
            ("pointlight.R grid.R solid.G nearest.B zone.R", Kind.LIGHT),
            ("Z depth.Z ViewLayer.Depth.Z zDepth.R ZBack Pz ViewLayer.Mist.Z depth.V Z-Depth.R "
             "camera_depth.R", Kind.DEPTH),
            ("bumpNormals.R Shading-Normal.G WorldPosition.B Motion-Vector.R optical_flow.R "
             "ViewLayer.Denoising-Normal.X", Kind.DATA),
            ("Object-ID.R material_index.R Cryptomatte-Object00.R renderId", Kind.ID),
            ("N.X P.Z Normal.X Position.Y motionvector.X velocity.R ViewLayer.Vector.W uv.R Nn.x __Pworld.x "
             "forward.u RY", Kind.DATA),
            ("leaf_id.X ID ViewLayer.IndexOB.X ViewLayer.CryptoObject00.r crypto_asset01.B object_id.R "
             "primId", Kind.ID),
        ):
            for name in names.split():
                self.assertIs(kind(name), expected, name)
                self.assertIs(kind(name.replace("-", " ")), expected, name)
        self.assertTrue(holds_ids("crypto_asset01.B") and holds_ids("ViewLayer.IndexOB.X"))
        self.assertFalse(holds_ids("ViewLayer.CryptoObject00.g"))

    def test_the_picture_is_the_likeliest_layer(self):
        for names, expected in (
            (["C.B", "C.G", "C.R"], ("C.R", "C.G", "C.B")),
            (["a.B", "a.G", "a.R", "v.Combined.B", "v.Combined.G", "v.Combined.R"], ("v.Combined.R", "v.Combined.G", "v.Combined.B")),
            (["N.B", "N.G", "N.R", "Z"], ()),
            (["BY", "RY", "Y"], ("Y",)),
            (["blue", "green", "red"], ("red", "green", "blue")),
        ):
            self.assertEqual(picture(names), expected)

    def test_signed_and_infinite_where_it_is_meant_so(self):
        def change(number, channels):
            size = channels["R"].shape
            signed = np.linspace(-1, 1, size[0] * size[1], dtype=np.float32).reshape(size)
            passes = {f"{name}.{axis}": signed * 900 for name in ("N", "P", "motionvector") for axis in "XYZ"}
            depth = np.where(signed > 0, np.inf, 5 - signed).astype(np.float32)
            return {**channels, **passes, "Z": depth, "ID": signed, "P.X": depth}

        self.assertEqual(found(self.sequence(change)), [])

    def test_light_is_still_held_to_be_light(self):
        def change(number, channels):
            if number == 2:
                channels["G"][5, 5] = -1e-7
            if number == 3:
                channels["G"][5, 5] = -0.5
            if number == 4:
                channels["B"][5, 5] = np.inf
            return {
                **channels,
                "diffuse.R": channels["R"] - np.float16(9 * (number == 5)),
                "N.X": channels["R"] * np.float16(np.nan),
            }

        self.assertEqual(
            sorted(found(self.sequence(change, count=5))),
            [("infinity", 4), *(("nan", n) for n in range(1, 6)), ("negative", 3), ("negative", 5)],
        )


class Windows(WithFolder):
    def cropped(self, number: int, x: int, y: int) -> Path:
        whole = scene(number)
        channels = {name: values[y : y + 24, x : x + 32] for name, values in whole.items()}
        path = self.folder / f"c.{number:04d}.exr"
        return write_frame(path, channels, **boxes((0, 0, 63, 47), (x, y, x + 31, y + 23)))

    def test_that_move_are_no_fault_and_pictures_hold_still(self):
        for number in range(1, 6):
            self.cropped(number, 2 * number, number)
        self.assertEqual(found(self.folder), [])
        frame, _ = read_picture(self.folder / "c.0001.exr")
        cell = thumbnail(frame, 64).sum(axis=2)
        self.assertTrue((cell[1:25, 2:34] > 0).all())
        cell[1:25, 2:34] = 0
        self.assertEqual(cell.max(), 0)
        # As large as those of whole frames.
        self.assertEqual(thumbnail(frame, 16).shape, (12, 16, 3))

    def test_beyond_the_display_window_are_cut_for_eyes_and_kept_for_figures(self):
        wide = {name: np.pad(values, 4, mode="edge") for name, values in scene(1).items()}
        path = write_frame(self.folder / "o.0001.exr", wide, **boxes((0, 0, 63, 47), (-4, -4, 67, 51)))
        self.assertEqual(found(self.folder), [])
        frame, _ = read_picture(path)
        np.testing.assert_allclose(thumbnail(frame, 64)[..., 0], scene(1)["R"].astype(float), rtol=1e-3)
        self.assertEqual(frame.group()[0].shape, (56, 72))

    def test_fireflies_are_looked_up_where_the_neighbours_have_them(self):
        for number in range(1, 4):
            self.cropped(number, 2 * number, number)
        for path in sorted(self.folder.glob("c.*.exr")):
            file, frame = read_frame(0, str(path))
            left, top, *_ = frame.header.data_window
            channels = {name: values.copy() for name, values in frame.channels.items()}
            for letter in "RGB":
                channels[letter][20 - top, 20 - left] = 900
            write_frame(path, channels, **boxes((0, 0, 63, 47), frame.header.data_window))
        # It stands still in the picture, and moves in the data.
        self.assertEqual(found(self.folder), [])

    def test_swapped_frames_are_found_in_frames_that_are_cut_down_too(self):
        for number in range(1, 9):
            self.cropped(number, 2 * number, number)
        one, other, aside = self.folder / "c.0004.exr", self.folder / "c.0005.exr", self.folder / "aside"
        one.rename(aside)
        other.rename(one)
        aside.rename(other)
        self.assertEqual(found(self.folder), [("order", 4), ("order", 5)])


class LuminanceChroma(WithFolder):
    def test_is_read_as_colour(self):
        whole = {name: values.astype(np.float32) for name, values in scene(1).items()}
        y = 0.2126 * whole["R"] + 0.7152 * whole["G"] + 0.0722 * whole["B"]
        chroma = {
            "Y": (y, 1),
            "RY": (((whole["R"] - y) / y)[::2, ::2], 2),
            "BY": (((whole["B"] - y) / y)[::2, ::2], 2),
        }
        path = write_sampled(self.folder / "y.0001.exr", chroma, 64, 48)
        self.assertEqual(found(self.folder), [])
        _, frame = read_frame(1, str(path))
        for color, letter in zip(frame.group(), "RGB"):
            np.testing.assert_allclose(color, whole[letter], rtol=2e-3)

    def test_luminance_alone_is_grey(self):
        path = write_frame(self.folder / "y.0001.exr", {"Y": scene(1)["R"]})
        self.assertEqual(found(path), [])
        frame, _ = read_picture(path)
        red, green, blue = frame.group()
        self.assertTrue((red == green).all() and (green == blue).all())

    def test_what_is_no_picture_is_named(self):
        path = write_frame(self.folder / "z.0001.exr", {"Z": scene(1)["R"], "N.X": scene(1)["R"]})
        self.assertEqual(
            read_picture(path), (None, "it has no picture (R, G and B of a layer, or Y), only N.X, Z")
        )


class Names(WithFolder):
    def test_where_the_number_is(self):
        for name, expected in (
            ("leaf.0001.exr", ("leaf.", "0001", ".exr")), ("shot.1001.beauty.exr", ("shot.", "1001", ".beauty.exr")),
            ("leaf_v002.0001.exr", ("leaf_v002.", "0001", ".exr")), ("leaf.0001.v2.exr", ("leaf.", "0001", ".v2.exr")),
            ("render0007.exr", ("render", "0007", ".exr")), ("take-0007.exr", ("take-", "0007", ".exr")),
            ("leaf_-5.exr", ("leaf_", "-5", ".exr")), ("shot_0007_left.exr", ("shot_", "0007", "_left.exr")),
            ("sh010.1001.beauty_4k.exr", ("sh010.", "1001", ".beauty_4k.exr")),
            ("x.exr", None), ("leaf_v2.exr", None), ("v2.exr", None), ("Leaf.V03.exr", None), ("x.4k.exr", None),
        ):  # fmt: skip
            self.assertEqual(parts(name), expected, name)

    def test_a_pass_behind_the_number(self):
        for name in ("beauty", "depth"):
            for number in (1001, 1002, 1003):
                write_frame(self.folder / f"shot.{number}.{name}.exr", scene(number - 1000))
        (self.folder / "shot.1002.depth.exr").unlink()
        self.assertEqual(found(self.folder), [("missing-frame", 1002)])
        self.assertEqual(
            [len(listing.files) for listing in list_sequences(self.folder / "shot.####.beauty.exr")], [3]
        )

    def test_a_picture_by_itself(self):
        path = write_frame(self.folder / "leaf_v2.exr", scene(1))
        code, out, _ = run("validate", path)
        self.assertEqual((code, out.splitlines()[-1]), (0, f"{path}: 1 frame: 0 errors, 1 warning"))
        write_frame(self.folder / "leaf_v1.exr", scene(2))
        self.assertEqual(found(self.folder), [])
        path.write_bytes(path.read_bytes()[:-9])
        self.assertEqual(found(self.folder), [("chunks", None)])

    def test_a_file_beside_a_sequence_is_checked_too(self):
        self.sequence(count=3)
        write_frame(self.folder / "still.exr", scene(1)).write_bytes(b"")
        self.assertEqual(found(self.folder), [("empty-file", None), ("foreign-file", None)])

    def test_places_as_other_programs_write_them(self):
        self.sequence(count=3)
        for place in ("####", "@@@@", "%04d", "%04i", "$F4", "${F4}", "<F4>"):
            listing = list_sequence(self.folder / f"f.{place}.exr")
            self.assertEqual((len(listing.files), listing.digits), (3, 4), place)

    def test_one_of_several_sequences_has_to_be_named(self):
        for name in ("a", "b"):
            self.sequence(count=2, name=name)
        with self.assertRaisesRegex(
            SequenceError, r"holds 2 sequences: name one of them, such as .*a\.####\.exr, .*b\.####\.exr"
        ):
            list_sequence(self.folder)

    def test_a_sequence_that_ends_before_another(self):
        self.sequence(count=6, name="beauty")
        self.sequence(count=5, name="depth")
        self.assertEqual(found(self.folder), [("shorter-sequence", None)])


class Own(unittest.TestCase):
    def test_frames_of_this_renderer_keep_all_its_promises(self):
        """The checks that other renderers' frames are spared: tests/damages.py breaks each."""
        with tempfile.TemporaryDirectory() as scratch:
            _, frame = read_frame(1, str(good_sequence(Path(scratch)) / "leaf.0001.exr"))
        self.assertTrue(frame.is_own)
