"""Every instance of every scene at every frame, in the file where Blender's dependency graph has it.

Run with the other tests here (test_addon.py says how). What it prints are the largest distances, metres.
"""

import os
import subprocess
import tempfile
import time
import unittest
from pathlib import Path

import bpy
import leaf_scenes
import numpy
import stages
import sunfleck
import truth
from sunfleck import export
from sunfleck.evaluated import simulations
from sunfleck.evaluated.readback import File
from test_addon import PROGRAM, inspect

TOOLS = os.environ.get("SUNFLECK_TOOLS")
# Metres; exact counts.
PLACES = 1e-4
BLURRED = 1e-3


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = Path(folder.name) / "scene.glb"
        sunfleck.register()
        self.addCleanup(sunfleck.unregister)

    def exported(self, scene, path=None):
        export.export(scene, path or self.path)
        return File(path or self.path)

    def compare(self, name, scene, bar=PLACES, subframe=0.0):
        frames = list(range(scene.frame_start, scene.frame_end + 1))
        file = self.exported(scene)
        expected = truth.of(scene, frames)
        found = truth.of_file(file, frames)
        counts = [len(expected[frame]) for frame in frames]
        self.assertEqual([len(found[frame]) for frame in frames], counts, name)
        worst = max(truth.farthest(found[frame], expected[frame]) for frame in frames)
        print(f"{name}: {min(counts)} to {max(counts)} instances, {worst:.1e} m off")
        self.assertLessEqual(worst, bar, name)
        return file, counts


class Leaves(Case):
    """The scenes of falling leaves."""

    def check(self, name):
        file, counts = self.compare(name, leaf_scenes.build(name))
        return counts

    def test_particles(self):
        counts = self.check("particles")
        self.assertEqual((counts[0], counts[-1]), (45, 62))

    def test_nodes(self):
        self.check("nodes")

    def test_nodes_born(self):
        counts = self.check("nodes_born")
        self.assertLess(counts[0], counts[-1])

    def test_simulation(self):
        self.check("simulation")

    def test_what_frames_were_skipped_of_is_simulated_anew(self):
        heights = []
        for looked_at in (1, 5):
            scene = stages.stage()
            cloth = stages.grid(scene, "cloth")
            cloth.modifiers.new("cloth", "CLOTH")
            for frame in (1, looked_at):
                scene.frame_set(frame)
            with simulations.run(scene, scene.view_layers[0], range(1, 6)):
                shown = cloth.evaluated_get(bpy.context.evaluated_depsgraph_get())
                heights.append(min(vertex.co.z for vertex in shown.data.vertices))
        self.assertLess(heights[0], -0.01)
        self.assertAlmostEqual(*heights, places=6)

    def test_simulation_emits(self):
        counts = self.check("simulation_emits")
        self.assertLess(counts[0], counts[-1])


class Blur(Case):
    """While the shutter is open things are where Blender has them, at any moment, with enough of Cycles' steps."""

    def check(self, name, build):
        scene = stages.stage()
        build(scene)
        self.compare_open(name, scene)

    def compare_open(self, name, scene):
        scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 0.5
        for thing in bpy.data.objects:
            thing.cycles.motion_steps = 4
        file = self.exported(scene)
        # Of simulations there is nothing before the first frame.
        frames, worst = list(range(scene.frame_start + 1, scene.frame_end + 1)), 0.0
        for offset in (-0.25, -0.1, 0.0, 0.07, 0.25):
            moments = [frame + offset for frame in frames]
            found = truth.of_file(file, moments)
            for frame, moment in zip(frames, moments):
                expected = truth.of(scene, [frame])[frame] if offset == 0.0 else truth.at(scene, moment)
                worst = max(worst, truth.farthest(found[moment], expected))
        print(f"{name}: {worst:.1e} m off while the shutter is open")
        self.assertLessEqual(worst, BLURRED, name)

    def test_turning(self):
        self.check("shears", stages.shears)

    def test_bending(self):
        self.check("shape_keys_and_modifiers", stages.shape_keys_and_modifiers)
        self.check("skeleton", stages.skeleton)

    def test_instances(self):
        self.check("collections", stages.collections)

    def test_particles(self):
        scene = leaf_scenes.build("particles")
        scene.frame_start, scene.frame_end = 11, 15
        self.compare_open("particles", scene)

    def test_simulation(self):
        scene = leaf_scenes.build("simulation")
        scene.frame_end = 6
        self.compare_open("simulation", scene)

    def test_what_appears_does_so_between_shutters(self):
        """With any position of the shutter a thing that is hidden until frame 3 is there all the time of
        that frame's shutter."""
        for position, opening in (("START", 0.0), ("CENTER", -0.25), ("END", -0.5)):
            scene = stages.stage()
            stages.keyed_visibility(scene)
            scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 0.5
            scene.render.motion_blur_position = position
            file = self.exported(scene)
            shown = {frame: 2 if frame in (3, 4) else 1 for frame in range(2, 7)}
            for frame, count in shown.items():
                moments = [frame + opening + 0.5 * share for share in (0.0, 0.3, 1.0)]
                counts = [len(there) for there in truth.of_file(file, moments).values()]
                self.assertEqual(counts, [count] * 3, (position, frame))

    def test_what_appears_elsewhere_does_not_come_from_where_it_was(self):
        """Hidden at frames 3 and 4, and moved by 10 m meanwhile."""
        scene = stages.stage()
        scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 0.5
        thing = stages.quad(scene)
        for frame, is_hidden in ((1, False), (3, True), (5, False)):
            thing.hide_render = is_hidden
            thing.keyframe_insert("hide_render", frame=frame)
        stages.key(thing, "location", ((0.0, 0.0, 0.0), (10.0, 0.0, 0.0)), (1, 4), "CONSTANT")
        found = truth.of_file(self.exported(scene), [2.0, 2.25, 4.75, 5.0, 5.25])
        for moment, (there,) in found.items():
            self.assertAlmostEqual(there[..., 0].mean(), 0.0 if moment < 3.0 else 10.0, places=4, msg=str(moment))


