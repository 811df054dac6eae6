"""Custom properties that exports leave behind, names that two things share, and losses of what only nodes show.

Run with the other tests here (test_addon.py says how).
"""

import contextlib
import io
import math
import subprocess
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import bpy
import scenes
from sunfleck import check, command, export, extras, stored, world, world_picture, world_rays
from sunfleck.engine import passes
from sunfleck.evaluated import scenes as scenes_of_export
from sunfleck.evaluated import walk
from sunfleck.evaluated.capture import own_materials
from sunfleck.evaluated.document import Document
from sunfleck.frames import NUMBERED
from sunfleck.losses import Finding
from test_addon import PROGRAM, Case, document


def light(kind):
    data = bpy.data.lights.new("lamp", kind)
    lamp = bpy.data.objects.new("lamp", data)
    bpy.context.scene.collection.objects.link(lamp)
    return lamp


class Slots(Case):
    def test_things_that_share_a_mesh_have_their_own_materials_in_their_own_slots(self):
        red = bpy.data.materials.new("red")
        mesh = scenes.quad(self.scene, "quad", 1.0, None).data
        for _ in range(2):
            mesh.materials.append(bpy.data.materials.new("leaf"))
        things = [bpy.data.objects.new(name, mesh) for name in ("first", "second")]
        for index, thing in enumerate(things):
            self.scene.collection.objects.link(thing)
            thing.material_slots[index].link, thing.material_slots[index].material = "OBJECT", red
        keys = [own_materials(thing.evaluated_get(bpy.context.evaluated_depsgraph_get())) for thing in things]
        self.assertEqual(keys, [((0, "red"),), ((1, "red"),)])


class Left(Case):
    def said(self, owner):
        return {**stored.by_hand(owner), **extras.of_object(owner, self.scene)}

    def test_what_is_unticked_is_gone_though_an_export_wrote_it(self):
        box = scenes.quad(self.scene, "quad", 1.0, None)
        box["own"], box.sunfleck_settings.is_fog = 7, True
        extras.store(self.scene)
        self.assertIn("sunfleck_fog_volume", box)
        box.sunfleck_settings.is_fog = False
        self.assertEqual(self.said(box), {"own": 7})
        self.assertFalse(stored.is_by_hand(box, "sunfleck_fog_volume"))

    def test_a_light_of_another_kind_keeps_what_is_written_by_hand_alone(self):
        lamp = light("AREA")
        lamp["sunfleck_light"] = {"my_field": 3}
        extras.store(self.scene)
        lamp.data.type = "POINT"
        fresh = extras.light(lamp, 1.0)
        self.assertEqual(self.said(lamp)["sunfleck_light"], {"my_field": 3, **fresh})

    def test_a_field_by_hand_stays_though_an_earlier_add_on_stored_names_of_whole_properties(self):
        lamp = light("AREA")
        lamp["sunfleck_light"] = {**extras.light(lamp, 1.0), "casts_shafts": False}
        lamp.sunfleck_settings.stored = "sunfleck_light"
        lamp.data.type = "POINT"
        for _ in range(2):
            self.assertEqual(self.said(lamp)["sunfleck_light"], {"casts_shafts": False, **extras.light(lamp, 1.0)})
            extras.store(self.scene)

    def test_a_light_may_have_any_property_by_hand(self):
        lamp, empty = light("POINT"), scenes.add(self.scene, "empty", None)
        lamp["sunfleck_light"] = empty["sunfleck_light"] = 3
        self.assertEqual(self.said(lamp)["sunfleck_light"], extras.light(lamp, 1.0))
        export.exported(self.scene, self.folder / "scene.glb")

    def test_a_sky_by_hand_stays(self):
        self.scene["sunfleck_env"] = {"color": [0.1, 0.2, 0.3], "strength": 1.0}
        extras.store(self.scene)
        self.assertEqual(list(self.scene["sunfleck_env"]["color"]), [0.1, 0.2, 0.3])


class Names(Case):
    def test_suns_in_other_scripts_have_files_of_their_own(self):
        image = bpy.data.images.new("disc", 2, 2)
        names = {world.on_the_sun(image, self.folder / "s.glb", name) for name in ("太陽", "月", "sun.001", "sun 001", "sun")}
        self.assertEqual(len(names), 5)
        self.assertIn("s_sun.png", names)

    def test_the_camera_that_renders_is_the_one_in_the_file(self):
        eye, library = scenes.camera(self.scene), self.folder / "lib.blend"
        bpy.data.libraries.write(str(library), {eye})
        with bpy.data.libraries.load(str(library), link=True) as (_, wanted):
            wanted.objects = [eye.name]
        linked = wanted.objects[0]
        self.scene.collection.objects.link(linked)
        self.assertEqual(linked.name, eye.name)
        self.scene.camera = linked
        path = self.folder / "scene.glb"
        export.export(self.scene, path)
        said = document(path)
        nodes = [node["name"] for node in said["nodes"] if "camera" in node]
        self.assertEqual(len(set(nodes)), 2)
        self.assertEqual(said["scenes"][0]["extras"]["sunfleck"]["camera"], "camera 2")


