"""Operators and panels of the add-on as a person or a script meets them: drawn, undone, with progress,
from the command line.

Run with the other tests here (test_addon.py says how).
"""

import os
import subprocess
import sys
import tempfile
import time
import types
import unittest
from pathlib import Path
from unittest import mock

import bpy
import scenes
import sunfleck
from sunfleck import command, export, panels, program, render

PROGRAM = os.environ.get("SUNFLECK", "sunfleck")
ADDONS = Path(sunfleck.__file__).parents[1]
TESTS = Path(__file__).parent


class Layout:
    """Takes what a panel draws, and fails where Blender would: at a property or an operator
    that there is not."""

    def __init__(self, drawn):
        self.drawn = drawn

    def column(self, **_):
        return Layout(self.drawn)

    row = column

    def prop(self, owner, name, **_):
        getattr(owner, name)
        self.drawn.append(name)

    def operator(self, name, **_):
        group, verb = name.split(".")
        getattr(getattr(bpy.ops, group), verb).get_rna_type()
        self.drawn.append(name)
        return types.SimpleNamespace()

    def label(self, text=""):
        self.drawn.append(text)


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.scene = scenes.empty((1, 2))
        sunfleck.register()
        self.addCleanup(sunfleck.unregister)

    def fill(self):
        scenes.camera(self.scene)
        scenes.sun(self.scene)
        volume = scenes.fog_box(self.scene)
        quad = scenes.quad(self.scene, "ground", 6.0, scenes.material("soil", (0.4, 0.3, 0.2)))
        own = self.scene.sunfleck_settings
        own.use_samples, own.samples = True, 1
        return volume, quad


class Panels(Case):
    def drawn(self, panel, **context):
        found = []
        surroundings = types.SimpleNamespace(scene=self.scene, **context)
        self.assertTrue(getattr(panel, "poll", lambda _: True)(surroundings), panel)
        stage = types.SimpleNamespace(layout=Layout(found))
        stage.column = types.MethodType(panels.ScenePanel.column, stage)
        panel.draw(stage, surroundings)
        return found

    def test_every_panel_draws_what_there_is(self):
        volume, quad = self.fill()
        eye, sun = self.scene.camera, bpy.data.objects["sun"]
        material = quad.material_slots[0].material
        material.sunfleck_settings.is_leaf = True
        self.scene.sunfleck_settings.use_fog = True
        self.assertIn("sunfleck.render", self.drawn(panels.SUNFLECK_PT_render))
        self.assertIn("scale_height", self.drawn(panels.SUNFLECK_PT_world))
        self.assertIn("density", self.drawn(panels.SUNFLECK_PT_object, object=volume))
        self.assertIn("use_leaf_id", self.drawn(panels.SUNFLECK_PT_object, object=quad))
        self.assertIn("visible_to_camera", self.drawn(panels.SUNFLECK_PT_light, object=sun))
        self.assertTrue(self.drawn(panels.SUNFLECK_PT_camera, object=eye))
        self.assertIn("translucency", self.drawn(panels.SUNFLECK_PT_material, material=material))
        for panel in panels.CLASSES:
            self.assertTrue(panel.is_registered, panel)

    def test_what_a_panel_says_nothing_about_has_none(self):
        self.fill()
        nothing = types.SimpleNamespace(object=self.scene.camera, material=None, scene=self.scene)
        for panel in (panels.SUNFLECK_PT_object, panels.SUNFLECK_PT_light, panels.SUNFLECK_PT_material):
            self.assertFalse(panel.poll(nothing))


class Undo(Case):
    def test_export_and_what_it_wrote_are_taken_back(self):
        """Undo brings back a scene without our properties, and nothing of it is broken."""
        self.fill()
        bpy.context.preferences.edit.use_global_undo = True
        bpy.ops.ed.undo_push(message="before")
        path = self.folder / "scene.glb"
        self.assertEqual(bpy.ops.sunfleck.export(filepath=str(path)), {"FINISHED"})
        self.assertIn("sunfleck", bpy.context.scene)
        bpy.ops.ed.undo_push(message="after")
        bpy.ops.ed.undo()
        scene = bpy.context.scene
        self.assertNotIn("sunfleck", scene)
        self.assertNotIn("sunfleck_light", bpy.data.objects["sun"])
        self.assertEqual(scene.sunfleck_settings.samples, 1)
        self.assertTrue(bpy.data.objects["fog"].sunfleck_settings.is_fog)
        # And again from here.
        self.assertEqual(bpy.ops.sunfleck.export(filepath=str(path)), {"FINISHED"})
        self.assertIn("sunfleck", bpy.context.scene)