class Large(Case):
    def test_two_thousand_leaves_of_240_frames(self):
        """20 s of one core and 150 MB; wall time is as others leave it."""
        scene = leaf_scenes.build("particles")
        settings = bpy.data.particles[0]
        settings.count, settings.lifetime, scene.frame_end = 2000, 500, 240
        wall, cpu = time.perf_counter(), time.process_time()
        export.export(scene, self.path)
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
        size = self.path.stat().st_size / 1e6
        file = File(self.path)
        visible = sum(
            shown[0] for node, shown in zip(file.nodes, file.visible(file.seconds([240]))) if "mesh" in node
        )
        print(f"2000 leaves, 240 frames: {cpu:.1f} s of a core, {wall:.1f} s in all, {size:.1f} MB")
        self.assertEqual(visible, 2002)
        self.assertLess(cpu, 20.0)
        self.assertLess(size, 150.0)


class Inspected(Case):
    """The renderer reads the same places and the same visibility."""

    def test_leaves_are_born_where_they_are(self):
        scene = leaf_scenes.build("simulation_emits")
        file = self.exported(scene)
        frames = [1, 6, 12, 24]
        worlds, visible = file.worlds(file.seconds(frames)), file.visible(file.seconds(frames))
        found = inspect(self.path, "--frames", ",".join(map(str, frames)))
        self.assertEqual([loss["id"] for loss in found["losses"]], [])
        counts = []
        for at, frame in enumerate(found["frames"]):
            counts.append(0)
            for index, node in enumerate(file.nodes):
                told = frame["nodes"][node["name"]]
                self.assertEqual(told["visible"], bool(visible[index][at]), node["name"])
                counts[-1] += "mesh" in node and told["visible"]
                if told["visible"]:
                    worst = numpy.abs(numpy.array(told["world"]).reshape(4, 4) - worlds[index][at]).max()
                    self.assertLess(worst, 1e-5, node["name"])
        self.assertEqual(counts, [9, 25, 46, 86])

    def test_other_readers_open_it(self):
        """Blender's own importer, which knows no visibility: leaves that are there at the end
        are where they were."""
        scene = leaf_scenes.build("simulation_emits")
        self.exported(scene)
        expected = truth.of(scene, [24])[24]
        bpy.ops.wm.read_factory_settings(use_empty=True)
        bpy.context.scene.render.fps = 24
        bpy.ops.import_scene.gltf(filepath=str(self.path))
        found = truth.of(bpy.context.scene, [24])[24]
        worst = truth.farthest(found, expected)
        print(f"read by Blender's importer: {len(found)} instances, {worst:.1e} m off")
        self.assertLessEqual(worst, PLACES)

    @unittest.skipUnless(TOOLS, "SUNFLECK_TOOLS names sunfleck-tools")
    def test_usd_has_them_come_and_go(self):
        file = self.exported(leaf_scenes.build("nodes_born"))
        stage = self.path.with_suffix(".usda")
        subprocess.run(
            [TOOLS, "export-usd", str(self.path), str(stage)],
            capture_output=True,
            check=True,
            env={**os.environ, "SUNFLECK": PROGRAM},
        )
        born = sum(not shown[0] for shown in file.visible(file.seconds([1])))
        self.assertEqual(stage.read_text().count("token visibility.timeSamples"), born)


