"""Stages that `sunfleck-tools export-usd` writes, opened in Blender: is everything where, and as bright as,
the renderer has it?

The tools have USD libraries of their own, which must not meet Blender's in one process: they run in theirs.
"""

import json
import math
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import bpy
import numpy as np
import OpenEXR
from mathutils import Vector

# What reads glTF is without USD.
# Last, as `sunfleck` is the add-on here, and another package there.
sys.path.append(str(Path(__file__).parents[2]))
from sunfleck_tools.gltf.container import Container
from sunfleck_tools.gltf.deformation import Bending
from sunfleck_tools.gltf.meshes import Meshes
from sunfleck_tools.gltf.scene import Gltf

PROGRAM = os.environ.get("SUNFLECK", "sunfleck")
TOOLS = os.environ.get("SUNFLECK_TOOLS", "sunfleck-tools")
DATA = Path(__file__).parent / "data"
SAMPLES = Path(__file__).parents[3] / "tests/data/blender"
FRAMES = (1.0, 2.0, 2.25, 5.5, 7.0, 11.75, 12.0)
# Blender's z is up, the renderer's y.
BLENDER_FROM_USD = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]], float)
TRANSFORMS, ANGLES = 1e-5, 1e-4


def run(*command):
    result = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if result.returncode != 0:
        raise AssertionError(f"{command}: {result.stderr}")
    return result.stdout


def inspect(path, frames):
    listed = ",".join(f"{frame:g}" for frame in frames)
    found = json.loads(run(PROGRAM, "inspect", path, "--json", "--frames", listed))["frames"]
    return {frame["frame"]: frame for frame in found}


def at_frame(frame):
    """The scene as Blender evaluates it."""
    whole = math.floor(frame)
    bpy.context.scene.frame_set(whole, subframe=frame - whole)
    return bpy.context.evaluated_depsgraph_get()


def world_of(matrix):
    """A matrix of Blender's in the renderer's space."""
    return np.linalg.inv(BLENDER_FROM_USD) @ np.array(matrix)