class Progress(Case):
    """The operator as a window drives it: a timer, then events, then the end."""

    def started(self):
        shown = []
        manager = types.SimpleNamespace(
            progress_begin=lambda *_: None, progress_end=lambda: shown.append("end"), progress_update=shown.append,
            event_timer_add=lambda *_, **__: "timer", event_timer_remove=lambda _: None, modal_handler_add=lambda _: True,
        )
        workspace = types.SimpleNamespace(status_text_set=shown.append)
        context = types.SimpleNamespace(
            scene=self.scene, window_manager=manager, workspace=workspace, window=None
        )
        plain = {name: value for name, value in vars(render.SUNFLECK_OT_render).items() if callable(value)}
        # An operator without Blender's half of it, which only a window has.
        stage = type(
            "Stage",
            (),
            {**plain, "report": lambda _, level, text: shown.append((level, text)), "animation": True},
        )()
        with (
            mock.patch.object(export, "default_folder", lambda _: self.folder),
            mock.patch.object(program, "find", lambda: PROGRAM),
        ):
            self.assertEqual(stage.invoke(context, None), {"RUNNING_MODAL"})
        return stage, context, shown

    def test_tells_how_far_it_is_and_loads_the_frames(self):
        self.fill()
        stage, context, shown = self.started()
        event = types.SimpleNamespace(type="TIMER")
        result = {"PASS_THROUGH"}
        for _ in range(600):
            time.sleep(0.05)
            result = stage.modal(context, event)
            if result != {"PASS_THROUGH"}:
                break
        self.assertEqual(result, {"FINISHED"}, shown)
        fractions = [value for value in shown if isinstance(value, float)]
        self.assertEqual(fractions, sorted(fractions))
        self.assertEqual(fractions[-1], 1.0)
        self.assertTrue(
            any(isinstance(value, str) and value.startswith("sunfleck: 100 %") for value in shown)
        )
        self.assertIsNone(shown[shown.index("end") + 1], "the status line is Blender's again")
        self.assertTrue(any(image.type == "MULTILAYER" for image in bpy.data.images))

    def test_escape_stops_it(self):
        self.fill()
        self.scene.sunfleck_settings.samples = 65536
        stage, context, shown = self.started()
        result = stage.modal(context, types.SimpleNamespace(type="ESC"))
        self.assertEqual(result, {"CANCELLED"})
        self.assertIsNotNone(stage.run.process.poll())
        self.assertIn("stopped", shown[-1][1])


class CommandLine(Case):
    def saved(self):
        self.fill()
        path = self.folder / "scene.blend"
        bpy.ops.wm.save_as_mainfile(filepath=str(path))
        return path

    def call(self, blend, *arguments):
        """In a process of its own: what `blender -b FILE --command sunfleck ...` does with our function."""
        code = (
            "import sys, bpy, sunfleck; sunfleck.register(); "
            "bpy.ops.wm.open_mainfile(filepath=sys.argv[1]); "
            "from sunfleck import command; sys.exit(command.main(sys.argv[2:]))"
        )
        surroundings = {
            **os.environ,
            "PYTHONPATH": os.pathsep.join([str(ADDONS), str(TESTS)]),
            "SUNFLECK": PROGRAM,
        }
        words = [sys.executable, "-c", code, str(blend), *map(str, arguments)]
        return subprocess.run(words, capture_output=True, text=True, env=surroundings)

    def test_a_saved_file_is_checked_exported_and_rendered(self):
        blend = self.saved()
        self.assertEqual(self.call(blend, "check").returncode, 0)
        self.assertEqual(self.call(blend, "export", self.folder / "out.glb").returncode, 0)
        self.assertTrue((self.folder / "out.glb").exists())
        done = self.call(
            blend, "render", "--folder", self.folder / "frames", "--size", "50%", "--frames", "2"
        )
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(len(list((self.folder / "frames").glob("*.exr"))), 1)
        self.assertEqual(self.call(blend, "paint").returncode, 2)
        refused = self.call(blend, "export", self.folder / "nowhere" / "out.glb")
        self.assertEqual(refused.returncode, 3, refused.stderr)
        self.assertIn("nowhere", refused.stderr)
        self.assertNotIn("Traceback", refused.stderr)

    def test_blender_knows_the_command_while_the_add_on_is_there(self):
        # Blender as a module has no `--command`; what it would call is what is registered.
        self.assertIsNotNone(command._handle)
        sunfleck.unregister()
        self.assertIsNone(command._handle)
        sunfleck.register()

    def test_the_extension_is_what_blenders_own_checker_takes(self):
        """`blender --command extension validate` runs this program of Blender's."""
        tools = list(Path(bpy.utils.resource_path("LOCAL")).rglob("bl_pkg/cli/blender_ext.py"))
        self.assertTrue(tools, "Blender's extension tool is not where it was")
        words = [sys.executable, str(tools[0]), "validate", str(ADDONS / "sunfleck")]
        done = subprocess.run(words, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        words = [
            sys.executable,
            str(tools[0]),
            "build",
            "--source-dir",
            str(ADDONS / "sunfleck"),
            "--output-dir",
            str(self.folder),
        ]
        done = subprocess.run(words, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertTrue(list(self.folder.glob("sunfleck-*.zip")))


if __name__ == "__main__":
    unittest.main()
