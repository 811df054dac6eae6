"""What `import-usd` is asked for on its command line, what it reports, and stages of
which a part is missing."""

import json
import unittest
from fractions import Fraction
from pathlib import Path

import numpy as np
from pxr import Sdf, UsdGeom

import sunfleck_tools
from sunfleck_tools import SceneError
from sunfleck_tools.gltf.container import Container
from sunfleck_tools.gltf.scene import Gltf
from sunfleck_tools.usd import ImportOptions, import_usd
from sunfleck_tools.usd.reading.clock import exact_rate
from sunfleck_tools.usd.reading.losses import KINDS

from .json_schema import faults
from .test_usd_import import quad
from .test_usd_lights import CASES, LookCase
from .test_validation import run


class Clock(LookCase):
    def test_rates_of_television(self):
        for rate, expected in (
            (23.976, Fraction(24000, 1001)), (23.98, Fraction(24000, 1001)), (24000 / 1001, Fraction(24000, 1001)),
            (29.97, Fraction(30000, 1001)), (59.94, Fraction(60000, 1001)), (119.88, Fraction(120000, 1001)), (24.0, Fraction(24)),
            (12.5, Fraction(25, 2)), (1.0, Fraction(1)), (0.5, Fraction(1, 2)), (4800.0, Fraction(4800)),
        ):  # fmt: skip
            self.assertEqual(exact_rate(rate), expected, rate)

    def test_frames_fall_on_whole_ones(self):
        gltf = self.case("J_23976")
        sunfleck = gltf.extras.raw["sunfleck"]
        self.assertEqual((sunfleck["fps"], sunfleck["fps_base"]), (24000, 1001))

    def test_the_range_of_the_samples(self):
        settings = self.case("Z_no_range").settings
        self.assertEqual((settings.first, settings.last), (1, 24))

    def test_samples_within_references_are_shifted(self):
        (self.folder / "mover.usda").write_text(
            '#usda 1.0\n(\n    defaultPrim = "a"\n)\ndef Xform "a"\n{\n    double3 '
            'xformOp:translate.timeSamples = '
            '{ 1: (0,0,0), 4: (3,0,0) }\n    uniform token[] xformOpOrder = ["xformOp:translate"]\n    def '
            'Camera "c"\n    {\n    }\n}\n'
        )
        stage = self.stage()
        stage.ClearMetadata("startTimeCode")
        stage.ClearMetadata("endTimeCode")
        prim = stage.DefinePrim("/b")
        prim.GetReferences().AddReference("./mover.usda", Sdf.LayerOffset(10.0))
        settings = self.load(stage).settings
        self.assertEqual((settings.first, settings.last), (11, 14))

    def test_asked_for(self):
        target = self.folder / "out.glb"
        imported = import_usd(CASES / "Z_no_range.usda", target, ImportOptions(frames=(5, 9)))
        self.assertEqual(imported.frames, (5, 9))
        gltf = Gltf(Container(target))
        mover = next(node for node in gltf.nodes if node.name == "Mover")
        places = mover.world_from_node(gltf.settings.seconds(np.array([5.0, 9.0])))[:, 0, 3]
        np.testing.assert_allclose(places, 3 * np.array([4, 8]) / 23, rtol=1e-5)


class Parts(LookCase):
    def test_variants(self):
        stage = self.stage()
        prim = UsdGeom.Xform.Define(stage, "/tree").GetPrim()
        seasons = prim.GetVariantSets().AddVariantSet("season")
        for name in ("spring", "autumn"):
            seasons.AddVariant(name)
            seasons.SetVariantSelection(name)
            with seasons.GetVariantEditContext():
                quad(stage, f"/tree/{name}_leaf")
        stage.GetRootLayer().Save()
        path = stage.GetRootLayer().realPath
        for choice in ("spring", "autumn"):
            target = self.folder / f"{choice}.glb"
            import_usd(path, target, ImportOptions(variants=(("/tree", "season", choice),)))
            self.assertEqual(
                [mesh["name"] for mesh in Container(target).document.raw["meshes"]], [f"{choice}_leaf"]
            )
        for variant, said in (
            (("/tree", "season", "winter"), "has no `winter`; it has autumn, spring"),
            (("/tree", "size", "big"), "has no variant set `size`; it has season"),
            (("/bush", "season", "spring"), "there is no prim `/bush`"),
        ):
            with self.assertRaises(SceneError) as caught:
                import_usd(path, self.folder / "none.glb", ImportOptions(variants=(variant,)))
            self.assertIn(said, str(caught.exception))

    def test_a_variant_that_the_set_lacks_is_said(self):
        stage = self.stage()
        prim = UsdGeom.Xform.Define(stage, "/tree").GetPrim()
        seasons = prim.GetVariantSets().AddVariantSet("season")
        seasons.AddVariant("spring")
        seasons.SetVariantSelection("winter")
        quad(stage, "/leaf")
        self.load(stage)
        (loss,) = self.imported.lost
        self.assertEqual(loss.kind, "usd-missing")
        self.assertIn("/tree: the variant set `season` has no `winter`; it has spring", loss.sentence)

    def test_masks_bring_what_is_needed(self):
        target = self.folder / "out.glb"
        import_usd(CASES / "S_binding_full.usda", target, ImportOptions(masks=("/World/Quad",)))
        document = Container(target).document.raw
        self.assertEqual([material["name"] for material in document["materials"]], ["Mat"])
        self.assertNotIn("cameras", document)
        with self.assertRaises(SceneError) as caught:
            import_usd(CASES / "S_binding_full.usda", target, ImportOptions(masks=("/Moon",)))
        self.assertIn("there is no prim `/Moon`", str(caught.exception))

    def test_strict(self):
        target = self.folder / "out.glb"
        code, _, said = run(
            "import-usd",
            CASES / "C_missing.usda",
            target,
            "--strict",
            "--report",
            self.folder / "report.json",
        )
        self.assertEqual(code, 3)
        self.assertIn("[usd-texture] /World/Mat/D: the texture `./not_there.png` is left out", said)
        self.assertEqual(list(self.folder.iterdir()), [])
        self.assertEqual(run("import-usd", CASES / "J_23976.usda", target, "--strict")[0], 0)

    def test_the_command_line(self):
        target = self.folder / "out.glb"
        for arguments, said in (
            (("--variant", "/World"), "is no variant"),
            (("--purpose", "render,looks"), "`looks` is no purpose"),
            (("--frames", "1-9x2"), "leaves frames out"),
        ):
            code, _, found = run("import-usd", CASES / "J_23976.usda", target, *arguments)
            self.assertEqual(code, 2)
            self.assertIn(said, found)
        code, out, _ = run(
            "import-usd",
            CASES / "Z_no_range.usda",
            target,
            "--frames",
            "2-4",
            "--mask",
            "/World/Mover",
            "--mask",
            "/World/Cam",
        )
        self.assertEqual((code, "frames 2 to 4" in out), (0, True))
        code, _, said = run("import-usd", CASES / "J_23976.usda", target, "--variant", "/World{a=b}{c=d}")
        self.assertEqual((code, "has no variant set `a`" in said), (3, True))


