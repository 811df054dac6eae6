"""Lenses: where they are in focus, at the ends of their range too.

Run with the other tests here (test_addon.py says how).
"""

import subprocess

import bpy
import scenes
from sunfleck import check, export, extras
from test_addon import PROGRAM, Case, document


class Focus(Case):
    def setUp(self):
        super().setUp()
        scenes.quad(self.scene, "quad", 4.0, scenes.material("quad", (0.5,) * 3), (0.0, 0.0, 0.5))
        # It looks along +Y from 6 m before the quad.
        self.eye = scenes.camera(self.scene, (0.0, -6.0, 0.5), (0.0, 0.0, 0.5))
        self.dof = self.eye.data.dof
        self.dof.use_dof = True

    def said(self):
        """Lens of a file, which the program reads."""
        path = self.folder / "scene.glb"
        export.export(self.scene, path)
        subprocess.run([PROGRAM, "inspect", str(path)], capture_output=True, check=True)
        return document(path)["cameras"][0]["extras"]["sunfleck_camera"]

    def test_an_object_behind_the_camera_counts_as_before_it(self):
        self.dof.focus_object = scenes.add(self.scene, "focus", None, (0.0, -8.0, 0.5))
        self.assertAlmostEqual(self.said()["focus_distance"], 2.0, places=5)

    def test_a_bone_is_in_focus(self):
        rig = scenes.add(self.scene, "rig", bpy.data.armatures.new("rig"), (0.0, -4.0, 0.0))
        bpy.context.view_layer.objects.active = rig
        bpy.ops.object.mode_set(mode="EDIT")
        bone = rig.data.edit_bones.new("bud")
        bone.head, bone.tail = (0.0, 3.0, 0.0), (0.0, 4.0, 0.0)
        bpy.ops.object.mode_set(mode="OBJECT")
        self.dof.focus_object, self.dof.focus_subtarget = rig, "bud"
        self.assertAlmostEqual(self.said()["focus_distance"], 5.0, places=5)

    def test_numbers_of_nothing_are_next_to_nothing(self):
        self.dof.focus_distance, self.dof.aperture_fstop = 0.0, 0.0
        said = self.said()
        self.assertEqual((said["focus_distance"], said["fstop"]), (extras.LEAST_FOCUS_M, extras.LEAST_F_STOP))


class Orthographic(Case):
    def test_its_aperture_is_said_to_be_lost(self):
        lens = scenes.camera(self.scene).data
        lens.dof.use_dof = True
        self.assertEqual(check.check(self.scene), [])
        lens.type = "ORTHO"
        self.assertEqual([finding.id for finding in check.check(self.scene)], ["camera-aperture"])