class Unseen(Case):
    def test_losses_of_what_only_nodes_show_are_told(self):
        apart = bpy.data.collections.new("apart")
        lamp = bpy.data.objects.new("spot", bpy.data.lights.new("spot", "SPOT"))
        lamp.data.use_square = True
        apart.objects.link(lamp)
        host = scenes.quad(self.scene, "quad", 1.0, None)
        group = bpy.data.node_groups.new("shows", "GeometryNodeTree")
        for side in ("INPUT", "OUTPUT"):
            group.interface.new_socket("Geometry", in_out=side, socket_type="NodeSocketGeometry")
        of, out = group.nodes.new("GeometryNodeCollectionInfo"), group.nodes.new("NodeGroupOutput")
        of.inputs["Collection"].default_value = apart
        group.links.new(of.outputs["Instances"], out.inputs[0])
        host.modifiers.new("shows", "NODES").node_group = group
        self.assertNotIn("light-square", {one.id for one in check.check(self.scene)})
        self.assertIn("light-square", {one.id for one in export.exported(self.scene, self.folder / "a.glb").findings})


    def test_a_scene_without_a_camera_is_exported_all_the_same(self):
        self.scene.camera = None
        path = self.folder / "scene.glb"
        self.assertIn("no-camera", {one.id for one in export.exported(self.scene, path).findings})
        self.assertFalse([node for node in document(path).get("nodes", []) if "camera" in node])


class Refused(Case):
    def test_a_lamp_is_no_camera(self):
        self.scene.camera = light("SPOT")
        with self.assertRaisesRegex(export.NotExportable, "camera-other"):
            export.export(self.scene, self.folder / "scene.glb")

    def test_scenes_of_one_file_have_folders_of_their_own(self):
        path = self.folder / "shots.blend"
        bpy.ops.wm.save_as_mainfile(filepath=str(path))
        self.assertEqual(export.default_folder(bpy.context.scene), self.folder / "sunfleck/shots")
        second = bpy.data.scenes.new("second")
        folders = {export.default_folder(scene) for scene in bpy.data.scenes}
        self.assertEqual((len(folders), export.default_folder(second).name), (2, "shots_second"))

    def test_without_a_layer_that_renders_it_says_so(self):
        scenes.camera(self.scene)
        self.scene.view_layers[0].use = False
        with self.assertRaisesRegex(export.NotExportable, "no view layer renders"):
            export.export(self.scene, self.folder / "scene.glb")

    def test_what_is_refused_leaves_the_earlier_file(self):
        path, refused = self.folder / "scene.glb", [Finding("camera-other", "`seen`")]
        path.write_bytes(b"earlier")
        with mock.patch.object(check, "of_shown", return_value=refused), self.assertRaisesRegex(export.NotExportable, "camera-other"):
            export.export(self.scene, path)
        self.assertEqual(path.read_bytes(), b"earlier")

    def test_a_file_is_written_whole_or_not_at_all(self):
        made, path = Document(), self.folder / "scene.glb"
        path.write_bytes(b"earlier")
        with mock.patch.object(Path, "replace", side_effect=OSError(28, "No space left on device")):
            with self.assertRaisesRegex(OSError, "scene.glb cannot be written: No space left"):
                made.write(path)
        self.assertEqual([one.name for one in self.folder.iterdir()], ["scene.glb"])
        self.assertEqual(path.read_bytes(), b"earlier")


class Broken(Case):
    def test_what_is_no_number_is_left_out_by_name(self):
        quads = [scenes.quad(self.scene, name, 1.0, None) for name in ("whole", "bent", "lost")]
        scenes.camera(self.scene)
        quads[1].data.vertices[0].co.x = quads[2].location.x = math.nan
        path = self.folder / "scene.glb"
        found = {(one.id, one.of) for one in export.exported(self.scene, path).findings}
        self.assertEqual({of for id, of in found if id == "not-finite"}, {"`bent`", "`lost`"})
        self.assertEqual([node["name"] for node in document(path)["nodes"] if "mesh" in node], ["whole"])

    def test_a_world_that_tells_the_camera_apart_is_settled_again_and_again(self):
        seen = bpy.data.worlds.new("world")
        if not seen.node_tree:
            seen.use_nodes = True
        tree = seen.node_tree
        path, mix = tree.nodes.new("ShaderNodeLightPath"), tree.nodes.new("ShaderNodeMixShader")
        for at in (1, 2):
            tree.links.new(tree.nodes.new("ShaderNodeBackground").outputs[0], mix.inputs[at])
        tree.links.new(path.outputs["Is Camera Ray"], mix.inputs[0])
        tree.links.new(mix.outputs[0], tree.get_output_node("CYCLES").inputs["Surface"])
        for _ in range(50):
            for is_camera in (False, True):
                with world_rays.seen_by(seen, is_camera) as copy:
                    output = copy.node_tree.get_output_node("CYCLES").inputs["Surface"]
                    self.assertEqual(output.links[0].from_node.type, "BACKGROUND")


