"""What decides about the picture: cameras and their markers, borders, pixels, steps, layers, colours
of the working space.

Run with the other tests here (test_addon.py says how).
"""

import math
import unittest
from unittest import mock

import bpy
import leaf_scenes
import numpy
import scenes
import stages
from sunfleck import check, export, extras, render
from sunfleck.evaluated.readback import File
from test_addon import document, inspect
from test_evaluated import Case


class Pictures(Case):
    def setUp(self):
        super().setUp()
        self.scene = stages.stage()
        stages.quad(self.scene)

    def other_camera(self, **values):
        data = bpy.data.cameras.new("other")
        data.angle_x = math.radians(20.0)
        for name, value in values.items():
            setattr(data, name, value)
        return scenes.add(self.scene, "other", data, (5.0, 0.0, 1.0), (0.0, 0.0, 1.0))

    def told(self, frames):
        return inspect(self.path, "--frames", ",".join(map(str, frames)))["frames"]

    def place_of(self, thing):
        x, y, z = thing.matrix_world.translation
        return [x, z, -y]

    def test_markers_switch_cameras(self):
        first, other = self.scene.camera, self.other_camera(clip_start=1e-4, clip_end=1e4)
        for frame, eye in ((1, first), (4, other)):
            self.scene.timeline_markers.new("cut", frame=frame).camera = eye
        export.export(self.scene, self.path)
        bpy.context.view_layer.update()
        for frame in self.told(range(1, 7)):
            eye = first if frame["frame"] < 4 else other
            world = frame["camera"]["world"]
            numpy.testing.assert_allclose([world[3], world[7], world[11]], self.place_of(eye), atol=1e-5)
            height = 2.0 * math.atan(math.tan(0.5 * eye.data.angle_x) * 36.0 / 64.0)
            self.assertAlmostEqual(frame["camera"]["fov_y_rad"], height, 5)

    def test_lenses_that_markers_cannot_switch_are_said(self):
        for frame, eye in ((1, self.scene.camera), (4, self.other_camera(shift_x=0.25))):
            self.scene.timeline_markers.new("cut", frame=frame).camera = eye
        self.assertIn("camera-cuts", {finding.id for finding in check.check(self.scene)})

    def test_a_hidden_camera_renders(self):
        self.scene.camera.hide_render = True
        export.export(self.scene, self.path)
        self.assertEqual(self.told([1])[0]["camera"]["name"], "camera")

    def test_pixels_are_square(self):
        self.scene.render.pixel_aspect_x = 2.0
        export.export(self.scene, self.path)
        found = inspect(self.path)
        self.assertEqual(found["size"], [128, 36])
        graph = bpy.context.evaluated_depsgraph_get()
        wanted = self.scene.camera.evaluated_get(graph).calc_matrix_camera(
            graph, x=64, y=36, scale_x=2.0, scale_y=1.0
        )
        projection = numpy.array(found["frames"][0]["camera"]["projection"]).reshape(4, 4)
        numpy.testing.assert_allclose(projection[:2], numpy.array(wanted)[:2], atol=1e-5)

    def test_steps_and_borders_are_flags(self):
        self.assertEqual(render.flags(self.scene, True), [])
        self.scene.frame_step, self.scene.render.use_border = 2, True
        for name, value in {"min_x": 0.25, "max_x": 0.75, "min_y": 0.0, "max_y": 0.5}.items():
            setattr(self.scene.render, f"border_{name}", value)
        self.assertEqual(render.flags(self.scene, True), ["--frames=1..6:2", "--crop=16,18,48,36"])
        self.scene.sunfleck_settings.use_samples, self.scene.sunfleck_settings.samples = True, 1
        with mock.patch.object(export, "default_folder", lambda _: self.path.parent):
            self.assertEqual(bpy.ops.sunfleck.render(animation=True), {"FINISHED"})
        self.assertEqual(len(list(self.path.parent.glob("*.exr"))), 3)

    def test_clip_planes_are_the_cameras(self):
        self.scene.camera.data.clip_start, self.scene.camera.data.clip_end = 0.5, 20.0
        export.export(self.scene, self.path)
        eye = self.told([1])[0]["camera"]
        self.assertAlmostEqual(eye["clip_start_m"], 0.5, 6)
        self.assertAlmostEqual(eye["clip_end_m"], 20.0, 5)

    def test_orthographic_cameras_zoom(self):
        data = self.scene.camera.data
        data.type = "ORTHO"
        stages.key(data, "ortho_scale", (2.0, 8.0), interpolation="LINEAR")
        export.export(self.scene, self.path)
        heights = [frame["camera"]["height_m"] for frame in self.told([1, 6])]
        numpy.testing.assert_allclose(heights, [2.0 * 36 / 64, 8.0 * 36 / 64], rtol=1e-6)

    def test_every_setting_that_is_not_honoured_is_said(self):
        scene, render_settings, dof = self.scene, self.scene.render, self.scene.camera.data.dof
        switches = {
            "border": lambda: setattr(render_settings, "use_border", True),
            "frame-step": lambda: setattr(scene, "frame_step", 2),
            "pixel-aspect": lambda: setattr(render_settings, "pixel_aspect_x", 2.0),
            "stereo": lambda: setattr(render_settings, "use_multiview", True),
            "freestyle": lambda: setattr(render_settings, "use_freestyle", True),
            "view-layers": lambda: scene.view_layers.new("other"),
            "unit-scale": lambda: setattr(scene.unit_settings, "scale_length", 0.01),
            "shutter-shape": lambda: (setattr(render_settings, "use_motion_blur", True), setattr(scene.cycles, "rolling_shutter_type", "TOP")),
            "camera-aperture": lambda: (setattr(dof, "use_dof", True), setattr(dof, "aperture_ratio", 2.0)),
            "layer-filters": lambda: setattr(bpy.context.view_layer, "use_sky", False),
            "color-overrides": lambda: setattr(bpy.context.view_layer, "world_override", bpy.data.worlds.new("other")),
            "camera-culling": lambda: (setattr(render_settings, "use_simplify", True), setattr(scene.cycles, "use_camera_cull", True)),
            "view-transform": lambda: setattr(scene.view_settings, "view_transform", "Standard"),
            "film-exposure-changes": lambda: (setattr(render_settings, "engine", "CYCLES"), scene.keyframe_insert("cycles.film_exposure")),
        }
        for id, switch in switches.items():
            self.assertNotIn(id, {finding.id for finding in check.check(scene)})
            switch()
            self.assertIn(id, {finding.id for finding in check.check(scene)}, id)

    def test_every_look_of_agx_goes_along(self):
        view = self.scene.view_settings
        for look in ("None", *extras.LOOKS):
            view.look = look
            self.assertEqual(extras.of_scene(self.scene)["sunfleck"]["look"], extras.LOOKS.get(look, "none"))
            self.assertTrue(extras.is_shown_alike(view), look)
        view.gamma = 2.0
        self.assertFalse(extras.is_shown_alike(view))

    def test_every_switch_of_things_that_is_not_honoured_is_said(self):
        thing, sun = bpy.data.objects["quad"], bpy.data.objects["sun"]
        stages.quad(self.scene, "flat")
        self.scene.sunfleck_settings.all_bounces = False

        def transparent(material):
            material.node_tree.nodes["Principled BSDF"].inputs["Alpha"].default_value = 0.5
            material.use_transparent_shadow = False

        switches = {
            "shadow-catcher": lambda: setattr(thing, "is_shadow_catcher", True),
            "shadow-in-bounces": lambda: (setattr(thing, "visible_shadow", False), setattr(self.scene.sunfleck_settings, "bounces", 1), setattr(self.scene.sunfleck_settings, "all_bounces", False)),
            "visibility-changes": lambda: thing.keyframe_insert("visible_camera"),
            "ray-visibility": lambda: setattr(thing, "visible_glossy", False),
            "light-shadowless": lambda: setattr(sun.data, "use_shadow", False),
            "light-rays": lambda: setattr(sun, "visible_diffuse", False),
            "volume": lambda: scenes.add(self.scene, "smoke", bpy.data.volumes.new("smoke")),
            "hair": lambda: scenes.add(self.scene, "hair", bpy.data.hair_curves.new("hair")),
            "point-cloud": lambda: scenes.add(self.scene, "points", bpy.data.pointclouds.new("points")),
            "adaptive-subdivision": lambda: setattr(thing.modifiers.new("finer", "SUBSURF"), "use_adaptive_subdivision", True),
            "material-shadows": lambda: transparent(thing.data.materials[0]),
            "fog-not-a-cube": lambda: setattr(bpy.data.objects["flat"].sunfleck_settings, "is_fog", True),
            "grease-pencil": lambda: scenes.add(self.scene, "drawing", bpy.data.grease_pencils.new("drawing")),
        }
        for id, switch in switches.items():
            self.assertNotIn(id, {finding.id for finding in check.check(self.scene)})
            switch()
            self.assertIn(id, {finding.id for finding in check.check(self.scene)}, id)

    def test_which_rays_meet_things(self):
        """Of objects, of collections and of instances, which have what both they and their instancer have."""
        layer = bpy.context.view_layer

        def collection(name):
            made = bpy.data.collections.new(name)
            self.scene.collection.children.link(made)
            made.objects.link(stages.quad(self.scene, f"in {name}"))
            self.scene.collection.objects.unlink(bpy.data.objects[f"in {name}"])
            return layer.layer_collection.children[name]

        collection("indirect").indirect_only = True
        collection("hole").holdout = True
        for name, setting, value in (
            ("unseen", "visible_camera", False),
            ("shadowless", "visible_shadow", False),
            ("held out", "is_holdout", True),
        ):
            setattr(stages.quad(self.scene, name), setting, value)
        instanced = bpy.data.collections.new("instanced")
        inner = stages.quad(self.scene, "inner")
        self.scene.collection.objects.unlink(inner)
        instanced.objects.link(inner)
        inner.visible_shadow, inner.is_holdout = False, True
        empty = scenes.add(self.scene, "empty", None)
        empty.instance_type, empty.instance_collection, empty.visible_camera = "COLLECTION", instanced, False
        told = export.exported(self.scene, self.path)
        self.assertEqual([finding.id for finding in told.findings if finding.id.startswith("count")], [])
        said = {node["name"]: node.get("extras", {}).get("sunfleck_object") for node in File(self.path).nodes if "mesh" in node}
        unseen, hole = {"visible_to_camera": False}, {"holdout": True}
        self.assertEqual(
            said,
            {
                "quad": None, "in indirect": unseen, "in hole": hole, "unseen": unseen,
                "shadowless": {"casts_shadow": False}, "held out": hole,
                "inner of empty 1": {**unseen, "casts_shadow": False},
            },
        )

    def test_every_switch_of_lamps_that_is_not_honoured_is_said(self):
        lamp = scenes.add(self.scene, "lamp", bpy.data.lights.new("lamp", "SPOT")).data
        area = scenes.add(self.scene, "area", bpy.data.lights.new("area", "AREA")).data
        switches = {
            "light-square": lambda: setattr(lamp, "use_square", True),
            "light-spread": lambda: setattr(area, "spread", 0.001),
            "light-portal": lambda: setattr(area.cycles, "is_portal", True),
            "light-power": lambda: setattr(lamp, "energy", -1.0),
        }
        for id, switch in switches.items():
            self.assertNotIn(id, {finding.id for finding in check.check(self.scene)})
            switch()
            self.assertIn(id, {finding.id for finding in check.check(self.scene)}, id)
        lamp.energy = 1.0
        export.export(self.scene, self.path)
        self.assertEqual(set(self.told([1])[0]["lights"]), {"sun", "lamp"})

    def test_one_frame_alone_below_zero(self):
        """The frame at hand may be negative; the file's times are not."""
        thing = bpy.data.objects["quad"]
        stages.key(
            thing, "location", ((0.0, 0.0, 0.0), (8.0, 0.0, 4.0)), frames=(-10, 6), interpolation="LINEAR"
        )
        self.scene.render.use_motion_blur = True
        export.export(self.scene, self.path, only=-6)
        said = document(self.path)
        times = [
            said["accessors"][sampler["input"]]["min"][0] for sampler in said["animations"][0]["samplers"]
        ]
        self.assertGreaterEqual(min(times), 0.0)
        for frame in (-6.25, -6.0, -5.75):
            world = File(self.path).worlds(File(self.path).seconds([frame]))
            node = next(index for index, node in enumerate(File(self.path).nodes) if node["name"] == "quad")
            self.assertAlmostEqual(world[node][0][0, 3], 0.5 * (frame + 10.0), 5)
        self.assertEqual(said["scenes"][0]["extras"]["sunfleck"]["frame_at_zero"], -7)
        told = inspect(self.path, "--frames=-6")
        self.assertEqual((told["frame_start"], told["frame_end"]), (-6, -6))
        self.assertAlmostEqual(told["frames"][0]["nodes"]["quad"]["world"][3], 2.0, 6)

    def test_a_simulation_of_one_frame_alone(self):
        scene = leaf_scenes.build("simulation_emits")
        told = export.exported(scene, self.path, only=12)
        self.assertEqual([(frame, counted.instances) for frame, counted in told.counts.of], [(12, 46)])

    def test_lights_among_instances(self):
        """An area light that is in no scene, twice."""
        collection = bpy.data.collections.new("lamps")
        data = bpy.data.lights.new("area", "AREA")
        data.energy, data.size = 20.0, 0.5
        collection.objects.link(bpy.data.objects.new("area", data))
        for number in range(2):
            empty = scenes.add(self.scene, f"lamp {number}", None, (float(number), 0.0, 2.0))
            empty.instance_type, empty.instance_collection = "COLLECTION", collection
        told = export.exported(self.scene, self.path)
        self.assertEqual(told.findings, [])
        lights = self.told([1])[0]["lights"]
        self.assertEqual(sorted(lights), ["area of lamp 0 1", "area of lamp 1 1", "sun"])
        self.assertAlmostEqual(lights["area of lamp 1 1"]["power_w"][0], 20.0, 5)

    def test_lights_of_a_temperature_and_those_that_are_not_normalised(self):
        """The same as a light of that colour, and of so much more power."""
        lamp = scenes.add(self.scene, "lamp", bpy.data.lights.new("lamp", "POINT"))
        data = lamp.data
        data.energy, data.shadow_soft_size, data.normalize = 10.0, 0.5, False
        data.use_temperature, data.temperature = True, 4000.0
        export.export(self.scene, self.path)
        found = self.told([1])[0]["lights"]["lamp"]["intensity_w_per_sr"]
        wanted = [10.0 * math.pi * 0.25 / math.pi * channel for channel in data.temperature_color]
        numpy.testing.assert_allclose(found, wanted, rtol=1e-5)

    def test_film_exposure_is_a_factor_on_all_light(self):
        scenes.add(self.scene, "lamp", bpy.data.lights.new("lamp", "POINT"))
        area = scenes.add(self.scene, "area", bpy.data.lights.new("area", "AREA")).data
        stages.key(area, "energy", (10.0, 20.0))
        scenes.add(self.scene, "still", bpy.data.lights.new("still", "AREA"))
        material = bpy.data.materials["quad"]
        glow = material.node_tree.nodes["Principled BSDF"].inputs
        glow["Emission Color"].default_value, glow["Emission Strength"].default_value = (1.0, 0.5, 0.1, 1.0), 0.8
        self.scene.sunfleck_settings.background_strength = 0.5

        def shining():
            told = export.exported(self.scene, self.path)
            self.assertEqual({finding.id for finding in told.findings} & {"film-exposure-changes"}, set())
            lights = self.told([1, 6])
            powers = [power for frame in lights for light in frame["lights"].values() for power in (light.get("power_w") or light.get("intensity_w_per_sr") or light["irradiance_w_per_m2"])]
            said = document(self.path)
            strong = said["materials"][0].get("extensions", {}).get("KHR_materials_emissive_strength", {})
            emitted = numpy.array(said["materials"][0]["emissiveFactor"]) * strong.get("emissiveStrength", 1.0)
            return numpy.array([*powers, *emitted, said["scenes"][0]["extras"]["sunfleck_env"]["strength"]])

        self.scene.cycles.film_exposure = 2.5
        before = shining()
        self.scene.render.engine = "CYCLES"
        numpy.testing.assert_allclose(shining(), 2.5 * before, rtol=1e-6)

    def test_colours_of_a_wider_space_are_converted(self):
        bpy.ops.wm.set_working_color_space(working_space="ACEScg", convert_colors=False)
        self.addCleanup(
            bpy.ops.wm.set_working_color_space, working_space="Linear Rec.709", convert_colors=False
        )
        shader = bpy.data.materials["quad"].node_tree.nodes["Principled BSDF"]
        shader.inputs["Base Color"].default_value = (0.25, 0.5, 0.125, 1.0)
        told = export.exported(self.scene, self.path)
        found = document(self.path)["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"][:3]
        expected = numpy.array(
            [
                [1.705052, -0.621791, -0.083261],
                [-0.130257, 1.140803, -0.010546],
                [-0.024003, -0.128969, 1.152972],
            ]
        )
        numpy.testing.assert_allclose(found, expected @ (0.25, 0.5, 0.125), atol=1e-4)
        self.assertIn("working-space", {finding.id for finding in told.findings})

    def test_the_view_layer_that_renders_is_exported(self):
        other = self.scene.view_layers.new("other")
        self.scene.view_layers[0].use = False
        hidden = bpy.data.collections.new("hidden")
        self.scene.collection.children.link(hidden)
        thing = stages.quad(self.scene, "excluded")
        self.scene.collection.objects.unlink(thing)
        hidden.objects.link(thing)
        other.layer_collection.children["hidden"].exclude = True
        export.export(self.scene, self.path)
        names = {node["name"] for node in File(self.path).nodes}
        self.assertIn("quad", names)
        self.assertNotIn("excluded", names)


if __name__ == "__main__":
    unittest.main()
