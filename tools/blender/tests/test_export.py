"""What `sunfleck export` writes, opened in Blender: every object, camera and light where sunfleck
has it, at every frame.

Run with the other tests here (test_addon.py says how).
"""

import json
import math
import os
import re
import subprocess
import tempfile
import unittest
from pathlib import Path

import bpy
import mathutils
import mathutils.kdtree
import scenes
from sunfleck import importing

PROGRAM = os.environ.get("SUNFLECK", "sunfleck")
ROOT = Path(__file__).parents[3]
# Largest difference of a matrix's elements: metres, and cosines.
PLACES = 1e-5
# Frames that one process tells of: most of its time is reading the scene.
TOGETHER = 6
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


class Curves:
    """Objects' places from their F-curves and parents alone: what Blender's evaluation
    gives, without meshes."""

    def __init__(self, scene):
        self.objects = list(scene.objects)
        self.curves = {thing: self.of(thing) for thing in self.objects}
        self.moving = {thing.name for thing in self.objects if self.moves(thing)}

    def moves(self, thing):
        return bool(self.curves[thing]) or bool(thing.parent and self.moves(thing.parent))

    @staticmethod
    def of(thing):
        data = thing.animation_data
        if not data or not data.action:
            return []
        bags = [strip.channelbag(data.action_slot) for layer in data.action.layers for strip in layer.strips]
        return [curve for bag in bags if bag for curve in bag.fcurves]

    def basis(self, thing, frame):
        parts = {
            "location": thing.location.copy(),
            "rotation_quaternion": thing.rotation_quaternion.copy(),
            "scale": thing.scale.copy(),
        }
        if thing.rotation_mode != "QUATERNION" or not self.curves[thing]:
            return thing.matrix_basis
        for curve in self.curves[thing]:
            if curve.data_path in parts:
                parts[curve.data_path][curve.array_index] = curve.evaluate(frame)
        return mathutils.Matrix.LocRotScale(
            parts["location"], parts["rotation_quaternion"].normalized(), parts["scale"]
        )


class Worlds(dict):
    """Places by object at a frame, of those that are asked for."""

    def __init__(self, curves, frame):
        super().__init__()
        self.curves, self.frame = curves, frame

    def __missing__(self, thing):
        above = self[thing.parent] @ thing.matrix_parent_inverse if thing.parent else mathutils.Matrix()
        self[thing] = above @ self.curves.basis(thing, self.frame)
        return self[thing]