class Cuts(Case):
    def test_the_shutter_of_a_frame_has_the_frames_camera(self):
        eyes = [scenes.camera(self.scene, (x, -6.0, 2.0)) for x in (0.0, 4.0)]
        for frame, eye in zip((1, 3), eyes):
            self.scene.timeline_markers.new(str(frame), frame=frame).camera = eye
        self.scene.frame_end, self.scene.render.use_motion_blur = 4, True
        self.scene.render.motion_blur_shutter, self.scene.render.motion_blur_position = 0.5, "CENTER"
        with scenes_of_export.Job(self.scene) as job:
            walk.walk(self.scene, job.frames, job.shutter, job)
            views = sorted(job.values.views, key=lambda view: view.time)
        self.assertEqual(
            [(view.time, view.matrix[0, 3]) for view in views],
            [(frame + part, 0.0 if frame < 3 else 4.0) for frame in range(1, 5) for part in (-0.25, 0.0, 0.25)],
        )


class Held(Case):
    def setUp(self):
        super().setUp()
        render = self.scene.render
        render.use_motion_blur, render.motion_blur_shutter, render.motion_blur_position = True, 0.5, "CENTER"

    def walked(self):
        with scenes_of_export.Job(self.scene) as job:
            walk.walk(self.scene, job.frames, job.shutter, job)
        return job

    def test_hair_with_the_name_of_its_mesh_is_held_apart_from_it(self):
        quad = scenes.quad(self.scene, "quad", 1.0, None)
        quad.modifiers.new("Fur", "PARTICLE_SYSTEM")
        system, quad.data.name = quad.particle_systems[0], "Fur"
        system.name, system.settings.type, system.settings.count = "Fur", "HAIR", 4
        quad.cycles.use_deform_motion = False
        shown = [thing.shown for thing in self.walked().record.things.values()]
        self.assertEqual([len(set(one)) for one in shown], [1, 1])
        self.assertNotEqual(shown[0][0], shown[1][0])

    def test_a_camera_that_is_nowhere_at_the_frame_is_not_held(self):
        eyes = [scenes.camera(self.scene, (x, -6.0, 2.0)) for x in (0.0, 4.0)]
        self.scene.frame_end = 2
        for frame, eye in enumerate(eyes, 1):
            self.scene.timeline_markers.new(str(frame), frame=frame).camera = eye
        eyes[1].cycles.use_motion_blur = False
        # Times the parent's scale that is more than single precision holds.
        eyes[1].driver_add("location", 2).driver.expression = "1e30 if frame == 2 else 2"
        eyes[1].parent = scenes.add(self.scene, "large", None)
        eyes[1].parent.scale = (1e20,) * 3
        self.assertEqual({int(round(view.time)) for view in self.walked().values.views}, {1})


