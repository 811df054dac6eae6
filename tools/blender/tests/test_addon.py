"""The add-on in Blender without a window. Run by tools/test with Blender's Python module `bpy`:

    PYTHONPATH=tools/blender SUNFLECK=target/checked/sunfleck PYTHON -m unittest discover -s tools/blender/tests
"""

import json
import math
import os
import struct
import subprocess
import tempfile
import unittest
from pathlib import Path

import bpy
import scenes
import sunfleck
from sunfleck import check, command, export, extras, frames, keys, render, world, world_picture
from sunfleck.evaluated import simulations

PROGRAM = os.environ.get("SUNFLECK", "sunfleck")


def document(path):
    """The JSON of a .glb file."""
    data = Path(path).read_bytes()
    (length,) = struct.unpack("<I", data[12:16])
    return json.loads(data[20 : 20 + length])


def inspect(path, *arguments):
    text = subprocess.run(
        [PROGRAM, "inspect", str(path), "--json", *arguments], capture_output=True, check=True, text=True
    )
    return json.loads(text.stdout)


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.scene = scenes.empty()
        sunfleck.register()
        self.addCleanup(sunfleck.unregister)


class Import(Case):
    def test_rate_frames_size_and_camera_are_the_files(self):
        path = self.folder / "scene.glb"
        source = Path(__file__).parents[3] / "tests/data/valid/ron/keyed_every_way_24000_1001.ron"
        subprocess.run([PROGRAM, "export", str(source), str(path)], capture_output=True, check=True)
        self.assertEqual(bpy.ops.sunfleck.import_scene(filepath=str(path)), {"FINISHED"})
        render = self.scene.render
        self.assertEqual((render.fps, self.scene.frame_start, self.scene.frame_end), (24, 1, 48))
        self.assertAlmostEqual(render.fps_base, 1.001, places=6)
        self.assertEqual((render.resolution_x, render.resolution_y), (160, 90))
        self.assertEqual(self.scene.camera.type, "CAMERA")

    def test_what_is_no_gltf_is_refused(self):
        for name, data in {"text": b"no scene", "short": b"glTF", "list": b"[]"}.items():
            path = self.folder / f"{name}.glb"
            path.write_bytes(data)
            with self.assertRaisesRegex(RuntimeError, f"{name}.glb is not a glTF file"):
                bpy.ops.sunfleck.import_scene(filepath=str(path))


class Registration(unittest.TestCase):
    def test_registers_and_unregisters_twice(self):
        scenes.empty()
        for _ in range(2):
            sunfleck.register()
            self.assertTrue(hasattr(bpy.types.Scene, "sunfleck_settings"))
            self.assertIn("export", dir(bpy.ops.sunfleck))
            sunfleck.unregister()
            self.assertFalse(hasattr(bpy.types.Scene, "sunfleck_settings"))
            self.assertFalse(hasattr(bpy.types, "SUNFLECK_PT_render"))

    def test_the_manifest_is_whole(self):
        import tomllib

        manifest = tomllib.loads((Path(sunfleck.__file__).parent / "blender_manifest.toml").read_text())
        needed = {
            "schema_version",
            "id",
            "version",
            "name",
            "tagline",
            "maintainer",
            "type",
            "blender_version_min",
            "license",
        }
        self.assertLessEqual(needed, set(manifest))


