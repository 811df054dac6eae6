"""Stages that Blender itself exports, read by `sunfleck-tools import-usd`: is everything
where Blender has it?"""

import json
import math
import shutil
import tempfile
import unittest
from pathlib import Path

import bpy
import numpy as np
import scenes
from test_review import BLENDER_FROM_USD, PROGRAM, TOOLS, TRANSFORMS, at_frame, inspect, run

USD_FROM_BLENDER = np.linalg.inv(BLENDER_FROM_USD)
FRAMES = (1.0, 2.0, 5.0, 8.0)


@unittest.skipUnless(shutil.which(TOOLS), "sunfleck-tools is not installed: SUNFLECK_TOOLS names it")
class FromBlender(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.scene = scenes.empty(frames=(1, 8))
        self.scene.render.fps = 25

    def back(self, **options):
        """The scene as it comes out of Blender's exporter and ours."""
        stage, glb = self.folder / "blender.usdc", self.folder / "back.glb"
        bpy.ops.wm.usd_export(filepath=str(stage), export_animation=True, **options)
        self.said = run(TOOLS, "import-usd", stage, glb)
        return glb

    def test_places_lens_and_lights_arrive(self):
        scene = self.scene
        shade = scenes.material("gold", (0.8, 0.5, 0.1))
        parent = scenes.add(scene, "branch", None, (0.5, 0.2, 1.0))
        parent.rotation_euler = (0.3, 0.1, 0.7)
        leaves = [scenes.quad(scene, f"leaf {number}", 0.4, shade, (number, 0.0, 1.0)) for number in range(4)]
        for number, leaf in enumerate(leaves):
            leaf.parent = parent
            leaf["leaf_id"] = number + 1
            for frame in (1, 8):
                leaf.location[2], leaf.rotation_euler = (
                    2.0 - 0.2 * frame,
                    (0.5 * frame, 0.1 * number, -0.3 * frame),
                )
                leaf.keyframe_insert("location", frame=frame)
                leaf.keyframe_insert("rotation_euler", frame=frame)
        camera = scenes.camera(scene)
        camera.data.dof.use_dof, camera.data.dof.focus_distance, camera.data.dof.aperture_fstop = (
            True,
            3.5,
            2.0,
        )
        camera.data.shift_x = 0.1
        for frame, lens in ((1, 35.0), (8, 70.0)):
            camera.data.lens = lens
            camera.data.keyframe_insert("lens", frame=frame)
        scenes.sun(scene, 3.0, 0.02)
        lamp = scenes.add(scene, "lamp", bpy.data.lights.new("lamp", "POINT"), (1.0, 2.0, 3.0))
        lamp.data.energy, lamp.data.shadow_soft_size, lamp.data.color = 40.0, 0.05, (1.0, 0.5, 0.25)
        spot = scenes.add(
            scene, "spot", bpy.data.lights.new("spot", "SPOT"), (0.0, 0.0, 4.0), (0.0, 0.0, 0.0)
        )
        spot.data.energy, spot.data.spot_size, spot.data.spot_blend = 80.0, 1.0, 0.3
        window = scenes.add(
            scene, "window", bpy.data.lights.new("window", "AREA"), (3.0, 0.0, 2.0), (0.0, 0.0, 1.0)
        )
        window.data.shape, window.data.size, window.data.size_y, window.data.energy = (
            "RECTANGLE",
            2.0,
            1.0,
            25.0,
        )
        found = inspect(self.back(), FRAMES)
        for frame, truth in found.items():
            graph = at_frame(frame)
            for thing in [parent, *leaves]:
                world = (
                    USD_FROM_BLENDER @ np.array(thing.evaluated_get(graph).matrix_world) @ BLENDER_FROM_USD
                )
                again = np.reshape(truth["nodes"][thing.name]["world"], (4, 4)) @ BLENDER_FROM_USD
                self.assertLessEqual(np.abs(again - world).max(), TRANSFORMS, f"{thing.name} at {frame}")
            seen = camera.evaluated_get(graph)
            world = USD_FROM_BLENDER @ np.array(seen.matrix_world)
            self.assertLessEqual(
                np.abs(np.reshape(truth["camera"]["world"], (4, 4)) - world).max(), TRANSFORMS
            )
            projection = np.array(seen.calc_matrix_camera(graph, x=64, y=36))
            expected = np.reshape(truth["camera"]["projection"], (4, 4))
            self.assertLessEqual(
                np.abs(projection[:2, :3] - expected[:2, :3]).max(), 1e-4, f"lens at {frame}"
            )
        lights = found[1.0]["lights"]
        self.near(lights["sun"]["irradiance_w_per_m2"], [3.0] * 3)
        self.near(lights["sun"]["angular_diameter_rad"], 0.02)
        self.near(lights["lamp"]["intensity_w_per_sr"], np.array([1.0, 0.5, 0.25]) * 40.0 / (4 * math.pi))
        self.near(lights["lamp"]["radius_m"], 0.05)
        self.near(lights["spot"]["intensity_w_per_sr"], [80.0 / (4 * math.pi)] * 3)
        self.near([lights["spot"]["outer_rad"], lights["spot"]["blend"]], [0.5, 0.3])
        self.near(lights["window"]["power_w"], [25.0] * 3)
        self.near([lights["window"]["width_m"], lights["window"]["height_m"]], [2.0, 1.0])

    def test_lamps_keep_their_watts_in_other_units(self):
        for kind in ("POINT", "AREA"):
            scenes.add(self.scene, kind, bpy.data.lights.new(kind, kind), (1.0, 2.0, 3.0)).data.energy = 40.0
        for unit in ("CENTIMETERS", "INCHES"):
            lights = inspect(self.back(convert_scene_units=unit), [1.0])[1.0]["lights"]
            self.near(lights["POINT"]["intensity_w_per_sr"], [40.0 / (4 * math.pi)] * 3)
            self.near(lights["AREA"]["power_w"], [40.0] * 3)

    def near(self, found, expected):
        found, expected = np.ravel(found), np.ravel(expected)
        self.assertLessEqual(np.abs(found - expected).max(), 1e-5 * max(1.0, np.abs(expected).max()))

    def test_copies_of_a_mesh_are_one_again(self):
        shade = scenes.material("gold", (0.8, 0.5, 0.1))
        first = scenes.quad(self.scene, "leaf", 0.4, shade)
        for number in range(20):
            scenes.add(self.scene, f"copy {number}", first.data, (number, 0.0, 0.0))
        scenes.camera(self.scene)
        self.back()
        self.assertIn("1 meshes, 1 materials", self.said)

    def test_frames_and_their_rate(self):
        leaf = scenes.quad(self.scene, "leaf", 0.4, scenes.material("gold", (0.8, 0.5, 0.1)))
        leaf.keyframe_insert("location", frame=1)
        scenes.camera(self.scene)
        found = json.loads(run(PROGRAM, "inspect", self.back(), "--json"))
        self.assertEqual((found["frame_start"], found["frame_end"], found["frame_rate"]), (1, 8, [25, 1]))

    def test_shape_keys_move(self):
        leaf = scenes.quad(self.scene, "leaf", 1.0, scenes.material("gold", (0.8, 0.5, 0.1)))
        leaf.shape_key_add(name="Basis")
        key = leaf.shape_key_add(name="up")
        key.data[0].co[2] = 1.0
        for frame, value in ((1, 0.0), (8, 1.0)):
            key.value = value
            key.keyframe_insert("value", frame=frame)
        scenes.camera(self.scene)
        glb = self.back()
        out = self.folder / "again.usda"
        run(TOOLS, "export-usd", glb, out)
        bpy.ops.wm.usd_import(filepath=str(out))
        copy = next(thing for thing in bpy.data.objects if thing.type == "MESH" and thing != leaf)
        for frame in FRAMES:
            graph = at_frame(frame)
            heights = [
                max((thing.evaluated_get(graph).matrix_world @ vertex.co)[2] for vertex in thing.evaluated_get(graph).to_mesh().vertices)
                for thing in (leaf, copy)
            ]
            self.assertLessEqual(abs(heights[0] - heights[1]), TRANSFORMS, f"frame {frame}")


if __name__ == "__main__":
    unittest.main()
