"""What `sunfleck export` writes, opened in Blender: every object, camera and light where sunfleck has it, at every frame.

Run with the other tests here (test_addon.py says how).
"""

import json
import math
import os
import subprocess
import tempfile
import unittest
from pathlib import Path

import bpy
import mathutils
import scenes

PROGRAM = os.environ.get("SUNFLECK", "sunfleck")
ROOT = Path(__file__).parents[3]
# Largest difference of a matrix's elements: metres, and cosines.
PLACES = 1e-5
# Blender's space from glTF's.
TURN = mathutils.Matrix([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])


def program(*arguments):
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, check=True, text=True)
    return done.stdout


def farthest(found, expected):
    """The largest difference of two matrices' elements; both are rows."""
    return max(abs(a - b) for ours, theirs in zip(found, expected) for a, b in zip(ours, theirs))


def rows(numbers):
    return [numbers[row : row + 4] for row in range(0, 16, 4)]


class Opened(unittest.TestCase):
    """`check` compares one input; what it prints are the largest differences."""

    def check(self, source, frames):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        path = Path(folder.name) / "scene.glb"
        program("export", ROOT / source, path)
        numbers = ",".join(map(str, frames))
        truth = json.loads(program("inspect", ROOT / source, "--json", "--frames", numbers))
        scene = scenes.empty()
        rate, base = truth["frame_rate"]
        scene.render.fps, scene.render.fps_base = rate, base
        scene.render.resolution_x, scene.render.resolution_y = truth["size"]
        bpy.ops.import_scene.gltf(filepath=str(path))
        self.worst = {"place": 0.0, "projection": 0.0, "light": 0.0}
        self.compared = dict.fromkeys(self.worst, 0)
        for frame in truth["frames"]:
            scene.frame_set(int(frame["frame"]))
            for name, node in frame["nodes"].items():
                self.compare_place(source, frame["frame"], bpy.data.objects[name], rows(node["world"]))
            for name, camera in frame["cameras"].items():
                self.compare_lens(bpy.data.objects[name], rows(camera["projection"]), truth["size"])
            for name, light in frame["lights"].items():
                # Values that change travel in empties that only sunfleck reads: lights are compared where they are still.
                if frame is truth["frames"][0]:
                    self.compare_light(bpy.data.objects[name], light)
        print(source, {what: f"{self.worst[what]:.1e} of {self.compared[what]}" for what in self.worst})
        return truth

    def note(self, what, difference):
        self.worst[what] = max(self.worst[what], difference)
        self.compared[what] += 1

    def compare_place(self, source, frame, thing, world):
        turn_back = TURN.inverted()
        # Cameras and lights look along -Z in both; everything else is turned with its mesh.
        looks = thing.type in {"CAMERA", "LIGHT"}
        found = turn_back @ thing.matrix_world @ (mathutils.Matrix() if looks else TURN)
        difference = farthest(found, world)
        self.note("place", difference)
        self.assertLessEqual(difference, PLACES, f"{source}, frame {frame}: `{thing.name}`")

    def compare_lens(self, thing, projection, size):
        graph = bpy.context.evaluated_depsgraph_get()
        found = thing.evaluated_get(graph).calc_matrix_camera(graph, x=size[0], y=size[1])
        # The third row is where the view ends in depth, of which sunfleck knows nothing.
        difference = max(farthest([found[row]], [projection[row]]) for row in (0, 1, 3))
        self.note("projection", difference)
        self.assertLessEqual(difference, PLACES, thing.name)

    def compare_light(self, thing, light):
        if thing.type != "LIGHT":
            return  # glTF has no area lights: to Blender they are empties.
        unit = 1.0 if thing.data.type == "SUN" else 1.0 / (4.0 * math.pi)
        said = light.get("irradiance_w_per_m2") or light.get("intensity_w_per_sr")
        found = [thing.data.energy * unit * channel for channel in thing.data.color]
        difference = max(abs(a - b) for a, b in zip(found, said)) / max(said)
        self.note("light", difference)
        self.assertLessEqual(difference, 1e-5, thing.name)

    def test_falling_leaves(self):
        self.check("sequences/falling_leaves.ron", range(1, 49, 8))
        self.assertGreater(self.compared["place"], 1000)

    def test_one_leaf(self):
        self.check("sequences/one_leaf.ron", range(1, 49))

    def test_what_came_from_blender(self):
        self.check("tests/data/blender/a_leaves40_sampled.glb", range(1, 61))

    def test_cameras_of_every_kind(self):
        self.check("tests/data/blender/h_cameras.glb", [1])
        self.assertGreater(self.compared["projection"], 5)

    def test_lights(self):
        self.check("tests/data/blender/h_lights_nopointer.glb", [1])
        self.assertGreater(self.compared["light"], 3)

    def test_shear_mirrors_and_scales_to_nothing(self):
        self.check("tests/data/blender/h_transforms_scene.glb", range(1, 25))


if __name__ == "__main__":
    unittest.main()