class Export(Case):
    def test_what_is_set_in_blender_arrives(self):
        scene = self.scene
        scene.frame_start, scene.frame_end = 3, 7
        scene.render.fps, scene.render.fps_base = 24, 1.001
        scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 0.5
        scene.sunfleck_settings.tolerance = 0.04
        scene.sunfleck_settings.background_strength = 0.5
        eye = scenes.camera(scene)
        eye.data.dof.use_dof, eye.data.dof.aperture_fstop, eye.data.dof.focus_distance = True, 2.0, 3.5
        scenes.sun(scene, 3.0, 0.01)
        scenes.fog_box(scene)
        path = self.folder / "scene.glb"
        self.assertEqual(command.main(["export", str(path)]), 0)
        said = document(path)["scenes"][0]["extras"]
        self.assertEqual(said["sunfleck"]["camera"], "camera")
        found = inspect(path)
        self.assertEqual(found["frame_rate"], [24000, 1001])
        self.assertEqual((found["frame_start"], found["frame_end"]), (3, 7))
        self.assertEqual(found["size"], [64, 36])
        self.assertAlmostEqual(found["tolerance"], 0.04, 6)
        light = found["frames"][0]["lights"]["sun"]
        self.assertAlmostEqual(light["irradiance_w_per_m2"][0], 3.0, 5)
        self.assertAlmostEqual(light["angular_diameter_rad"], 0.01, 6)
        loud = [remark for remark in found["remarks"] if "warning" in remark]
        self.assertEqual(loud, [])

    def test_places_arrive_at_every_frame(self):
        scene = self.scene
        scene.frame_start, scene.frame_end = 1, 12
        scenes.camera(scene)
        leaf = scenes.quad(scene, "leaf", 1.0, scenes.material("green", (0.1, 0.5, 0.1)))
        leaf.rotation_mode = "ZYX"
        for frame, angle in ((1, 0.0), (12, 5.0)):
            leaf.location, leaf.rotation_euler = (angle, 1.0, 2.0), (angle, 0.3 * angle, -angle)
            leaf.keyframe_insert("location", frame=frame)
            leaf.keyframe_insert("rotation_euler", frame=frame)
        path = self.folder / "scene.glb"
        export.export(scene, path)
        found = inspect(path, "--frames", ",".join(map(str, range(1, 13))))
        turn = [[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]]
        import mathutils

        turn = mathutils.Matrix(turn)
        for frame in found["frames"]:
            scene.frame_set(int(frame["frame"]))
            expected = turn @ leaf.matrix_world @ turn.inverted()
            world = frame["nodes"]["leaf"]["world"]
            worst = max(
                abs(world[4 * row + column] - expected[row][column])
                for row in range(4)
                for column in range(4)
            )
            self.assertLess(worst, 1e-5)

    def test_values_that_change_travel_in_empties_that_do_not_stay(self):
        scene = self.scene
        scene.frame_start, scene.frame_end = 1, 5
        lamp = scenes.add(scene, "lamp", bpy.data.lights.new("lamp", "POINT"))
        scenes.camera(scene)
        volume = scenes.fog_box(scene)
        for frame, energy, density in ((1, 10.0, 0.1), (5, 50.0, 0.5)):
            lamp.data.energy, volume.sunfleck_settings.density = energy, density
            lamp.data.keyframe_insert("energy", frame=frame)
            volume.keyframe_insert("sunfleck_settings.density", frame=frame)
        before = set(bpy.data.objects.keys()), set(bpy.data.actions.keys())
        path = self.folder / "scene.glb"
        export.export(scene, path)
        self.assertEqual((set(bpy.data.objects.keys()), set(bpy.data.actions.keys())), before)
        targets = [
            node["extras"]["sunfleck_ctl"]["target"]
            for node in document(path)["nodes"]
            if "sunfleck_ctl" in node.get("extras", {})
        ]
        self.assertEqual(sorted(targets), ["fog.sunfleck_fog_volume.density", "lamp.sunfleck_light.power_w"])
        found = inspect(path, "--frames", "1,3,5")
        for frame in found["frames"]:
            scene.frame_set(int(frame["frame"]))
            expected = lamp.data.energy / (4.0 * 3.141592653589793)
            self.assertAlmostEqual(frame["lights"]["lamp"]["intensity_w_per_sr"][0], expected, 4)

    def test_fog_may_leave_its_material_for_its_panel(self):
        scene = self.scene
        scene.frame_end = 2
        scenes.camera(scene)
        bpy.ops.mesh.primitive_cube_add(size=2.0)
        cube, shade = bpy.context.object, bpy.data.materials.new("glow")
        cube.sunfleck_settings.is_fog, shade.use_nodes = True, True
        cube.data.materials.append(shade)
        nodes = shade.node_tree.nodes
        nodes.remove(nodes["Principled BSDF"])
        volume = nodes.new("ShaderNodeVolumePrincipled")
        shade.node_tree.links.new(volume.outputs[0], nodes["Material Output"].inputs["Volume"])
        # What glows is no fog of numbers: the panel's count from then on.
        self.key(volume.inputs["Emission Strength"], "default_value", 0.0, 1.0)
        path = self.folder / "scene.glb"
        self.assertEqual([one.id for one in export.exported(scene, path).findings], ["fog-material"])
        self.assertEqual(inspect(path)["remarks"], [])

    def test_settings_that_a_file_cannot_change_are_told(self):
        scene, own = self.scene, self.scene.sunfleck_settings
        scene.frame_end = 2
        eye, sun, fog = scenes.camera(scene), scenes.sun(scene), scenes.fog_box(scene)
        own.background_color, own.use_fog, fog.sunfleck_settings.use_mist = (1.0, 0.5, 0.5), True, True
        shade = scenes.material("leaf", (0.1, 0.5, 0.1))
        quad = scenes.quad(scene, "quad", 1.0, shade)
        lamp = scenes.add(scene, "lamp", bpy.data.lights.new("lamp", "AREA"))
        path = self.folder / "scene.glb"
        self.assertEqual(export.exported(scene, path).findings, [])
        # The first are in the file, and nothing is said of them.
        self.key(eye.data, "lens", 50.0, 20.0)
        self.key(own, "density", 0.1, 0.2)
        self.key(fog.sunfleck_settings, "mist_cover", 0.5, 0.2)
        self.key(own, "background_strength", 0.5, 1.0)
        self.key(own, "base_height", 0.0, 1.0)
        self.key(scene.render, "film_transparent", False, True)
        self.key(fog.sunfleck_settings, "mist_size", 1.0, 2.0)
        self.key(sun.sunfleck_settings, "limb_darkening", 0.0, 1.0)
        self.key(lamp.data, "shape", "SQUARE", "DISK")
        self.key(eye.data, "clip_start", 0.001, 0.01)
        self.key(eye.data.dof, "use_dof", False, True)
        self.key(shade.sunfleck_settings, "is_leaf", False, True)
        quad.sunfleck_settings.use_leaf_id = True
        self.key(quad.sunfleck_settings, "leaf_id", 1, 2)
        told = {str(one).split(":")[0] for one in export.exported(scene, path).findings}
        stays = {
            "`strength` of the sky", "`base_height` of fog everywhere", "`mist.size` of `fog`",
            "`limb_darkening` of `sun`", "`shape` of `lamp`", "`fstop` of `camera`", "`focus_distance` of `camera`",
            "`sensor_width_mm` of `camera`", "`leaf_id` of `quad`", "`visible_to_camera` of the sky",
        }
        others = {"[camera-values] `camera`", "[material-changes] the material `leaf`"}
        self.assertEqual(told, {f"[settings-change] {one}" for one in stays} | others)
        # Each frame alone has its own.
        self.assertNotIn("settings-change", [one.id for one in export.exported(scene, path, only=2).findings])

    def test_fog_that_comes_and_goes_is_in_the_file(self):
        scene, own = self.scene, self.scene.sunfleck_settings
        scene.frame_end = 3
        scenes.camera(scene)
        fog, box = scenes.fog_box(scene), scenes.quad(scene, "box", 1.0, scenes.material("box", (0.5, 0.5, 0.5)))
        self.key(own, "use_fog", False, True, False)
        self.key(fog.sunfleck_settings, "is_fog", True, False, True)
        self.key(box.sunfleck_settings, "is_fog", False, True, False)
        path = self.folder / "scene.glb"
        told = export.exported(scene, path)
        self.assertEqual(told.findings, [])
        self.assertEqual([counted.instances for _, counted in told.counts.of], [1, 0, 1])
        said, found = document(path), inspect(path, "--frames", "1..3")
        fogs = {node["name"] for node in said["nodes"] if "sunfleck_fog_volume" in node.get("extras", {})}
        shown = [{name for name in fogs if frame["nodes"][name]["visible"]} for frame in found["frames"]]
        self.assertEqual(shown, [{"fog"}, {"box 2"}, {"fog"}])
        everywhere = next(node for node in found["frames"][0]["nodes"] if node.startswith("ctl_"))
        self.assertEqual(everywhere, "ctl_scene.sunfleck_fog.density")
        self.assertIn("sunfleck_fog", said["scenes"][0]["extras"])
        self.assertEqual(found["remarks"], [])

    def key(self, owner, path, *values):
        """Keys a property, from frame 1 on; the first is at hand."""
        for frame, value in reversed(list(enumerate(values, 1))):
            setattr(owner, path, value)
            owner.keyframe_insert(path, frame=frame)

    def test_materials_that_change_arrive(self):
        scene = self.scene
        scene.frame_start, scene.frame_end = 1, 9
        scenes.camera(scene)
        shade = scenes.material("glow", (0.1, 0.5, 0.1))
        scenes.quad(scene, "quad", 1.0, shade)
        inputs = shade.node_tree.nodes["Principled BSDF"].inputs
        inputs["Emission Color"].default_value = (1.0, 0.5, 0.2, 1.0)
        for frame, strength, red in ((1, 0.0, 0.0), (9, 5.0, 0.8)):
            inputs["Emission Strength"].default_value = strength
            inputs["Base Color"].default_value = (red, 0.5, 0.1, 1.0)
            inputs["Emission Strength"].keyframe_insert("default_value", frame=frame)
            inputs["Base Color"].keyframe_insert("default_value", frame=frame)
        path = self.folder / "scene.glb"
        export.export(scene, path)
        targets = [
            channel["target"].get("extensions", {}) for channel in document(path)["animations"][0]["channels"]
        ]
        pointers = {target["KHR_animation_pointer"]["pointer"] for target in targets if target}
        for value in (
            "pbrMetallicRoughness/baseColorFactor",
            "emissiveFactor",
            "extensions/KHR_materials_emissive_strength/emissiveStrength",
        ):
            self.assertIn(f"/materials/0/{value}", pointers)
        loud = [remark for remark in inspect(path)["remarks"] if "warning" in remark]
        self.assertEqual(loud, [])

    def test_what_nodes_and_background_sets_show_is_simulated(self):
        cloth = bpy.data.objects.new("cloth", bpy.data.meshes.new("cloth"))
        cloth.modifiers.new("cloth", "CLOTH")
        apart, other = bpy.data.collections.new("apart"), bpy.data.scenes.new("other")
        apart.objects.link(cloth)
        host = scenes.add(self.scene, "host", bpy.data.meshes.new("host"))
        group = bpy.data.node_groups.new("shows", "GeometryNodeTree")
        asked = group.interface.new_socket("shown", in_out="INPUT", socket_type="NodeSocketCollection").identifier
        modifier = host.modifiers.new("shows", "NODES")
        modifier.node_group = group
        node = group.nodes.new("GeometryNodeCollectionInfo")
        self.assertFalse(simulations.any_in(self.scene))
        node.inputs["Collection"].default_value = apart
        self.assertEqual(list(simulations.objects(self.scene)), [cloth])
        node.inputs["Collection"].default_value = None
        if hasattr(modifier, "properties"):
            getattr(modifier.properties.inputs, asked).value = apart
        else:
            modifier[asked] = apart
        self.assertEqual(list(simulations.objects(self.scene)), [cloth])
        bpy.data.objects.remove(host)
        self.assertFalse(simulations.any_in(self.scene))
        other.collection.children.link(apart)
        self.scene.background_set = other
        self.assertEqual(list(simulations.objects(self.scene)), [cloth])

    def test_what_a_material_is_later_counts_from_the_first_frame_on(self):
        scene = self.scene
        scene.frame_end = 2
        scenes.camera(scene)
        shade = scenes.material("fades", (0.1, 0.5, 0.1))
        scenes.quad(scene, "quad", 1.0, shade)
        inputs = shade.node_tree.nodes["Principled BSDF"].inputs
        self.key(inputs["Alpha"], "default_value", 1.0, 0.25)
        self.key(inputs["Metallic"], "default_value", 0.0, 1.0)
        path = self.folder / "scene.glb"
        self.assertEqual(export.export(scene, path), [])
        (said,) = document(path)["materials"]
        self.assertEqual((said["alphaMode"], said["extras"]["sunfleck_material"]["principled"]), ("BLEND", True))

    def environment(self, image):
        """A world that shows an image, turned by 0.4 about Z."""
        world = bpy.data.worlds.new("world")
        world.use_nodes = True
        self.scene.world = world
        nodes, links = world.node_tree.nodes, world.node_tree.links
        texture, mapping = nodes.new("ShaderNodeTexEnvironment"), nodes.new("ShaderNodeMapping")
        coordinates = nodes.new("ShaderNodeTexCoord")
        texture.image, texture.interpolation = image, "Linear"
        mapping.inputs["Rotation"].default_value[2] = 0.4
        links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
        links.new(mapping.outputs[0], texture.inputs["Vector"])
        background = next(node for node in nodes if node.type == "BACKGROUND")
        background.inputs["Strength"].default_value = 2.0
        links.new(texture.outputs[0], background.inputs["Color"])

    def gradients(self):
        """An image that differs in every direction, smooth enough for any interpolation."""
        image = bpy.data.images.new("sky", 64, 32, float_buffer=True)
        pixels = []
        for row in range(32):
            for column in range(64):
                across, up = math.tau * (column + 0.5) / 64, (row + 0.5) / 32
                pixels += [0.5 + 0.4 * math.cos(across), 0.5 + 0.4 * math.sin(across), up, 1.0]
        image.pixels = pixels
        return image

    def test_the_worlds_image_is_the_sky(self):
        self.environment(self.gradients())
        own = self.scene.sunfleck_settings
        own.use_world, own.sky_lights, own.use_samples, own.samples = True, "surfaces_and_fog", True, 4
        scenes.camera(self.scene, location=(0.0, 0.0, 0.0), towards=(0.5, 1.0, 0.2), angle_deg=70.0)
        path = self.folder / "scene.glb"
        self.assertEqual(export.export(self.scene, path), [])
        said = document(path)["scenes"][0]["extras"]["sunfleck_env"]
        self.assertEqual(
            (said["image"], said["lights"], said["strength"]), ("scene_sky.exr", "surfaces_and_fog", 2.0)
        )
        differences, _ = self.beside_cycles()
        self.assertLess(sum(differences) / len(differences), 5e-3)
        self.assertLess(max(differences), 5e-2)

    def beside_cycles(self):
        """Renders both: by how much each value differs, and the ratio of the means."""
        path = self.folder / "scene.glb"
        export.export(self.scene, path)
        ours = self.folder / "ours.exr"
        subprocess.run(
            [PROGRAM, "render", str(path), "--passes", "none", "--bounces", "0", "--out", str(ours)],
            capture_output=True,
            check=True,
        )
        render = self.scene.render
        render.engine, render.image_settings.file_format, render.filepath = (
            "CYCLES",
            "OPEN_EXR",
            str(self.folder / "theirs.exr"),
        )
        self.scene.cycles.samples, self.scene.cycles.use_denoising = 16, False
        bpy.ops.render.render(write_still=True)
        theirs = bpy.data.images.load(str(self.folder / "theirs.exr"))
        pixels = [list(image.pixels) for image in (bpy.data.images.load(str(ours)), theirs)]
        colours = [index for index in range(len(pixels[0])) if index % 4 != 3]
        ratio = sum(pixels[0][index] for index in colours) / sum(pixels[1][index] for index in colours)
        return [abs(pixels[0][index] - pixels[1][index]) for index in colours], ratio

    def test_a_picture_on_the_sun(self):
        scenes.camera(self.scene)
        sun = scenes.sun(self.scene, angle=0.2)
        own = sun.sunfleck_settings
        own.visible_to_camera, own.sun_shows, own.picture_rotation, own.limb_darkening = (
            True,
            "FRACTAL",
            0.5,
            0.25,
        )
        own.keyframe_insert("fractal_real", frame=1)
        own.fractal_real = 0.25
        own.keyframe_insert("fractal_real", frame=4)
        self.scene.frame_end = 4
        path = self.folder / "scene.glb"
        export.export(self.scene, path)
        self.assertEqual(inspect(path)["remarks"], [])
        said = self.light_of(path, "sun")
        self.assertEqual(
            (said["limb_darkening"], said["picture_rotation"], said["visible_to_camera"]), (0.25, 0.5, True)
        )
        self.assertEqual(said["fractal"]["iterations"], 100)
        controls = [
            node["extras"]["sunfleck_ctl"]["target"]
            for node in document(path)["nodes"]
            if node["name"].startswith("ctl_")
        ]
        self.assertEqual(controls, ["sun.sunfleck_light.fractal_real"])
        sun.animation_data_clear()
        # An image that no file holds yet, then one that is a file.
        own.sun_shows, own.sun_image = "IMAGE", bpy.data.images.new("checks", 8, 8)
        own.sun_image.pixels = [1.0, 0.5, 0.25, 1.0] * 64
        export.export(self.scene, path)
        said = self.light_of(path, "sun")
        self.assertEqual((said["image"], "fractal" in said), ("scene_sun.png", False))
        self.assertEqual(inspect(path)["remarks"], [])
        own.sun_image = bpy.data.images.load(str(self.folder / "scene_sun.png"))
        export.export(self.scene, self.folder / "again.glb")
        self.assertEqual(
            (self.folder / "again_sun.png").read_bytes(), (self.folder / "scene_sun.png").read_bytes()
        )
        # What the panel takes back is gone.
        own.sun_shows, own.limb_darkening, own.visible_to_camera = "EVEN", 0.0, False
        export.export(self.scene, path)
        self.assertEqual(set(self.light_of(path, "sun")), {"angle", "strength_w_m2"})

    def light_of(self, path, name):
        node = next(node for node in document(path)["nodes"] if node.get("name") == name)
        return node["extras"]["sunfleck_light"]

    def test_a_plain_world_is_a_sky_and_others_are_baked(self):
        world = bpy.data.worlds.new("world")
        world.use_nodes = True
        self.scene.world = world
        scenes.camera(self.scene)
        background = next(node for node in world.node_tree.nodes if node.type == "BACKGROUND")
        background.inputs["Color"].default_value, background.inputs["Strength"].default_value = (
            (0.25, 0.5, 1.0, 1.0),
            3.0,
        )
        self.assertIn("tick World as sky", " ".join(finding.message for finding in check.check(self.scene)))
        self.scene.sunfleck_settings.use_world = True
        self.assertEqual([finding.id for finding in check.check(self.scene)], ["world-lights-nothing"])
        self.scene.sunfleck_settings.sky_lights = "surfaces"
        self.assertEqual(check.check(self.scene), [])
        said = extras.of_scene(self.scene)["sunfleck_env"]
        self.assertEqual(said, {"color": [0.25, 0.5, 1.0], "strength": 3.0, "lights": "surfaces"})
        noise = world.node_tree.nodes.new("ShaderNodeTexNoise")
        noise.inputs["Scale"].default_value = 2.0
        world.node_tree.links.new(noise.outputs["Color"], background.inputs["Color"])
        self.assertEqual([finding.id for finding in check.check(self.scene)], ["world-baked"])
        os.environ["SUNFLECK_BAKES"] = str(self.folder)
        self.addCleanup(os.environ.pop, "SUNFLECK_BAKES")
        own = self.scene.sunfleck_settings
        own.use_samples, own.samples = True, 4
        _, ratio = self.beside_cycles()
        print(f"a baked world: mean ratio {ratio:.5f}")
        self.assertAlmostEqual(ratio, 1.0, delta=0.005)

    def test_a_black_picture_as_the_sky_is_a_black_sky(self):
        self.environment(bpy.data.images.new("black", 8, 4, float_buffer=True))
        self.scene.sunfleck_settings.use_world = True
        path = self.folder / "scene.glb"
        sky = extras.of_scene(self.scene, path)["sunfleck_env"]
        # Without a sky the film would be transparent.
        self.assertEqual((sky["color"], sky["lights"]), ([extras.NEXT_TO_BLACK] * 3, "nothing"))

    def test_a_coarse_sky_that_cycles_smooths_as_stored_is_baked(self):
        """Else a sun of two texels had 1.24 of its light."""
        for space, width, is_baked in (("Linear Rec.709", 8, False), ("sRGB", 8, True), ("sRGB", 2 * world.FINE, False)):
            image = bpy.data.images.new("sky", width, 4, float_buffer=True)
            image.colorspace_settings.name = space
            self.environment(image)
            self.assertEqual(world.is_baked(self.scene), is_baked, (space, width))

    def test_a_world_follows_the_object_that_turns_it(self):
        self.environment(self.gradients())
        world = self.scene.world
        turning = scenes.add(self.scene, "turning", None)
        nodes = world.node_tree.nodes
        mapping, coordinates = (next(node for node in nodes if node.type == kind) for kind in ("MAPPING", "TEX_COORD"))
        coordinates.object = turning
        world.node_tree.links.new(coordinates.outputs["Object"], mapping.inputs["Vector"])
        self.scene.view_layers[0].update()
        before = world_picture.key_of(world, 1.0)
        self.assertEqual(world_picture.key_of(world, 1.0), before)
        turning.rotation_euler.z = 1.0
        self.scene.view_layers[0].update()
        self.assertNotEqual(world_picture.key_of(world, 1.0), before)
        self.assertFalse(keys.changes(world))
        turning.keyframe_insert("rotation_euler", frame=1)
        self.assertTrue(keys.changes(world))

    def test_a_sky_lights_what_is_chosen(self):
        scenes.camera(self.scene)
        own = self.scene.sunfleck_settings
        own.background_strength, own.sky_lights = 0.5, "surfaces"
        path = self.folder / "scene.glb"
        export.export(self.scene, path)
        self.assertEqual(document(path)["scenes"][0]["extras"]["sunfleck_env"]["lights"], "surfaces")

    def test_nothing_hand_written_is_lost(self):
        scenes.camera(self.scene)
        lamp = scenes.add(self.scene, "lamp", bpy.data.lights.new("lamp", "POINT"))
        lamp["sunfleck_light"] = {"casts_shafts": True}
        marker = scenes.add(self.scene, "marker", None)
        marker["sunfleck_fog_volume"] = {"density": 0.25}
        marker["sunfleck_light"] = {"type": "area", "shape": "square", "size": [1.0, 1.0], "power_w": 1.0}
        self.assertEqual(export.exported(self.scene, self.folder / "scene.glb").findings, [])
        self.assertTrue(lamp["sunfleck_light"]["casts_shafts"])
        self.assertEqual(marker["sunfleck_fog_volume"]["density"], 0.25)

    def test_export_can_be_undone(self):
        scenes.camera(self.scene)
        self.assertIn("UNDO", export.SUNFLECK_OT_export.bl_options)
        path = self.folder / "scene.glb"
        self.assertEqual(bpy.ops.sunfleck.export(filepath=str(path)), {"FINISHED"})
        self.assertTrue(path.exists())