@unittest.skipUnless(shutil.which(TOOLS), "sunfleck-tools is not installed: SUNFLECK_TOOLS names it")
class Review(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def open(self, source, *options, has_world=False):
        stage = self.folder / "stage.usdc"
        run(TOOLS, "export-usd", source, stage, "--for", "blender", "--sunfleck", PROGRAM, *options)
        bpy.ops.wm.read_factory_settings(use_empty=True)
        if has_world:
            bpy.context.scene.world = bpy.data.worlds.new("world")
        self.assertEqual(bpy.ops.wm.usd_import(filepath=str(stage)), {"FINISHED"})

    def review(self, *options):
        """Opens the scene, and gives what the renderer says of it."""
        glb = self.folder / "review.glb"
        run(PROGRAM, "export", DATA / "review.ron", glb, "--frames", "1-12")
        self.open(glb, *options)
        self.assertEqual((bpy.context.scene.frame_start, bpy.context.scene.frame_end), (1, 12))
        return inspect(glb, FRAMES)

    def assertNear(self, found, expected, bar, what):
        worst = np.abs(np.asarray(found) - np.asarray(expected)).max()
        self.assertLessEqual(worst, bar, what)

    def test_every_leaf_is_where_it_is_at_whole_frames_and_between(self):
        # What falls turns between frames too.
        truth = self.review("--samples-per-frame", "4")
        leaves = {thing["sunfleck_name"]: thing for thing in bpy.data.objects if thing.instance_collection}
        self.assertEqual(len(leaves), 14)
        for frame, expected in truth.items():
            graph = at_frame(frame)
            for key, leaf in leaves.items():
                world = world_of(leaf.evaluated_get(graph).matrix_world)
                self.assertNear(
                    world.ravel(), expected["nodes"][key]["world"], TRANSFORMS, f"{key} at {frame}"
                )
        # All of one mesh.
        self.assertEqual(len([mesh for mesh in bpy.data.meshes if mesh.name.startswith("leaf")]), 1)

    def test_what_falls_at_whole_frames_is_where_the_scene_itself_has_it(self):
        self.open(DATA / "review.ron", "--frames", "1-12")
        frames = (1.0, 6.0, 12.0)
        for frame, expected in inspect(DATA / "review.ron", frames).items():
            graph = at_frame(frame)
            for leaf in (thing for thing in bpy.data.objects if thing.instance_collection):
                world = world_of(leaf.evaluated_get(graph).matrix_world)
                self.assertNear(
                    world.ravel(), expected["nodes"][leaf["sunfleck_name"]]["world"], TRANSFORMS, leaf.name
                )

    def test_the_sky_is_the_world(self):
        """Blender makes a world of a dome where the scene has one, as its own new scenes do."""
        scene = '{ "leaf": Leaf(length_m: 0.1, width_m: 0.06) }, objects: { "leaf": (mesh: "leaf") }, cameras: { "main": (position_m: (0, 1, 4)) }'
        source = self.folder / "sky.ron"
        for sky in (
            "Constant(radiance_w_per_m2_sr: (0.4, 0.2, 0.1))",
            "Gradient(zenith_w_per_m2_sr: (0.2, 0.3, 0.8), horizon_w_per_m2_sr: (0.8, 0.7, 0.9), "
            "ground_w_per_m2_sr: 0.1)",
        ):
            source.write_text(f"Scene(version: 1, meshes: {scene}, sky: {sky})")
            self.open(source, has_world=True)
            nodes = {node.bl_idname: node for node in bpy.context.scene.world.node_tree.nodes}
            background = nodes["ShaderNodeBackground"]
            strength = background.inputs["Strength"].default_value
            if "ShaderNodeTexEnvironment" not in nodes:
                self.assertNear(
                    np.array(background.inputs["Color"].default_value[:3]) * strength,
                    [0.4, 0.2, 0.1],
                    1e-6,
                    sky,
                )
                continue
            image = nodes["ShaderNodeTexEnvironment"].image
            # From straight down to straight up.
            rows = np.array(image.pixels[:]).reshape(image.size[1], image.size[0], 4)[:, 0, :3] * strength
            half = len(rows) // 2
            for row, expected in (
                (0, [0.1] * 3),
                (half - 1, [0.1] * 3),
                (half, [0.8, 0.7, 0.9]),
                (-1, [0.2, 0.3, 0.8]),
            ):
                self.assertNear(rows[row], expected, 2e-3, f"row {row}")
            self.assertNear(rows[half + half // 3], [0.5, 0.5, 0.85], 2e-3, "at 30 degrees")

    def test_an_image_of_the_sky_is_seen_where_the_renderer_has_it(self):
        """What Blender sees, rendered, in directions of the renderer's: red is how far to the
        right in the picture."""
        right, down = np.meshgrid(
            (np.arange(64, dtype=np.float32) + 0.5) / 64, (np.arange(32, dtype=np.float32) + 0.5) / 32
        )
        with OpenEXR.File({"type": OpenEXR.scanlineimage}, {"R": right, "G": down, "B": right}) as file:
            file.write(str(self.folder / "marked.exr"))
        sky = 'Image(image: "marked.exr", rotation_deg: 20, lights: Surfaces)'
        source = self.folder / "sky.ron"
        mesh = 'meshes: { "leaf": Leaf(length_m: 0.1, width_m: 0.06) }, objects: { "leaf": (mesh: "leaf", translation_m: (0, -9, 0)) }'
        source.write_text(
            f'Scene(version: 1, {mesh}, cameras: {{ "main": (position_m: (0, 1, 4)) }}, sky: {sky})'
        )
        self.open(source, has_world=True)
        scene = bpy.context.scene
        scene.render.engine, scene.cycles.samples, scene.cycles.use_denoising = "CYCLES", 1, False
        # What is seen alone needs no map of where it is bright.
        scene.world.cycles.sampling_method = "NONE"
        scene.render.resolution_x = scene.render.resolution_y = 4
        scene.render.image_settings.file_format = "OPEN_EXR"
        scene.render.filepath = str(self.folder / "seen.exr")
        camera = bpy.data.objects.new("looking", bpy.data.cameras.new("looking"))
        camera.data.angle = math.radians(1)
        scene.collection.objects.link(camera)
        scene.camera = camera
        # The renderer has -z in the middle, +x to the right of it; 20 degrees anticlockwise move a
        # direction to the right.
        for direction, u, v in (
            ((1, 0, 0), 0.75, 0.5),
            ((-1, 0, 0), 0.25, 0.5),
            ((0, 0, -1), 0.5, 0.5),
            ((0, 1, -1), 0.5, 0.25),
        ):
            x, y, z = direction
            camera.matrix_world = Vector((x, -z, y)).to_track_quat("-Z", "Y").to_matrix().to_4x4()
            bpy.ops.render.render(write_still=True)
            seen = bpy.data.images.load(scene.render.filepath, check_existing=False)
            red, green = np.array(seen.pixels[:]).reshape(-1, 4).mean(axis=0)[:2]
            bpy.data.images.remove(seen)
            self.assertNear([red, green], [u + 20 / 360, v], 0.01, f"{direction}")

    def test_a_crowd_is_where_its_leaves_are(self):
        truth = self.review("--point-instancer", "--samples-per-frame", "4")
        keys = [f"falling.{number}" for number in range(12)]
        for frame, expected in truth.items():
            graph = at_frame(frame)
            worlds = [
                world_of(instance.matrix_world)
                for instance in graph.object_instances
                if instance.is_instance and instance.parent.name == "leaves" and instance.object.type == "MESH"
            ]
            self.assertEqual(len(worlds), len(keys))
            for key, world in zip(keys, worlds):
                self.assertNear(
                    world.ravel(), expected["nodes"][key]["world"], TRANSFORMS, f"{key} at {frame}"
                )

    def test_meshes_that_bend_are_right_between_frames_too(self):
        """Where there are samples, against the curves of the glTF file, which are not Blender's own
        between its keys."""
        for name, shapes in (("c_morph", ("morph_leaf_0", "morph_leaf_1")), ("d_skin", ("branch",))):
            self.open(SAMPLES / f"{name}.glb", "--samples-per-frame", "4")
            gltf = Gltf(Container(SAMPLES / f"{name}.glb"))
            meshes, nodes = Meshes(gltf, []), {node.name: node for node in gltf.nodes}
            for frame in (2.0, 7.25, 12.5, 20.75):
                graph, times = at_frame(frame), gltf.settings.seconds(np.array([frame]))
                for shape in shapes:
                    node = nodes[shape]
                    bending = Bending(gltf, node, meshes.of(node)[1])
                    place = np.eye(4) if bending.is_skinned else node.world_from_node(times)[0]
                    expected = np.concatenate(
                        [bending.positions(each, times)[0] for each in bending.mesh.primitives]
                    )
                    expected = expected @ place[:3, :3].T + place[:3, 3]
                    things = (thing for thing in bpy.data.objects if thing.type == "MESH")
                    thing = next(
                        thing for thing in things if thing.get("sunfleck_name") == shape
                    ).evaluated_get(graph)
                    points = np.array(
                        [[*(thing.matrix_world @ vertex.co), 1.0] for vertex in thing.to_mesh().vertices]
                    )
                    points = (points @ np.linalg.inv(BLENDER_FROM_USD).T)[:, :3]
                    self.assertNear(points, expected, TRANSFORMS, f"{shape} at {frame}")

    def test_meshes_that_bend_have_their_vertices_where_blender_had_them(self):
        for name, shapes in (("c_morph", ("morph_leaf_0", "morph_leaf_1")), ("d_skin", ("branch",))):
            self.open(SAMPLES / f"{name}.glb")
            for truth in json.loads((SAMPLES / f"{name}.gt.json").read_text())["frames"]:
                graph = at_frame(truth["frame"])
                # Between frames Blender's exporter joins samples by straight lines.
                bar = TRANSFORMS if truth["frame"] == int(truth["frame"]) else 1e-2
                for shape in shapes:
                    meshes = (thing for thing in bpy.data.objects if thing.type == "MESH")
                    thing = next(
                        thing for thing in meshes if thing.get("sunfleck_name") == shape
                    ).evaluated_get(graph)
                    mesh = thing.to_mesh()
                    points = np.array([[*(thing.matrix_world @ vertex.co), 1.0] for vertex in mesh.vertices])
                    points = points @ np.linalg.inv(BLENDER_FROM_USD).T
                    expected = truth["objects"][shape]["verts_world"]
                    for place in expected["pos"].values():
                        nearest = np.abs(points[:, :3] - place).max(axis=1).min()
                        self.assertLessEqual(nearest, bar, f"{shape} at {truth['frame']}")
                    self.assertNear(points[:, :3].min(axis=0), expected["bbox_min"], bar, shape)
                    self.assertNear(points[:, :3].max(axis=0), expected["bbox_max"], bar, shape)

    def test_nodes_beside_what_bends_are_where_they_are(self):
        for name in ("c_morph", "d_skin"):
            path = SAMPLES / f"{name}.glb"
            self.open(path)
            compared = 0
            for frame, expected in inspect(path, (1.0, 2.25, 17.5, 48.0)).items():
                graph = at_frame(frame)
                for thing in bpy.data.objects:
                    key = thing.get("sunfleck_name")
                    # A skin's own mesh is in the world.
                    if key in expected["nodes"] and not (name == "d_skin" and thing.type == "MESH"):
                        world = world_of(thing.evaluated_get(graph).matrix_world)
                        self.assertNear(
                            world.ravel(), expected["nodes"][key]["world"], TRANSFORMS, f"{key} at {frame}"
                        )
                        compared += 1
            self.assertGreaterEqual(compared, 8)

    def test_the_camera_sees_what_the_renderer_sees(self):
        truth = self.review()
        camera = bpy.data.objects["main"]
        render = bpy.context.scene.render
        render.resolution_x, render.resolution_y = 960, 540
        for frame, expected in truth.items():
            graph = at_frame(frame)
            seen = camera.evaluated_get(graph)
            self.assertNear(
                world_of(seen.matrix_world).ravel(), expected["camera"]["world"], TRANSFORMS, f"at {frame}"
            )
            self.assertLessEqual(abs(seen.data.angle_y - expected["camera"]["fov_y_rad"]), ANGLES)
            projection = np.array(seen.calc_matrix_camera(graph, x=960, y=540))
            expected = np.reshape(expected["camera"]["projection"], (4, 4))
            self.assertNear(projection[:2, :3], expected[:2, :3], ANGLES, "projection")
        self.assertTrue(camera.data.dof.use_dof)
        self.assertAlmostEqual(camera.data.dof.aperture_fstop, 2.8, 5)
        self.assertAlmostEqual(camera.data.dof.focus_distance, 3.5, 5)

    def test_cameras_of_every_kind(self):
        for sample in ("h_cameras", "i_conventions_nopointer"):
            path = SAMPLES / f"{sample}.glb"
            self.open(path)
            width, height = json.loads(run(PROGRAM, "inspect", path, "--json"))["size"]
            render = bpy.context.scene.render
            render.resolution_x, render.resolution_y = width, height
            graph = at_frame(1.0)
            for name, expected in inspect(path, (1.0,))[1.0]["cameras"].items():
                camera = bpy.data.objects[bpy.path.clean_name(name)].evaluated_get(graph)
                projection = np.array(camera.calc_matrix_camera(graph, x=width, y=height))
                expected = np.reshape(expected["projection"], (4, 4))
                self.assertNear(projection[:2, :3], expected[:2, :3], ANGLES, name)

    def test_lights_are_as_bright_as_they_are(self):
        lights = self.review()[1.0]["lights"]
        self.assertEqual(len(lights), 6)
        graph = at_frame(1.0)
        for name, expected in lights.items():
            thing = bpy.data.objects[name].evaluated_get(graph)
            light, kind = thing.data, expected["kind"]
            power = expected.get("irradiance_w_per_m2") or expected.get("power_w")
            if power is None:
                power = [4 * math.pi * value for value in expected["intensity_w_per_sr"]]
            self.assertNear(light.energy * np.array(light.color), power, 1e-5 * max(power), name)
            # Where it shines.
            axis = np.reshape(expected["world"], (4, 4))[:3, 2]
            self.assertNear(
                world_of(thing.matrix_world)[:3, 2], axis / np.linalg.norm(axis), TRANSFORMS, name
            )
            if kind == "sun":
                self.assertAlmostEqual(light.angle, expected["angular_diameter_rad"], 6)
            else:
                place = np.reshape(expected["world"], (4, 4))[:3, 3]
                self.assertNear(world_of(thing.matrix_world)[:3, 3], place, TRANSFORMS, name)
            if kind in ("sphere", "spot", "point"):
                self.assertAlmostEqual(light.shadow_soft_size, expected.get("radius_m", 0.0), 6)
            if kind == "spot":
                self.assertAlmostEqual(light.spot_size, 2 * expected["outer_rad"], 5)
                self.assertAlmostEqual(light.spot_blend, expected["blend"], 5)
            if kind in ("rectangle", "ellipse"):
                self.assertAlmostEqual(light.size, expected["width_m"], 5)
        self.assertAlmostEqual(bpy.data.objects["window"].data.size_y, 1.0, 5)

    def test_fog_is_there_to_be_seen_and_changed(self):
        self.review()
        fog = bpy.data.objects["haze"]
        self.assertEqual(fog.type, "EMPTY")
        self.assertEqual(fog["sunfleck_fog_volume:density"], 0.15)

    def test_materials_are_cut_out_where_they_were(self):
        self.open(SAMPLES / "b_leafcards.glb")
        shaders = {material.name: material.node_tree.nodes for material in bpy.data.materials}
        images = {
            node.image.name
            for nodes in shaders.values()
            for node in nodes
            if node.type == "TEX_IMAGE" and node.image
        }
        self.assertTrue(images)
        cut = [nodes for nodes in shaders.values() if any(node.type == "MATH" for node in nodes)]
        self.assertGreaterEqual(len(cut), 3)


if __name__ == "__main__":
    unittest.main()