class Opened(unittest.TestCase):
    """`check` compares one input; what it prints are the largest differences."""

    def check(self, source, frames, evaluated=1):
        """Blender evaluates the whole scene at every frame, or at one in `evaluated`; at the others there are
        the curves of what moves."""
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        path = Path(folder.name) / "scene.glb"
        program("export", ROOT / source, path)
        frames = list(frames)
        truth = self.told(source, frames[:1])
        scene = scenes.empty()
        importing.load(scene, path)
        rate, base = truth["frame_rate"]
        self.assertAlmostEqual(scene.render.fps / scene.render.fps_base, rate / base, delta=1e-6 * rate)
        self.assertEqual([scene.render.resolution_x, scene.render.resolution_y], truth["size"])
        self.worst = {"place": 0.0, "projection": 0.0, "light": 0.0}
        self.compared = dict.fromkeys(self.worst, 0)
        self.things = {thing.name: thing for thing in scene.objects}
        curves = Curves(scene)
        for number, (at, frame) in enumerate(zip(frames, self.frames_of(source, frames))):
            is_evaluated = number % evaluated == 0
            if is_evaluated:
                scene.frame_set(at)
                worlds = {thing: thing.matrix_world for thing in scene.objects}
            else:
                worlds = Worlds(curves, at)
            for name, node in frame["nodes"].items():
                if is_evaluated or name in curves.moving:
                    self.compare_place(source, at, name, rows(node["world"]), worlds)
            if not is_evaluated:
                continue
            for name, camera in frame["cameras"].items():
                self.compare_lens(self.named(name, "CAMERA"), rows(camera["projection"]), truth["size"])
            for name, light in frame["lights"].items():
                # Values that change travel in empties that only sunfleck reads: lights are compared
                # where they are still.
                if number == 0:
                    self.compare_light(self.named(name, "LIGHT"), light)
        print(source, {what: f"{self.worst[what]:.1e} of {self.compared[what]}" for what in self.worst})
        return truth

    def told(self, source, frames):
        numbers = ",".join(map(str, frames))
        return json.loads(
            program("inspect", ROOT / source, "--json", "--frames", numbers, "--default-light", "off")
        )

    def frames_of(self, source, frames):
        """What is told of each, some at a time: of tens of thousands of nodes a frame has megabytes."""
        for first in range(0, len(frames), TOGETHER):
            yield from self.told(source, frames[first : first + TOGETHER])["frames"]

    def named(self, name, kind):
        """An object; Blender numbers those that share their name with others."""
        alike = [
            thing
            for thing in self.things.values()
            if thing.type == kind and thing.name.rpartition(".")[0] == name
        ]
        here = self.things.get(name)
        return here if here and here.type == kind else next(iter(alike), here)

    def note(self, what, difference):
        self.worst[what] = max(self.worst[what], difference)
        self.compared[what] += 1

    def compare_place(self, source, frame, name, world, worlds):
        # Blender would look through all of them.
        thing = self.things.get(name)
        if thing is None and "#" in name:
            # What `inspect` tells apart by numbers of its own, Blender does by others.
            stem = name.rpartition("#")[0]
            alike = [
                self.things[key]
                for key in (f"{stem}.{number:03}" for number in range(1, 1000))
                if key in self.things
            ]
            thing = min(alike, key=lambda one: self.off(one, world, worlds), default=None)
        if thing is None or thing.type == "ARMATURE":
            return self.compare_bone(source, frame, name, world)
        if any(modifier.type == "ARMATURE" for modifier in thing.modifiers):
            return None  # What follows a skeleton is nowhere else: its vertices are compared below.
        difference = self.off(thing, world, worlds)
        self.note("place", difference)
        self.assertLessEqual(difference, PLACES, f"{source}, frame {frame}: `{thing.name}`")

    def off(self, thing, world, worlds):
        """How far an object is from where it should be."""
        # Cameras and lights look along -Z in both; everything else is turned with its mesh.
        looks = thing.type in {"CAMERA", "LIGHT"}
        return farthest(TURN.inverted() @ worlds[thing] @ (mathutils.Matrix() if looks else TURN), world)

    def compare_bone(self, source, frame, name, world):
        """A joint: Blender turns bones as it likes, and their heads stand where the joints do."""
        heads = [thing.matrix_world @ thing.pose.bones[name].head for thing in bpy.data.objects
                 if thing.type == "ARMATURE" and name in thing.pose.bones]
        for head in heads:
            difference = (TURN.inverted() @ head - mathutils.Vector([row[3] for row in world[:3]])).length
            self.note("place", difference)
            self.assertLessEqual(difference, PLACES, f"{source}, frame {frame}: bone `{name}`")
        if not heads:
            self.assertIn(name, bpy.data.objects, source)

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
        """With a leaf of twenty of those that keep still, in crowns and on the ground: Blender takes minutes for all
        of them."""
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        source, scene = (
            Path(folder.name) / name for name in ("sequences/falling_leaves.ron", "scenes/falling_leaves/scene.ron")
        )
        for path in (source, scene):
            path.parent.mkdir(parents=True)
            text = (ROOT / path.relative_to(folder.name)).read_text()
            leaves = text.partition("    leaves: {")[2].partition("    fall: {")[0]
            thinner = re.sub(r"(?<=\(count: )\d+", lambda count: str(-(-int(count[0]) // 20)), leaves)
            path.write_text(text.replace(leaves, thinner))
        (scene.parents[1] / "woods").symlink_to(ROOT / "scenes/woods")
        self.check(source, range(1, 49), evaluated=8)
        self.assertGreater(self.compared["place"], 40_000)

    @unittest.skipUnless(os.environ.get("SUNFLECK_LONG"), "takes minutes: SUNFLECK_LONG=1 asks for it")
    def test_autumn(self):
        self.check("sequences/autumn.ron", range(1, 97), evaluated=24)
        self.assertGreater(self.compared["place"], 40_000)

    def test_first_leaf(self):
        self.check("sequences/first_leaf.ron", range(1, 49))

    def test_curves_and_jumps(self):
        self.check("tests/data/valid/ron/keyed_every_way_moving.ron", range(1, 49))

    def test_rates_that_are_no_whole_number(self):
        self.check("tests/data/valid/ron/keyed_every_way_24000_1001.ron", range(1, 49))

    def test_what_came_from_blender(self):
        self.check("tests/data/blender/a_leaves40_sampled.glb", range(1, 61))

    def test_skeletons_and_morph_targets(self):
        self.check("tests/data/blender/d_skin.glb", range(1, 25))
        self.check("tests/data/blender/c_morph.glb", range(1, 25))

    def test_cameras_of_every_kind(self):
        self.check("tests/data/blender/h_cameras.glb", [1])
        self.assertGreater(self.compared["projection"], 5)

    def test_lights(self):
        self.check("tests/data/blender/h_lights_nopointer.glb", [1])
        self.assertGreater(self.compared["light"], 3)

    def test_shear_mirrors_and_scales_to_nothing(self):
        self.check("tests/data/blender/h_transforms_scene.glb", range(1, 25))


class Bent(unittest.TestCase):
    """Skins and morph targets: what Blender makes of the exported file, and what it had itself
    (tests/data/blender)."""

    def compare(self, name):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        written = Path(folder.name) / "scene.glb"
        program("export", ROOT / "tests/data/blender" / f"{name}.glb", written)
        scene = scenes.empty()
        scene.render.fps = 24
        bpy.ops.import_scene.gltf(filepath=str(written))
        truth = json.loads((ROOT / "tests/data/blender" / f"{name}.gt.json").read_text())
        worst, moved, compared, first = 0.0, 0.0, 0, {}
        for frame in truth["frames"]:
            if frame["frame"] % 1.0:
                continue
            scene.frame_set(int(frame["frame"]))
            graph = bpy.context.evaluated_depsgraph_get()
            for thing, told in frame["objects"].items():
                vertices = told.get("verts_world", {}).get("pos", {})
                tree = self.vertices(bpy.data.objects[thing].evaluated_get(graph)) if vertices else None
                for number, vertex in vertices.items():
                    worst = max(worst, tree.find(vertex)[2])
                    before = first.setdefault((thing, number), mathutils.Vector(vertex))
                    moved = max(moved, (mathutils.Vector(vertex) - before).length)
                    compared += 1
        print(f"{name}: {compared} vertices move by {moved:.2f} and are off by {worst:.1e}")
        self.assertGreater(moved, 0.05)
        self.assertLessEqual(worst, PLACES)

    def vertices(self, thing):
        """A mesh's, in glTF's space."""
        tree = mathutils.kdtree.KDTree(len(thing.data.vertices))
        for index, vertex in enumerate(thing.data.vertices):
            tree.insert(TURN.inverted() @ thing.matrix_world @ vertex.co, index)
        tree.balance()
        return tree

    def test_skins(self):
        self.compare("d_skin")

    def test_morph_targets(self):
        self.compare("c_morph")


if __name__ == "__main__":
    unittest.main()
