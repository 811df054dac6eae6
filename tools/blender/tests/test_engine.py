"""The render engine: F12, without a window, in the Blender that runs this."""

import json
import math
import os
import socket
import subprocess
import tempfile
import time
import unittest
from pathlib import Path
from types import SimpleNamespace
from unittest import mock

import bpy
import leaf_scenes
import mathutils
import numpy
import scenes
import stages
import sunfleck
from sunfleck import engine, export, render, service
from sunfleck.engine import cryptomatte, exporting, looking, passes, picture
from sunfleck.engine.viewport import STAGES, View, Viewport
from sunfleck.evaluated.document import Document
from sunfleck.materials import bake, inputs
from test_addon import document

PROGRAM = os.environ.get("SUNFLECK", "sunfleck")
SIZE = 32, 18


def processes():
    """Programs that this process has started and that have not ended."""
    found = subprocess.run(["ps", "--ppid", str(os.getpid()), "-o", "comm="], capture_output=True, text=True)
    return [line for line in found.stdout.split() if line.startswith("sunfleck")]


def nodes_of(path):
    """Of a file, each with its light."""
    data = path.read_bytes()
    said = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])
    for node in said["nodes"]:
        if "extensions" in node:
            node["extensions"] = said["extensions"]["KHR_lights_punctual"]["lights"][node["extensions"]["KHR_lights_punctual"]["light"]]
    return said["nodes"]


