"""What is counted after export, and that a file which differs is found out.

Run with the other tests here (test_addon.py says how).
"""

import contextlib
import io
import json
import struct
from unittest import mock

import bpy
import leaf_scenes
import scenes
import stages
from sunfleck import command, export
from sunfleck.evaluated import scenes as exporting, walk
from sunfleck.evaluated.readback import File
from test_evaluated import Case


def rewritten(path, change):
    """The file with its JSON changed."""
    data = path.read_bytes()
    (length,) = struct.unpack_from("<I", data, 12)
    said = json.loads(data[20 : 20 + length])
    change(said)
    text = json.dumps(said).encode()
    text += b" " * (-len(text) % 4)
    rest = data[20 + length :]
    path.write_bytes(
        struct.pack("<4sII", b"glTF", 2, 20 + len(text) + len(rest))
        + struct.pack("<II", len(text), 0x4E4F534A)
        + text
        + rest
    )


class Counts(Case):
    def differing(self, scene, change):
        """The ids of what is found when a file has been changed."""
        made = exporting.export(scene, self.path)
        self.assertEqual(made.compared(File(self.path))[1], [])
        rewritten(self.path, change)
        return sorted({finding.id for finding in made.compared(File(self.path))[1]})

    def test_counts_are_what_is_there(self):
        scene = stages.stage((1, 2))
        stages.quad(scene, size=2.0)
        made = exporting.export(scene, self.path)
        (frame, counted), _ = made.compared(File(self.path))[0].of
        self.assertEqual((frame, counted.instances, counted.lights), (1, 1, 1))
        self.assertAlmostEqual(counted.area_m2, 4.0)
        self.assertEqual([*counted.low, *counted.high], [-1.0, 1.0, -1.0, 1.0, 1.0, 1.0])

    def test_every_kind_of_difference_is_found(self):
        def quads():
            scene = stages.stage()
            stages.moving(stages.quad(scene))
            return scene

        def named(said, name):
            return next(node for node in said["nodes"] if node["name"] == name)

        changes = {
            "count-instances": lambda said: named(said, "quad").update(extensions={"KHR_node_visibility": {"visible": False}}),
            "count-area": lambda said: named(said, "quad").update(scale=[1.001, 1.001, 1.001]),
            "count-bounds": lambda said: named(said, "quad").update(scale=[1.0, -1.0, -1.0]),
            "count-lights": lambda said: named(said, "sun").pop("extensions"),
            "count-materials": lambda said: said["materials"][0].update(name="other"),
        }
        for id, change in changes.items():
            if id == "count-bounds":
                # Nothing but its place changes.
                change = lambda said: said["animations"][0]["channels"].pop(0)
            self.assertIn(id, self.differing(quads(), change), id)

    def test_leaves_that_come_and_go_are_counted(self):
        scene = leaf_scenes.build("nodes_born")
        made = exporting.export(scene, self.path)
        expected, differences = made.compared(File(self.path))
        self.assertEqual(differences, [])
        counted = [there.instances for _, there in expected.of]
        self.assertEqual((counted[0], counted[-1]), (5, 62))

    def test_no_scene_differs(self):
        for name, build in stages.STAGES.items():
            scene = stages.stage()
            build(scene)
            told = export.exported(scene, self.path)
            self.assertEqual(
                [str(finding) for finding in told.findings if finding.id.startswith("count")], [], name
            )

    def test_an_export_that_was_stopped_is_none(self):
        scene = stages.stage()
        with mock.patch.object(walk, "have_rendered"), self.assertRaisesRegex(export.NotExportable, "0 of 6"):
            export.exported(scene, self.path)
        self.assertFalse(self.path.exists())
        self.assertNotEqual(scene.render.engine, "SUNFLECK_WALK")

    def test_the_command_says_what_there_is(self):
        scene = stages.stage((1, 2))
        stages.quad(scene)
        scenes.add(scene, "smoke", bpy.data.volumes.new("smoke"))
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            self.assertEqual(command.main(["check"]), 0)
        self.assertIn(
            "frame 2: 1 instances, 1 m2, from (-0.500, 1.000, -0.500) to (0.500, 1.000, 0.500), 1 lights",
            said.getvalue(),
        )
        self.assertIn("material `quad`: exact", said.getvalue())
        self.assertIn("warning[volume] `smoke`: a volume is not rendered", said.getvalue())