class Checks(Case):
    def messages(self):
        return [finding.message for finding in check.check(self.scene)]

    def test_a_scene_that_travels_whole_has_no_findings(self):
        scenes.camera(self.scene)
        scenes.sun(self.scene)
        self.assertEqual(self.messages(), [])

    def test_a_negative_light_is_refused(self):
        scenes.camera(self.scene)
        lamp = scenes.add(self.scene, "lamp", bpy.data.lights.new("lamp", "POINT"))
        lamp.data.shadow_soft_size, lamp.data.energy = 0.0, -1.0
        self.assertEqual([finding.id for finding in check.check(self.scene)], ["light-power"])
        with self.assertRaises(export.NotExportable):
            export.export(self.scene, self.folder / "scene.glb")

    def test_what_is_lost_is_said(self):
        scene = self.scene
        shade = scenes.material("leaf", (0.2, 0.5, 0.1))
        thing = scenes.quad(scene, "quad", 1.0, shade)
        thing.visible_glossy = False
        said = {finding.id for finding in check.check(scene)}
        self.assertEqual(said, {"no-camera", "ray-visibility"})
        thing.hide_render = True
        self.assertEqual([finding.id for finding in check.check(scene)], ["no-camera"])

    def test_a_volume_material_is_said_unless_it_is_fog(self):
        scenes.camera(self.scene)
        shade = bpy.data.materials.new("smoke")
        shade.use_nodes = True
        nodes = shade.node_tree.nodes
        nodes.remove(nodes["Principled BSDF"])
        volume = nodes.new("ShaderNodeVolumePrincipled")
        shade.node_tree.links.new(volume.outputs[0], nodes["Material Output"].inputs["Volume"])
        box = scenes.quad(self.scene, "smoke", 2.0, shade)
        self.assertIn("opaque box", " ".join(self.messages()))
        box.sunfleck_settings.is_fog = True
        self.assertEqual(self.messages(), [])