class Moving(Case):
    def test_a_world_that_is_looked_up_from_an_object_is_another_once_that_has_moved(self):
        eye = scenes.add(self.scene, "eye", None)
        self.scene.world = seen = bpy.data.worlds.new("world")
        if not seen.node_tree:
            seen.use_nodes = True
        node = seen.node_tree.nodes.new("ShaderNodeTexCoord")
        node.object = eye
        background = next(one for one in seen.node_tree.nodes if one.type == "BACKGROUND")
        seen.node_tree.links.new(node.outputs["Object"], background.inputs["Color"])
        keys = [world_picture.key_of(seen, self.scene.frame_current_final)]
        eye.rotation_euler.z = 1.0
        bpy.context.view_layer.update()
        keys.append(world_picture.key_of(seen, self.scene.frame_current_final))
        self.assertFalse(world.changes(self.scene))
        eye.keyframe_insert("rotation_euler", frame=1)
        self.assertTrue(world.changes(self.scene))
        for frame in (1, 2):
            self.scene.frame_set(frame)
            keys.append(world_picture.key_of(seen, self.scene.frame_current_final))
        self.assertEqual(len(set(keys)), 4)

    def test_a_sky_of_a_film_is_that_of_the_frame(self):
        for frame in (1, 2):
            image = bpy.data.images.new("shade", 4, 2, float_buffer=True)
            image.pixels.foreach_set([0.25 * frame, 0.0, 0.0, 1.0] * 8)
            image.file_format, image.filepath_raw = "OPEN_EXR", str(self.folder / f"film_{frame:04}.exr")
            image.save()
        self.scene.world = seen = bpy.data.worlds.new("world")
        if not seen.node_tree:
            seen.use_nodes = True
        tree = seen.node_tree
        film = tree.nodes.new("ShaderNodeTexEnvironment")
        film.image = bpy.data.images.load(str(self.folder / "film_0001.exr"))
        film.image.source, film.image_user.frame_duration, film.image_user.use_auto_refresh = "SEQUENCE", 2, True
        background = next(one for one in tree.nodes if one.type == "BACKGROUND")
        tree.links.new(film.outputs["Color"], background.inputs["Color"])
        view = world_picture.View((16, 8), 1)
        for frame in (1, 2):
            self.scene.frame_set(frame)
            # No scene has the copy.
            found = world_picture.pixels(seen.copy(), self.scene.frame_current_final, view)
            self.assertAlmostEqual(found[4, 8, 0], 0.25 * frame, 3)
        self.assertFalse(world_picture.is_known(seen, self.folder / "film_0001.exr"))
        self.assertTrue(world.changes(self.scene))

    def test_fog_of_the_world_is_missed_where_the_panels_is_switched_on(self):
        self.scene.world = seen = bpy.data.worlds.new("world")
        if not seen.node_tree:
            seen.use_nodes = True
        tree = seen.node_tree
        scatter = tree.nodes.new("ShaderNodeVolumeScatter")
        tree.links.new(scatter.outputs[0], tree.get_output_node("CYCLES").inputs["Volume"])
        own, self.scene.frame_end = self.scene.sunfleck_settings, 2
        for switched in (False, True):
            own.use_fog = False
            for frame in (1, 2) if switched else ():
                own.use_fog = frame == 2
                own.keyframe_insert("use_fog", frame=frame)
            found = {(one.id, one.of) for one in export.exported(self.scene, self.folder / "scene.glb").findings}
            self.assertEqual(("settings-change", "`volume` of the world") in found, switched)

    def test_fog_without_a_side_is_not_there(self):
        box = scenes.add(self.scene, "box", None)
        box.sunfleck_settings.is_fog = True
        self.scene.frame_end = 3
        for frame, side in ((1, 1.0), (3, 0.0)):
            box.scale = (side,) * 3
            box.keyframe_insert("scale", frame=frame)
        path = self.folder / "scene.glb"
        export.export(self.scene, path)
        with tempfile.TemporaryDirectory() as frames:
            command = [PROGRAM, "render", str(path), "--frames", "3", "--size", "4x2", "--samples", "1", "--out", f"{frames}/"]
            ended = subprocess.run(command, capture_output=True, text=True)
        self.assertEqual(ended.returncode, 0, ended.stderr)


class Numbers(unittest.TestCase):
    def test_a_dash_after_text_is_no_sign(self):
        for name, number in (("leaf-0001", 1), ("leaf.-0003", -3), ("-2", -2), ("leaf_12", 12), ("leaf7", 7)):
            self.assertEqual(int(NUMBERED.match(f"{name}.exr")[2]), number, name)


class Command(Case):
    def main(self, *words):
        with contextlib.redirect_stderr(io.StringIO()) as told:
            code = command.main([str(word) for word in words])
        return code, told.getvalue()

    def test_names_that_cannot_be_are_refused_in_words(self):
        taken = self.folder / "taken"
        taken.write_text("")
        for words, part in (
            (("render", "--folder", taken), "cannot be made"),
            (("export", self.folder / "scene.gltf"), "let it end in .glb"),
            (("render", "--out", "x.exr"), "--folder, not --out"),
        ):
            code, told = self.main(*words)
            self.assertNotEqual(code, 0)
            self.assertIn(part, told)

    def test_a_border_is_of_the_size_that_is_rendered(self):
        self.scene.render.resolution_x, self.scene.render.resolution_y = 33, 18
        for words, size in (("--size 50%", (17, 9)), ("--size=64x36", (64, 36)), ("--samples 3", None)):
            self.assertEqual(command.size_of(words.split(), self.scene), size)


class Passes(unittest.TestCase):
    def test_ids_are_in_channels_that_blender_never_compresses_with_loss(self):
        self.assertEqual(passes.PASSES["cryptomatte"].channels, "rgba")
        self.assertEqual(passes.channels_of("CryptoObject00", 4), tuple(f"CryptoObject00.{one}" for one in "RGBA"))