class Strands(Case):
    """Hair is tubes or ribbons, and points are spheres."""

    def corners(self, name):
        file = self.exported(self.scene)
        node = next(index for index, node in enumerate(file.nodes) if node["name"].startswith(name))
        world = file.worlds(file.seconds([1]))[node][0]
        return file.triangles(file.nodes[node]["mesh"]) @ world[:3, :3].T + world[:3, 3]

    def hair(self, alpha):
        """Straight hair of 1 cm, a metre long."""
        self.scene = stages.stage((1, 1))
        material = stages.scenes.material("hair", (0.5,) * 3)
        material.node_tree.nodes["Principled BSDF"].inputs["Alpha"].default_value = alpha
        data = bpy.data.hair_curves.new("hair")
        data.add_curves([3])
        data.position_data.foreach_set("vector", numpy.array([0, 0, 0, 0, 0, 0.5, 0, 0, 1], "f4"))
        data.attributes.new("radius", "FLOAT", "POINT").data.foreach_set("value", [0.005] * 3)
        data.materials.append(material)
        stages.scenes.add(self.scene, "hair", data)
        corners = self.corners("hair")
        self.assertAlmostEqual(float(numpy.ptp(corners[..., 1])), 1.0, 5)
        return corners

    def test_hair_curves(self):
        """A tube has the circumference of its hair."""
        corners = self.hair(1.0)
        self.assertAlmostEqual(area(corners), 2.0 * numpy.pi * 0.005, 5)
        normals = numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        outwards = corners.mean(axis=1) * [1.0, 0.0, 1.0]
        self.assertGreater(float((normals * outwards).sum(axis=1).min()), 0.0)

    def test_hair_that_lets_light_through(self):
        """A ribbon faces the camera."""
        corners = self.hair(0.5)
        self.assertAlmostEqual(area(corners), 0.01, 5)
        normal = numpy.cross(corners[0, 1] - corners[0, 0], corners[0, 2] - corners[0, 0])
        eye = numpy.array([0.0, 2.0, 6.0]) - corners[0].mean(axis=0)
        self.assertGreater(
            abs(float(normal @ eye)) / numpy.linalg.norm(normal) / numpy.linalg.norm(eye), 0.94
        )

    def test_particle_hair(self):
        self.scene = stages.stage((1, 1))
        lawn = stages.grid(self.scene, "lawn", 3)
        settings = lawn.modifiers.new("grass", "PARTICLE_SYSTEM").particle_system.settings
        settings.type, settings.count, settings.hair_length, settings.render_step = "HAIR", 5, 0.5, 3
        settings.root_radius, settings.tip_radius, settings.use_close_tip = 1.0, 1.0, False
        self.assertAlmostEqual(area(self.corners("lawn grass")), 5 * 0.5 * numpy.pi * settings.radius_scale, 5)

    def test_points(self):
        self.scene = stages.stage((1, 1))
        thing = stages.quad(self.scene, "points")
        tree = bpy.data.node_groups.new("points", "GeometryNodeTree")
        tree.is_modifier = True
        for way in ("INPUT", "OUTPUT"):
            tree.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
        start, made, end = (
            tree.nodes.new(kind) for kind in ("NodeGroupInput", "GeometryNodeMeshToPoints", "NodeGroupOutput")
        )
        made.inputs["Radius"].default_value = 0.1
        tree.links.new(start.outputs[0], made.inputs["Mesh"])
        tree.links.new(made.outputs[0], end.inputs[0])
        thing.modifiers.new("points", "NODES").node_group = tree
        # What a sphere shows from anywhere is a quarter of its surface.
        self.assertAlmostEqual(area(self.corners("points")), 4 * 4.0 * numpy.pi * 0.1**2, 5)


def area(corners):
    return 0.5 * float(
        numpy.linalg.norm(
            numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
        ).sum()
    )


class Stages(Case):
    """Everything else that moves, shows or hides."""


def staged(build):
    def test(self):
        scene = stages.stage()
        build(scene)
        self.compare(build.__name__, scene)

    return test


for _name, _build in stages.STAGES.items():
    setattr(Stages, f"test_{_name}", staged(_build))


if __name__ == "__main__":
    unittest.main()