class Engine(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.scene = stages.stage()
        stages.quad(self.scene)
        sunfleck.register()
        self.addCleanup(sunfleck.unregister)
        self.set_up(self.scene)

    def set_up(self, scene):
        render, own = scene.render, scene.sunfleck_settings
        render.engine = "SUNFLECK"
        render.resolution_x, render.resolution_y, render.resolution_percentage = *SIZE, 100
        render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
        render.filepath = str(self.folder / "blender_")
        own.use_samples, own.samples, own.all_bounces, own.bounces = True, 2, False, 0

    def still(self):
        """What Blender wrote of one frame."""
        self.assertEqual(bpy.ops.render.render(write_still=True), {"FINISHED"})
        return picture.read(self.folder / "blender_.exr")

    def frame(self):
        """The program's own frame of the last render."""
        return picture.read(max(exporting.folder().glob("*.exr"), key=os.path.getmtime))

    def assert_same(self, blender, ours, channels="RGB"):
        for channel in channels:
            numpy.testing.assert_array_equal(blender.of((channel,)), ours.of((channel,)), channel)

    def test_pixels_are_the_programs(self):
        blender = self.still()
        self.assertEqual(blender.pixels.shape[:2], SIZE[::-1])
        self.assert_same(blender, self.frame())
        self.assertGreater(blender.of("RGB").max(), 0.0)

    def test_pixels_may_be_wider_than_high(self):
        wide, high = SIZE
        self.scene.render.resolution_x *= 2
        whole = self.still().of("RGB").reshape(high, 2 * wide, 3)
        self.scene.render.resolution_x, self.scene.render.pixel_aspect_x = wide, 2.0
        of_pairs = whole.reshape(high, wide, 2, 3).mean(axis=2)
        numpy.testing.assert_allclose(self.still().of("RGB").reshape(high, wide, 3), of_pairs, rtol=1e-5)
        render = self.scene.render
        render.use_border, render.use_crop_to_border = True, True
        render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.25, 0.75, 0.0, 0.5
        part = self.still().of("RGB").reshape(high // 2, wide // 2, 3)
        numpy.testing.assert_allclose(part.mean(), of_pairs[: high // 2, wide // 4 : 3 * wide // 4].mean(), rtol=0.02)

    def test_the_world_is_the_sky_unless_the_panel_says_otherwise(self):
        world = self.scene.world = bpy.data.worlds.new("grey")
        world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.25, 0.5, 0.75, 1.0)
        self.scene.objects["quad"].hide_render = True
        sky = self.still().of("RGB").reshape(-1, 3)
        numpy.testing.assert_allclose(sky, numpy.broadcast_to((0.25, 0.5, 0.75), sky.shape), rtol=1e-6)
        self.scene.sunfleck_settings.use_world = False
        self.assertEqual(self.still().of("RGB").max(), 0.0)

    def test_what_has_no_light_is_dark(self):
        """Though the program lights files that say nothing of any light."""
        bpy.data.objects.remove(self.scene.objects["sun"])
        for world in (None, bpy.data.worlds.new("black")):
            self.scene.world = world
            if world:
                world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.0, 0.0, 0.0, 1.0)
            self.assertEqual(self.still().of("RGB").max(), 0.0)

    def test_a_transparent_film_does_not_see_the_sky(self):
        world = self.scene.world = bpy.data.worlds.new("grey")
        world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.25, 0.5, 0.75, 1.0)
        self.still()
        seen = self.frame()
        self.scene.render.film_transparent = True
        self.still()
        unseen = self.frame()
        alpha = unseen.of(("A",))
        self.assertEqual((alpha.min(), alpha.max(), seen.of(("A",)).min()), (0.0, 1.0, 1.0))
        before, after = (one.of("RGB").reshape(-1, 3) for one in (seen, unseen))
        numpy.testing.assert_array_equal(after[alpha == 1.0], before[alpha == 1.0])
        self.assertEqual(after[alpha == 0.0].max(), 0.0)

    def test_an_opaque_film_is_opaque_over_a_black_world(self):
        for world in (None, bpy.data.worlds.new("black")):
            self.scene.world = world
            if world:
                world.use_nodes = True
                world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.0, 0.0, 0.0, 1.0)
            for is_transparent, least in ((False, 1.0), (True, 0.0)):
                self.scene.render.film_transparent = is_transparent
                self.assertEqual(self.still().of(("A",)).min(), least)

    def test_the_exposure_of_the_film_is_that_of_cycles(self):
        self.scene.render.use_persistent_data = True
        before = self.still().of("RGB").max()
        self.scene.cycles.film_exposure = 2.0
        self.assertAlmostEqual(self.still().of("RGB").max() / before, 2.0, 5)

    def test_a_film_on_a_leaf_shows_its_picture_of_the_frame(self):
        for frame in (1, 2):
            image = bpy.data.images.new("frame", 4, 4)
            image.pixels.foreach_set([*[0.2 * frame] * 3, 1.0] * 16)
            image.filepath_raw, image.file_format = str(self.folder / f"film_{frame}.png"), "PNG"
            image.save()
        material = self.scene.objects["quad"].data.materials[0]
        node = material.node_tree.nodes.new("ShaderNodeTexImage")
        node.image = bpy.data.images.load(str(self.folder / "film_1.png"))
        node.image.source, node.image_user.frame_duration, node.image_user.use_auto_refresh = "SEQUENCE", 2, True
        material.node_tree.links.new(node.outputs["Color"], material.node_tree.nodes["Principled BSDF"].inputs["Base Color"])
        self.scene.render.use_persistent_data = True
        # Codes 51 and 102 in sRGB.
        for frame, color in ((1, 0.0331), (2, 0.1329)):
            self.scene.frame_set(frame)
            self.still()
            file = max(exporting.folder().glob("*.glb"), key=os.path.getmtime)
            said = document(file)["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"]
            self.assertAlmostEqual(said[0], color, 4)

    def test_passes_that_nobody_renders_are_told(self):
        layer = self.scene.view_layers[0]
        layer.use_pass_z = layer.use_pass_normal = True
        self.assertEqual(passes.lacking(layer), [])
        layer.use_pass_mist = layer.cycles.use_pass_volume_direct = True
        layer.aovs.add().name = "mask"
        self.assertEqual(passes.lacking(layer), ["Mist", "Volume Direct", "mask"])

    def test_an_animation_has_every_frame(self):
        stages.moving(self.scene.objects["quad"])
        self.scene.frame_start, self.scene.frame_end, self.scene.frame_step = 2, 6, 2
        bpy.ops.render.render(animation=True)
        found = sorted(path.name for path in self.folder.glob("blender_*.exr"))
        self.assertEqual(found, ["blender_0002.exr", "blender_0004.exr", "blender_0006.exr"])
        last = picture.read(self.folder / found[-1])
        self.assert_same(last, self.frame())
        self.scene.frame_set(6)
        self.assert_same(self.still(), last)

    def test_a_region_is_that_part_of_the_picture(self):
        whole = self.still()
        render = self.scene.render
        render.use_border, render.use_crop_to_border = True, True
        render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.25, 0.75, 0.0, 0.5
        part = self.still()
        numpy.testing.assert_array_equal(part.pixels[..., :3], whole.pixels[9:, 8:24, :3])
        render.use_crop_to_border = False
        placed = self.still()
        self.assertEqual(placed.pixels.shape[:2], SIZE[::-1])
        numpy.testing.assert_array_equal(placed.pixels[9:, 8:24, :3], whole.pixels[9:, 8:24, :3])

    def test_passes_are_those_of_the_panel_and_of_the_view_layer(self):
        self.scene.sunfleck_settings.passes = {"shafts", "leaf-id", "albedo", "error"}
        layer = self.scene.view_layers[0]
        layer.use_pass_z = layer.use_pass_normal = layer.use_pass_position = True
        theirs, _ = self.all_passes()
        ours = self.frame()
        named = {"Depth.Z": "Z"} | {f"Combined.{channel}": channel for channel in "RGB"}
        named |= {f"shafts.{color}": f"shafts.{color}" for color in "RGB"}
        named |= {"leaf_id.X": "leaf_id.X", "error.Y": "error.Y"}
        for name, channel in named.items():
            numpy.testing.assert_array_equal(theirs[name], ours.pixels[..., ours.numbers[channel]], name)
        # In the program's frame y is up, in Blender z.
        for name in ("Normal", "Position"):
            for axis, channel, sign in (("X", "X", 1.0), ("Y", "Z", -1.0), ("Z", "Y", 1.0)):
                own = ours.pixels[..., ours.numbers[f"{name}.{channel}"]]
                numpy.testing.assert_array_equal(theirs[f"{name}.{axis}"], sign * own, f"{name}.{axis}")

    def all_passes(self):
        """Channels of all that Blender wrote of a frame, by their names without the view layer's, and metadata."""
        settings, found, said = self.scene.render.image_settings, {}, {}
        settings.media_type, settings.file_format = "MULTI_LAYER_IMAGE", "OPEN_EXR_MULTILAYER"
        self.still()
        bpy.utils.expose_bundled_modules()
        import OpenImageIO

        file, part = OpenImageIO.ImageInput.open(str(self.folder / "blender_.exr")), 0
        while file.seek_subimage(part, 0):
            names = [name.split(".", 1)[1] for name in file.spec().channelnames]
            pixels = file.read_image(OpenImageIO.FLOAT).reshape(*SIZE[::-1], -1)
            found.update((name, pixels[..., number]) for number, name in enumerate(names))
            said |= {one.name: one.value for one in file.spec().extra_attribs}
            part += 1
        file.close()
        return found, said

    def test_vectors_are_the_way_from_frame_to_frame(self):
        from bpy_extras.object_utils import world_to_camera_view

        scene, layer, quad = self.scene, self.scene.view_layers[0], self.scene.objects["quad"]
        stages.key(quad, "location", ((0.0, 0.0, 1.0), (0.2, 0.1, 1.3)), frames=(1, 3), interpolation="LINEAR")
        scene.frame_set(2)
        layer.use_pass_z = layer.use_pass_vector = layer.use_pass_position = layer.use_pass_normal = True
        found, _ = self.all_passes()
        self.assertEqual(scene.frame_current, 2)
        step, seen = mathutils.Vector((0.1, 0.05, 0.15)), numpy.argwhere(found["Depth.Z"] < 1e3)
        self.assertGreater(len(seen), 3)
        on_screen = lambda point: numpy.array(world_to_camera_view(scene, scene.camera, point)[:2]) * SIZE
        for row, column in seen:
            at = lambda name, axes: [float(found[f"{name}.{axis}"][row, column]) for axis in axes]
            point = mathutils.Vector(at("Position", "XYZ"))
            self.assertAlmostEqual(point.z, 1.15, places=4)
            self.assertGreater(at("Normal", "Z")[0], 0.0)
            before, here, after = (on_screen(point + way * step) for way in (-1, 0, 1))
            expected = [*(before - here), *(here - after)]
            numpy.testing.assert_allclose(at("Vector", "XYZW"), expected, rtol=0.02)

    def test_the_shutter_is_where_blender_has_it_and_the_frame_stays(self):
        scene = self.scene
        stages.moving(scene.objects["quad"])
        scene.render.use_motion_blur = True
        for position in ("START", "CENTER", "END"):
            scene.render.motion_blur_position = position
            scene.frame_set(3)
            blurred = self.still()
            self.assertEqual((scene.frame_current, scene.frame_subframe), (3, 0.0))
            self.assert_same(blurred, self.exported())

    def test_the_shutter_may_open_between_two_frames(self):
        scene = self.scene
        stages.moving(scene.objects["quad"])
        scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0
        found = []
        for frame, part, position in ((3, 0.5, "START"), (4, 0.0, "CENTER")):
            scene.render.motion_blur_position = position
            scene.frame_set(frame, subframe=part)
            found.append(self.still().of("RGB"))
            self.assertEqual((scene.frame_current, scene.frame_subframe), (frame, part))
        numpy.testing.assert_allclose(*found, atol=1e-3 * found[0].max())

    def exported(self):
        """The program's frame of the exporter's file of the frame at hand."""
        glb, own = self.folder / "scene.glb", self.folder / "own.exr"
        export.export(self.scene, glb, self.scene.frame_current)
        own.unlink(missing_ok=True)
        run = render.Run(PROGRAM, glb, own, [f"--size={SIZE[0]}x{SIZE[1]}"])
        self.assertEqual(run.wait(), 0, run.error())
        return picture.read(own)

    def test_a_cryptomatte_says_which_objects_it_has(self):
        self.scene.view_layers[0].use_pass_cryptomatte_object = True
        found, said = self.all_passes()
        # From the specification's own hash of the layer's name.
        self.assertEqual(f"{cryptomatte.hash_of(b'hello, world'):08x}", "149bbb7f")
        key = f"cryptomatte/{cryptomatte.hash_of(b'ViewLayer.CryptoObject'):08x}"[:19]
        self.assertEqual(said[f"{key}/name"], "ViewLayer.CryptoObject")
        number = int(json.loads(said[f"{key}/manifest"])["quad"], 16)
        bits = found["CryptoObject00.r"].view("u4")
        self.assertTrue((bits == number).any())

    def test_the_default_scene_is_as_bright_as_in_cycles(self):
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=False)
        scene = bpy.context.scene
        self.set_up(scene)
        scene.render.resolution_x, scene.render.resolution_y = 64, 36
        scene.sunfleck_settings.samples, scene.sunfleck_settings.bounces = 32, 2
        ours = self.still().of("RGB")
        scene.render.engine = "CYCLES"
        cycles = scene.cycles
        cycles.samples, cycles.use_denoising, cycles.use_adaptive_sampling, cycles.seed = 512, False, False, 1
        cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = 2
        cycles.sample_clamp_indirect = 0.0
        theirs = self.still().of("RGB")
        self.assertAlmostEqual(ours.mean() / theirs.mean(), 1.0, delta=0.005)

    def test_each_view_layer_shows_its_own(self):
        hidden = bpy.data.collections.new("hidden")
        self.scene.collection.children.link(hidden)
        quad = self.scene.objects["quad"]
        hidden.objects.link(quad)
        self.scene.collection.objects.unlink(quad)
        self.scene.sunfleck_settings.passes = {"albedo"}
        empty = self.scene.view_layers.new("empty")
        empty.layer_collection.children["hidden"].exclude = True
        with mock.patch.object(picture, "hand_over", side_effect=picture.hand_over) as handed:
            bpy.ops.render.render()
        light = {call.args[1]: call.args[2].of(("albedo.R",)).max() for call in handed.call_args_list}
        self.assertGreater(light["ViewLayer"], 0.0)
        self.assertEqual(light["empty"], 0.0)

    def test_of_a_turned_camera_nothing_else_is_written(self):
        # As in a Blender that has just started.
        inputs._as_new.clear()
        self.scene.render.use_persistent_data = True
        self.still()
        self.scene.camera.rotation_euler.z += 0.1
        self.scene.camera.data.lens *= 0.9
        with mock.patch.object(exporting, "anew", side_effect=AssertionError("exported anew")):
            turned = self.still()
        self.scene.render.use_persistent_data = False
        self.assert_same(self.still(), turned)

    def pictures_after(self, build, is_persistent):
        """Of a scene, and of the same after each of the steps that `build` gives."""
        scene = self.scene = stages.stage()
        stages.quad(scene)
        self.set_up(scene)
        steps = list(build(scene))
        scene.render.use_persistent_data = is_persistent
        found = [self.still()]
        for step in steps:
            step()
            with mock.patch.object(exporting, "anew", side_effect=exporting.anew) as anew:
                found.append(self.still())
            self.exports.append(anew.call_count)
        return found

    def assert_kept_as_made_anew(self, build, exports):
        """With persistent data all is as without, and each step has made so many exports."""
        self.exports = []
        anew = self.pictures_after(build, False)
        self.exports = []
        kept = self.pictures_after(build, True)
        self.assertEqual(set(self.exports), {exports})
        for before, one, other in zip([None, *kept], kept, anew):
            self.assert_same(one, other)
            self.assertFalse(before is not None and numpy.array_equal(before.pixels, one.pixels))

    def test_of_lights_and_of_what_moves_no_mesh_is_looked_at_again(self):
        def build(scene):
            lamp = scenes.add(scene, "lamp", bpy.data.lights.new("lamp", "AREA"), (0.0, -1.0, 2.0), (0.0, 0.0, 0.0))
            lamp.data.energy, lamp.data.size = 20.0, 0.5
            sun, scene.cycles.film_exposure = scene.objects["sun"], 1.5
            stages.moving(scene.objects["quad"])
            yield lambda: setattr(sun.data, "energy", 0.5)
            yield lambda: setattr(lamp.data, "energy", 80.0)
            yield lambda: setattr(sun.data, "color", (1.0, 0.5, 0.2))
            yield lambda: setattr(lamp.data, "color", (0.2, 0.5, 1.0))
            yield lambda: setattr(sun.rotation_euler, "x", 0.3)
            yield lambda: setattr(lamp.location, "x", 0.4)
            yield lambda: scene.frame_set(3)
            yield lambda: setattr(sun.data, "energy", 1.5)
            # One that instances alone show.
            hidden, shows = bpy.data.collections.new("lamps"), bpy.data.objects.new("lamps", None)
            inner = bpy.data.objects.new("inner", bpy.data.lights.new("inner", "POINT"))
            hidden.objects.link(inner)
            shows.instance_type, shows.instance_collection, shows.location = "COLLECTION", hidden, (0.3, -1.0, 2.0)
            scene.collection.objects.link(shows)
            yield lambda: setattr(inner.data, "energy", 90.0)
            yield lambda: setattr(shows.location, "x", -0.6)

        self.assert_kept_as_made_anew(build, 0)

    def test_an_instance_of_an_area_light_has_the_power_of_its_own_area(self):
        def build(scene):
            hidden, shows = bpy.data.collections.new("lamps"), scenes.add(scene, "lamps", None, (0.3, -1.0, 2.0))
            lamp = bpy.data.objects.new("lamp", bpy.data.lights.new("lamp", "AREA"))
            lamp.data.energy, lamp.data.normalize = 20.0, False
            hidden.objects.link(lamp)
            shows.instance_type, shows.instance_collection, shows.scale = "COLLECTION", hidden, (0.5, 0.5, 0.5)
            yield lambda: setattr(lamp.data, "energy", 90.0)
            yield lambda: setattr(shows, "scale", (0.7, 0.7, 0.7))

        self.assert_kept_as_made_anew(build, 1)

    def test_what_else_has_changed_is_exported_anew(self):
        def build(scene):
            quad, other = scene.objects["quad"], stages.quad(scene, "other")
            other.location = (0.4, 0.0, 0.5)
            fog = scenes.fog_box(scene)
            stages.key(other, "hide_render", (False, True), frames=(1, 3))
            scene.frame_set(1)
            clay = bpy.data.materials.new("clay")
            color = quad.data.materials[0].node_tree.nodes["Principled BSDF"].inputs["Base Color"]
            yield lambda: setattr(scene.sunfleck_settings, "samples", 3)
            yield lambda: scene.frame_set(3)
            yield lambda: quad.data.vertices[0].co.__setitem__(2, 0.4) or quad.data.update()
            yield lambda: setattr(color, "default_value", (0.0, 1.0, 0.0, 1.0))
            yield lambda: setattr(scene.view_layers[0], "material_override", clay)
            yield lambda: scene.frame_set(1)
            yield lambda: setattr(other.location, "x", math.nan)
            yield lambda: setattr(fog, "scale", (0.0, 0.0, 0.0))

        self.assert_kept_as_made_anew(build, 1)

    def test_an_animation_has_all_that_is_keyed(self):
        """Of materials, the world, fog and lights, whichever of them the graph that renders does not change."""
        scene = self.scene
        world = scene.world = bpy.data.worlds.new("world")
        lamp = scenes.add(scene, "lamp", bpy.data.lights.new("lamp", "AREA"), (0.0, -1.0, 2.0), (0.0, 0.0, 0.0))
        fog = scenes.fog_box(scene)
        color = scene.objects["quad"].data.materials[0].node_tree.nodes["Principled BSDF"].inputs["Base Color"]
        strength = world.node_tree.nodes["Background"].inputs["Strength"]
        for owner, path, values in (
            (color, "default_value", ((0.1, 0.1, 0.1, 1.0), (0.9, 0.5, 0.1, 1.0))), (strength, "default_value", (0.1, 1.0)),
            (lamp.data, "energy", (1.0, 50.0)), (fog.sunfleck_settings, "density", (0.01, 0.3)),
        ):
            stages.key(owner, path, values, frames=(1, 3))
        scene.frame_start, scene.frame_end = 1, 3
        for scene.render.use_persistent_data in (False, True):
            scene.frame_set(1)
            bpy.ops.render.render(animation=True)
            found = [picture.read(self.folder / f"blender_{frame:04}.exr") for frame in (1, 2, 3)]
            for frame, one in zip((1, 2, 3), found):
                scene.frame_set(frame)
                self.assert_same(one, self.exported())

    def test_a_later_frame_first_has_its_simulation(self):
        emitter = stages.grid(self.scene, "emitter")
        emitter.location.z = 2.0
        settings = emitter.modifiers.new("leaves", "PARTICLE_SYSTEM").particle_system.settings
        settings.count, settings.frame_start, settings.frame_end, settings.lifetime = 50, 1, 3, 100
        settings.render_type, settings.instance_object, settings.particle_size = "OBJECT", self.scene.objects["quad"], 0.3
        emitter.show_instancer_for_render = False
        self.scene.frame_set(4)
        first = self.still()
        self.scene.frame_start, self.scene.frame_end = 1, 4
        bpy.ops.render.render(animation=True)
        self.assert_same(picture.read(self.folder / "blender_0004.exr"), first)

    def test_vectors_of_a_simulation_are_there_before_its_next_frame_was_shown(self):
        scene = self.scene = leaf_scenes.build("simulation")
        scene.camera.location.z = 3.9
        self.set_up(scene)
        scene.frame_set(5)
        layer = scene.view_layers[0]
        layer.use_pass_z = layer.use_pass_position = layer.use_pass_vector = True
        found, _ = self.all_passes()
        # Leaves fall above the ground, equally fast in all frames.
        falls = (found["Depth.Z"] < 1e3) & (found["Position.Z"] > 1.0)
        self.assertTrue(falls.any())
        self.assertTrue((found["Vector.Y"][falls] > 0.0).all())
        numpy.testing.assert_allclose(found["Vector.W"][falls], found["Vector.Y"][falls], rtol=0.05)

    def test_blur_of_a_simulation_is_the_same_whatever_was_shown_before(self):
        scene = self.scene = leaf_scenes.build("simulation")
        self.set_up(scene)
        scene.camera.location.z, scene.render.use_motion_blur, scene.render.motion_blur_shutter = 3.9, True, 1.0
        scene.frame_set(5)
        exported = self.exported()
        first = self.still()
        self.assert_same(exported, first)
        for frame in (1, 2, 3, 4, 5, 6, 7, 5):
            scene.frame_set(frame)
        self.assert_same(self.still(), first)

    def test_nodes_are_baked_while_blender_renders(self):
        tree = self.scene.objects["quad"].data.materials[0].node_tree
        noise = tree.nodes.new("ShaderNodeTexNoise")
        tree.links.new(noise.outputs["Color"], tree.nodes["Principled BSDF"].inputs["Base Color"])
        baked = self.still()
        self.assert_same(baked, self.exported())

    def test_what_stands_in_the_way_is_an_error_of_blenders(self):
        self.scene.objects["sun"].data.energy = -1.0
        with self.assertRaisesRegex(RuntimeError, "power is negative") as told:
            bpy.ops.render.render()
        self.assertEqual(str(told.exception).count("power is negative"), 1)
        self.scene.objects["sun"].data.energy = 1.0
        with mock.patch.dict(os.environ, {"SUNFLECK": "/nowhere/sunfleck"}), self.assertRaisesRegex(RuntimeError, "not found"):
            bpy.ops.render.render()
        with mock.patch.object(picture, "read", side_effect=KeyError("lost")), self.assertRaisesRegex(RuntimeError, "KeyError"):
            bpy.ops.render.render()

    def test_pictures_come_while_the_program_renders(self):
        self.scene.sunfleck_settings.samples = 64
        with mock.patch.object(picture, "show", side_effect=picture.show) as shown:
            with mock.patch.multiple(engine, LOOK_S=0.0, SHOWN_SHARE=1.0):
                whole = self.still()
        looks = [call.args for call in shown.call_args_list]
        self.assertEqual({(layer, so_far.pixels.shape) for _, layer, so_far in looks}, {("ViewLayer", (*SIZE[::-1], 4))})
        # The first is rough: of 4 x 3 pixels.
        finer = [so_far for _, _, so_far in looks if len(numpy.unique(so_far.pixels.reshape(-1, 4), axis=0)) > 12]
        self.assertGreater(len(finer), 0)
        for so_far in finer:
            self.assertAlmostEqual(so_far.of("RGB").mean() / whole.of("RGB").mean(), 1.0, delta=0.1)
        self.assert_same(whole, self.frame())

    def test_what_is_no_picture_ends_the_looking_alone(self):
        one = looking.Look(*SIZE)
        with socket.create_connection(one.listener.getsockname()) as sender:
            sender.sendall(b"\x0a\0\0\0\x06 none")
        one.thread.join(10.0)
        self.assertIsNone(one.newest())
        one.close()
        with mock.patch.object(socket, "create_server", side_effect=PermissionError):
            self.assertGreater(self.still().of("RGB").max(), 0.0)

    def test_esc_ends_the_program(self):
        own = self.scene.sunfleck_settings
        own.samples, own.all_bounces = 65536, True
        with mock.patch.object(engine.SUNFLECK_RENDER_engine, "is_stopped", lambda _: processes() != []):
            with mock.patch.object(picture, "hand_over") as handed:
                bpy.ops.render.render()
        handed.assert_not_called()
        self.assertEqual(processes(), [])

    def test_esc_ends_an_export(self):
        for number in range(20):
            stages.quad(self.scene, f"quad {number}")
        looks = iter([False] * 3)
        with mock.patch.object(engine.SUNFLECK_RENDER_engine, "is_stopped", lambda _: next(looks, True)):
            with mock.patch.object(exporting, "started") as started, mock.patch.object(Document, "write") as written:
                bpy.ops.render.render()
        started.assert_not_called()
        written.assert_not_called()
        self.assertGreater(self.still().of("RGB").max(), 0.0)

    def test_esc_is_heard_within_a_large_mesh(self):
        """By this thread's own time, as others may have the processors."""
        count, sides = 400, numpy.linspace(-1.0, 1.0, 400)
        places = numpy.stack([*numpy.meshgrid(sides, sides), numpy.zeros((count, count))], -1).reshape(-1, 3)
        first = (numpy.arange(count - 1)[:, None] * count + numpy.arange(count - 1)).ravel()
        mesh = bpy.data.meshes.new("large")
        mesh.from_pydata(places, [], numpy.stack([first, first + 1, first + count + 1, first + count], 1))
        mesh.uv_layers.new(name="UVMap")
        mesh.materials.append(self.scene.objects["quad"].data.materials[0])
        scenes.add(self.scene, "large", mesh)
        times = []
        with mock.patch.object(engine.SUNFLECK_RENDER_engine, "is_stopped", lambda _: times.append(time.thread_time())):
            self.still()
        self.assertLess(max(numpy.diff(times)), 0.1)

    def test_esc_is_heard_between_bakes(self):
        """Nothing that was made for them is left."""
        tree = self.scene.objects["quad"].data.materials[0].node_tree
        shader, noise = tree.nodes["Principled BSDF"], tree.nodes.new("ShaderNodeTexNoise")
        for name in ("Base Color", "Roughness", "Emission Color"):
            tree.links.new(noise.outputs[0], shader.inputs[name])
        shader.inputs["Emission Strength"].default_value = 1.0
        there = lambda: {
            one.name for kind in ("materials", "meshes", "images", "scenes") for one in getattr(bpy.data, kind)
        } - {"Render Result"}
        before, baked, one = there(), [], numpy.zeros((256, 256, 3))
        with mock.patch.object(bake.Stage, "bake", lambda _, kind: baked.append(kind) or one):
            with mock.patch.object(engine.SUNFLECK_RENDER_engine, "is_stopped", lambda _: baked != []):
                with mock.patch.object(exporting, "started") as started:
                    bpy.ops.render.render()
        started.assert_not_called()
        self.assertEqual((len(baked), there()), (1, before))

    def test_a_viewport_shows_a_change_before_its_light_is_solved(self):
        graph, camera, shown = bpy.context.evaluated_depsgraph_get(), self.scene.camera, Viewport()
        window = camera.calc_matrix_camera(graph, x=SIZE[0], y=SIZE[1])
        view = View(SIZE, camera.matrix_world.inverted(), window, True)
        turned = View(SIZE, view.from_world @ numpy.diag((-1.0, 1.0, -1.0, 1.0)), window, True)
        with mock.patch.object(service.Service, "render", autospec=True, side_effect=service.Service.render) as asked:
            shown.changed(graph)
            for one in (view, turned):
                shown.look(one)
                while shown.poll():
                    pass
        self.addCleanup(shown.close)
        self.assertEqual((shown.number, shown.problem), (2 * len(STAGES), ""))
        is_direct = ["--bounces=0" in call.args[1] for call in asked.call_args_list]
        self.assertEqual(is_direct, [True] + [False] * (2 * len(STAGES) - 1))

    def test_a_viewport_sees_shifted_as_its_camera_does(self):
        camera = self.scene.camera
        for camera.data.type in ("PERSP", "ORTHO"):
            camera.data.shift_x, camera.data.shift_y = 0.15, -0.1
            graph = bpy.context.evaluated_depsgraph_get()
            matrices = camera.matrix_world.inverted(), camera.calc_matrix_camera(graph, x=SIZE[0], y=SIZE[1])
            lens = View(SIZE, *matrices, camera.data.type == "PERSP").lens()
            numpy.testing.assert_allclose(lens["extras"]["sunfleck_camera"]["shift"], (0.15, -0.1), atol=1e-6)

    def test_a_viewport_shows_what_the_camera_sees(self):
        graph = bpy.context.evaluated_depsgraph_get()
        camera, shown = self.scene.camera, Viewport()
        matrices = camera.matrix_world.inverted(), camera.calc_matrix_camera(graph, x=SIZE[0], y=SIZE[1])
        shown.changed(graph)
        shown.look(View(SIZE, *matrices, True))
        sizes = []
        while shown.poll():
            if shown.shown is not None and shown.number > len(sizes):
                sizes.append(shown.shown.pixels.shape[:2])
        self.assertEqual((sizes[0], shown.number), ((4, 8), len(STAGES)))
        self.scene.sunfleck_settings.samples = 16
        whole = self.still()
        numpy.testing.assert_allclose(shown.shown.pixels[..., :3], whole.pixels[..., :3], atol=0.02)
        turned = View(SIZE, matrices[0] @ matrices[0].Rotation(0.2, 4, "Z"), matrices[1], True)
        shown.look(turned)
        self.assertIsNotNone(shown.run)
        shown.service.process.kill()
        shown.service.process.wait()
        shown.look(View(SIZE, *matrices, True))
        while shown.poll():
            pass
        self.assertEqual((shown.number, shown.problem), (2 * len(STAGES), ""))
        shown.close()
        self.assertEqual(processes(), [])

    def test_of_a_light_a_viewport_looks_at_no_mesh_again(self):
        shown, sun = Viewport(), self.scene.objects["sun"]
        shown.changed(bpy.context.evaluated_depsgraph_get())
        # What is new in the graph has been told.
        sun.update_tag()
        bpy.context.view_layer.update()
        before = shown.path.read_bytes()
        for change in (lambda: setattr(sun.data, "energy", 0.3), lambda: setattr(self.scene.objects["quad"].location, "x", 0.2)):
            seen = []
            looks = lambda scene, graph: seen.append(shown.changed(graph))
            bpy.app.handlers.depsgraph_update_post.append(looks)
            try:
                with mock.patch.object(Viewport, "anew", side_effect=AssertionError("looked at again")):
                    change()
                    bpy.context.view_layer.update()
            finally:
                bpy.app.handlers.depsgraph_update_post.remove(looks)
            self.assertEqual(len(seen), 1)
            self.assertNotEqual(before, before := shown.path.read_bytes())
        fresh = Viewport()
        fresh.changed(bpy.context.evaluated_depsgraph_get())
        self.assertEqual(nodes_of(fresh.path), nodes_of(shown.path))

    def test_a_viewport_that_is_drawn_goes_on_until_it_is_done(self):
        graph = bpy.context.evaluated_depsgraph_get()
        camera, drawn, redraws = self.scene.camera, [], []

        class Draws:
            """What of Blender's engine needs a window."""

            shown_in_viewport = engine.SUNFLECK_RENDER_engine.shown_in_viewport
            report = update_stats = lambda *_: None
            tag_redraw = lambda self: redraws.append(1)
            draw_picture = lambda self, scene, shown, size: drawn.append(shown.number)

        looks = SimpleNamespace(
            region=SimpleNamespace(width=SIZE[0], height=SIZE[1]),
            region_data=SimpleNamespace(
                view_matrix=camera.matrix_world.inverted(), is_perspective=True,
                window_matrix=camera.calc_matrix_camera(graph, x=SIZE[0], y=SIZE[1]),
            ),
        )  # fmt: skip
        one = Draws()
        engine.SUNFLECK_RENDER_engine.view_update(one, looks, graph)
        while not drawn or len(redraws) == len(drawn):
            engine.SUNFLECK_RENDER_engine.view_draw(one, looks, graph)
        self.assertEqual(drawn[-1], len(STAGES))
        before = len(redraws)
        engine.SUNFLECK_RENDER_engine.view_draw(one, looks, graph)
        self.assertEqual(len(redraws), before)

    def test_many_renders_leave_memory_as_it_is(self):
        resident = lambda: int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
        self.scene.render.resolution_x, self.scene.render.resolution_y = 8, 8
        for _ in range(3):
            bpy.ops.render.render()
        before = resident()
        for _ in range(12):
            bpy.ops.render.render()
        self.assertLess(resident() - before, 8 << 20)


if __name__ == "__main__":
    unittest.main()