class Report(LookCase):
    def test_it_says_what_was_lost(self):
        report = self.folder / "report.json"
        code, _, said = run(
            "import-usd", CASES / "E_rect_shaping_texture.usda", self.folder / "out.glb", "--report", report
        )
        self.assertEqual(code, 0)
        found = json.loads(report.read_text())
        schema = json.loads((Path(sunfleck_tools.__file__).parent / "import_usd.schema.json").read_text())
        self.assertEqual(list(faults(found, schema)), [])
        self.assertEqual(found["frames"], {"first": 1, "last": 1})
        self.assertEqual(
            [(loss["id"], loss["count"], loss["first_place"]) for loss in found["losses"]],
            [("usd-light-input", 1, "/World/L")] * 3,
        )
        self.assertEqual(len({loss["sentence"] for loss in found["losses"]}), 3)
        for loss in found["losses"]:
            self.assertIn(f"[usd-light-input] {loss['sentence']}\n", said)

    def test_all_kinds_are_documented(self):
        text = (Path(__file__).parents[2] / "docs/usd.md").read_text()
        self.assertEqual([kind for kind in KINDS if f"| `{kind}` |" not in text], [])
        self.assertEqual(list(KINDS), sorted(KINDS))

    def test_it_needs_a_folder(self):
        target = self.folder / "out.glb"
        self.assertEqual(
            run("import-usd", CASES / "J_23976.usda", target, "--report", self.folder / "no/report.json")[0],
            3,
        )
        self.assertFalse(target.exists())


class Missing(LookCase):
    def test_the_rest_is_read(self):
        for arc in (
            "references = @./nope.usda@</x>",
            "payload = @./nope.usda@</x>",
            "references = </nowhere>",
        ):
            path = self.folder / f"part_{len(list(self.folder.iterdir()))}.usda"
            path.write_text(
                f'#usda 1.0\n(\n    subLayers = [@./no_layer.usda@]\n)\ndef Xform "a" ({arc})\n{{\n}}\ndef '
                f'Camera "b"\n{{\n}}\n'
            )
            imported = import_usd(path, self.folder / "out.glb")
            self.assertEqual(imported.counts["cameras"], 1)
            losses = {loss.kind: loss for loss in imported.lost}
            self.assertEqual((set(losses), losses["usd-missing"].count), ({"usd-missing"}, 2))

    def test_nothing_is_left(self):
        path = self.folder / "none.usda"
        path.write_text('#usda 1.0\ndef Xform "a" (references = @./nope.usda@</x>)\n{\n}\n')
        said = {loss.kind: loss.sentence for loss in import_usd(path, self.folder / "out.glb").lost}
        self.assertEqual(set(said), {"usd-missing", "usd-empty"})
        self.assertIn("nope.usda", said["usd-missing"])

    def test_a_library_of_materials_is_a_stage_too(self):
        path = self.folder / "looks.usda"
        path.write_text('#usda 1.0\ndef Material "a"\n{\n}\n')
        self.assertEqual(
            [loss.kind for loss in import_usd(path, self.folder / "out.glb").lost], ["usd-empty"]
        )

    def test_a_layer_that_is_damaged(self):
        (self.folder / "broken.usda").write_text('#usda 1.0\ndef Xform "a" (\n')
        path = self.folder / "whole.usda"
        path.write_text(
            '#usda 1.0\ndef Xform "a" (references = @./broken.usda@</a>)\n{\n}\ndef SphereLight "b"\n{\n}\n'
        )
        imported = import_usd(path, self.folder / "out.glb")
        self.assertEqual([loss.kind for loss in imported.lost], ["usd-missing"])


if __name__ == "__main__":
    unittest.main()