class Render(Case):
    def small(self):
        scenes.camera(self.scene)
        scenes.sun(self.scene)
        scenes.fog_box(self.scene)
        scenes.quad(self.scene, "ground", 6.0, scenes.material("soil", (0.4, 0.3, 0.2)))
        self.scene.frame_start, self.scene.frame_end = 1, 3
        own = self.scene.sunfleck_settings
        own.use_samples, own.samples = True, 2

    def test_frames_come_back_with_their_passes(self):
        self.small()
        self.assertEqual(command.main(["render", "--folder", str(self.folder)]), 0)
        paths = sorted(self.folder.glob("*.exr"))
        self.assertEqual(len(paths), 3)
        image, first, last = frames.load(paths[0])
        self.assertEqual((first, last), (1, 3))
        self.assertEqual((image.source, image.type), ("SEQUENCE", "MULTILAYER"))
        node = bpy.data.node_groups.new("look", "CompositorNodeTree").nodes.new("CompositorNodeImage")
        node.image = image
        shown = {output.name for output in node.outputs if output.enabled}
        self.assertLessEqual({"Combined", "Depth", "shafts", "leaf_id"}, shown)

    def test_a_folder_of_frames_holds_no_other_pictures(self):
        self.small()
        world = self.scene.world = bpy.data.worlds.new("world")
        world.use_nodes = True
        texture = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
        texture.image = bpy.data.images.new("sky", 16, 8, float_buffer=True)
        texture.image.pixels = [0.5, 0.25, 1.0, 1.0] * 128
        world.node_tree.links.new(texture.outputs[0], world.node_tree.nodes["Background"].inputs["Color"])
        self.scene.sunfleck_settings.use_world = True
        folder = self.folder / "frames"
        self.assertEqual(command.main(["render", "--folder", str(folder)]), 0)
        self.assertEqual(len(list(folder.rglob("*_sky.exr"))), 1)
        self.assertEqual(len(list(folder.glob("*.exr"))), 3)

    def test_the_operator_waits_without_a_window(self):
        self.small()
        bpy.context.preferences.filepaths.temporary_directory = str(self.folder)
        os.environ["SUNFLECK"] = PROGRAM
        self.assertEqual(bpy.ops.sunfleck.render(animation=True), {"FINISHED"})

    def test_a_run_can_be_cancelled(self):
        self.small()
        glb = self.folder / "scene.glb"
        export.export(self.scene, glb)
        run = render.Run(PROGRAM, glb, self.folder, ["--size", "1600x900", "--samples", "4096"])
        run.cancel()
        self.assertTrue(run.is_over())
        self.assertEqual(list(self.folder.glob("*.exr")), [])

    def test_a_program_that_fails_says_why(self):
        glb = self.folder / "scene.glb"
        glb.write_bytes(b"glTF")
        run = render.Run(PROGRAM, glb, self.folder)
        self.assertEqual(run.wait(), 3)
        self.assertIn("cut short", run.error())


if __name__ == "__main__":
    unittest.main()
