"""What artists of today build: each kind beside Cycles, or said.

Run with the other tests here (test_addon.py says how); `SUNFLECK_BESIDE` names one kind.
"""

import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import bpy
import kinds
import numpy
import scenes
import sunfleck
from sunfleck import export, losses, render, world
from sunfleck.evaluated import coincident
from sunfleck.materials import dependence, instances, stage
from test_addon import PROGRAM, document

sys.path.append(str(Path(__file__).parents[2]))

from sunfleck_tools.peers import beside

SAMPLES, CYCLES_SAMPLES = 64, 128
# Of blocks of pixels, as a share of the mean.
BLOCKS = 0.01


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        os.environ["SUNFLECK_BAKES"] = folder.name
        self.addCleanup(os.environ.pop, "SUNFLECK_BAKES")
        sunfleck.register()
        self.addCleanup(sunfleck.unregister)

    def each(self, of):
        for name, (build, *wanted) in of.items():
            if os.environ.get("SUNFLECK_BESIDE", "") not in name or bpy.app.version < kinds.LATER.get(name, ()):
                continue
            scene = kinds.stage(kinds.BACK) if name.startswith(("thin wall", "face")) else kinds.stage()
            build(scene)
            yield name, scene, *wanted


class Beside(Case):
    def test_means_and_blocks(self):
        for name, scene, frame, bar in self.each(kinds.BESIDE):
            size = (scene.render.resolution_x, scene.render.resolution_y)
            wish = beside.Wish(PROGRAM, frame, size, SAMPLES, CYCLES_SAMPLES)
            ours, theirs, findings = beside.pictures(scene, wish, self.folder)
            ratio = ours.mean() / theirs.mean()
            apart = numpy.abs(blocks(ours) - blocks(theirs)).mean() / theirs.mean()
            print(f"{name:20} {theirs.mean():9.5f} {ratio:9.5f} blocks {apart:8.5f}", flush=True)
            self.assertLess(abs(ratio - 1.0), bar, name)
            self.assertLess(apart, 3.0 * BLOCKS if name.startswith("hair") else BLOCKS, name)
            warned = {finding.id for finding in findings if finding.severity == "WARNING"}
            self.assertLessEqual(warned, {"hair"}, name)


@unittest.skipIf(bpy.app.version < (5, 2), "there are no thin walls")
class Frosted(Case):
    def test_light_bounces_as_in_cycles(self):
        """By random walks, and on the grid."""
        scene = kinds.stage()
        kinds.surfaces.frosted_before_a_wall(scene)
        wish = beside.Wish(PROGRAM, 1, (scene.render.resolution_x, scene.render.resolution_y), 64, 128, bounces=3)
        beside.exported(scene, wish, self.folder)
        theirs = beside.theirs(scene, wish, self.folder)
        for volume, bar in (("paths", kinds.EXACT), ("auto", kinds.BAKED)):
            ours = beside.ours(scene, wish, self.folder, volume)
            ratio = ours.mean() / theirs.mean()
            apart = numpy.abs(blocks(ours) - blocks(theirs)).mean() / theirs.mean()
            print(f"frosted, {volume:8} {theirs.mean():9.5f} {ratio:9.5f} blocks {apart:8.5f}", flush=True)
            self.assertLess(abs(ratio - 1.0), bar, volume)


class Glowing(Case):
    def test_its_light_bounces_as_often_as_in_cycles(self):
        """By random walks, and on the grid; what glows is itself not in the picture."""
        scene = kinds.stage()
        kinds.lamps.mesh_lamp(scene)
        size = (scene.render.resolution_x, scene.render.resolution_y)
        for bounces in (1, 2):
            wish = beside.Wish(PROGRAM, 1, size, 64, 128, bounces)
            beside.exported(scene, wish, self.folder)
            theirs = beside.theirs(scene, wish, self.folder).mean()
            for volume, bar in (("paths", kinds.EXACT), ("auto", kinds.BAKED)):
                ratio = beside.ours(scene, wish, self.folder, volume).mean() / theirs
                print(f"mesh lamp, {bounces} {volume:8} {theirs:9.5f} {ratio:9.5f}", flush=True)
                self.assertLess(abs(ratio - 1.0), bar, (bounces, volume))


class Said(Case):
    def test_as_warnings(self):
        for name, scene, id, *more in self.each(kinds.SAID):
            warnings = export.export(scene, self.folder / "scene.glb")
            told = [warning for warning in warnings if warning.startswith(f"[{id}]") and all(word in warning for word in more)]
            self.assertTrue(told, f"{name}: {warnings}")

    def test_a_panoramic_camera_is_refused_where_it_renders(self):
        scene = kinds.stage()
        scene.camera.data.type = "PANO"
        with self.assertRaisesRegex(export.NotExportable, "camera-panoramic.*`camera`"):
            export.export(scene, self.folder / "scene.glb")
        scenes.camera(scene)
        self.assertEqual(export.export(scene, self.folder / "scene.glb"), [])

    def test_in_a_still_no_material_changes(self):
        scene = kinds.stage()
        kinds.surfaces.scrolled(scene)
        for only, is_told in ((None, True), (scene.frame_current, False)):
            warnings = export.export(scene, self.folder / "scene.glb", only)
            self.assertEqual(any("material-changes" in warning for warning in warnings), is_told)

    def test_environments_of_squares_in_srgb_and_moved_ones_are_baked(self):
        scene = kinds.stage()
        scene.world = bpy.data.worlds.new("world")
        scene.world.use_nodes = True
        tree = scene.world.node_tree
        node = tree.nodes.new("ShaderNodeTexEnvironment")
        node.image = bpy.data.images.new("sky", 8, 4)
        tree.links.new(node.outputs["Color"], next(one for one in tree.nodes if one.type == "BACKGROUND").inputs["Color"])
        self.assertFalse(world.is_plain(scene))
        node.image.colorspace_settings.name = "Non-Color"
        self.assertTrue(world.is_plain(scene))
        node.interpolation = "Closest"
        self.assertFalse(world.is_plain(scene))
        node.interpolation, node.texture_mapping.rotation = "Linear", (0.0, 0.0, 1.0)
        self.assertFalse(world.is_plain(scene))

    def test_where_faces_are_not_looked_for_is_told(self):
        scene = kinds.stage()
        kinds.leaves(scene, kinds.matte())
        for most, is_told in ((400_000, False), (3, True)):
            with mock.patch.object(coincident, "MOST_TRIANGLES", most):
                found = {finding.id for finding in export.exported(scene, self.folder / "scene.glb").findings}
            self.assertEqual("coincident-unknown" in found, is_told)

    def test_a_bevelled_box_has_no_faces_in_one_place(self):
        """Its slanted ones lie between two axes."""
        scene = kinds.stage()
        bpy.ops.mesh.primitive_cube_add(size=1.2, location=(0.0, 0.0, 1.0))
        bpy.context.active_object.modifiers.new("bevel", "BEVEL").width = 0.1
        self.assertEqual(export.export(scene, self.folder / "scene.glb"), [])

    def test_fog_that_is_taken_away_is_gone(self):
        scene = kinds.stage()
        kinds.surfaces.world_of_fog(scene)
        own, volume = scene.sunfleck_settings, world.volume_of(scene)
        scene["sunfleck_note"] = "by hand"
        for is_fog in (True, False, True, False):
            own.use_fog = is_fog and not volume.is_linked
            export.export(scene, self.folder / "scene.glb")
            said = document(self.folder / "scene.glb")["scenes"][0]["extras"]
            self.assertEqual(("sunfleck_fog" in said, "sunfleck_note" in said), (is_fog, True))
            if volume.is_linked:
                scene.world.node_tree.links.remove(volume.links[0])

    def test_fog_above_the_ground_does_not_touch_it(self):
        scene = kinds.stage()
        kinds.surfaces.fog_box(scene)
        self.assertEqual(export.export(scene, self.folder / "scene.glb"), [])


class Rounded(unittest.TestCase):
    def test_levels_are_of_what_there_is(self):
        question = ("OBJECT_INFO", "Location", "")
        facts = [((question, (0.0, 0.0, 0.003 * row, 0.0)),) for row in range(1000)]
        levels = instances.Levels(facts, 16)
        rounded = {levels.rounded(one) for one in facts}
        self.assertEqual((levels.count, len(rounded)), (16, 16))
        off = max(abs(levels.rounded(one)[0][1][2] - one[0][1][2]) for one in facts)
        self.assertLess(off, 0.5 * 3.0 / 16 + 1e-9)

    def test_lines_have_more_texels(self):
        leaf = mock.Mock(triangles=[None] * 2)
        self.assertEqual((stage.size_on(leaf), stage.size_on(leaf, has_lines=True)), (256, 1024))
        tree = kinds.matte()
        self.assertFalse(dependence.has_lines(tree.material))
        tree.link(tree.node("Wireframe").outputs[0], tree.shader.inputs["Base Color"])
        self.assertTrue(dependence.has_lines(tree.material))

    def test_a_kind_is_one_line(self):
        found = [losses.Finding("hair", f"`{number}`") for number in range(9)] + [losses.Finding("no-camera")]
        self.assertEqual([one.of for one in losses.by_kind(found)], ["`0`, `1`, `2` and 6 more", ""])


class Named(Case):
    def test_an_extension_is_imported_by_its_short_name(self):
        """As Blender loads it from a repository, in a process of its own."""
        text = (
            "import importlib.util, sys, types; sys.modules['bl_ext'] = types.ModuleType('bl_ext'); "
            "spec = importlib.util.spec_from_file_location('bl_ext.sunfleck', sys.argv[1] + '/__init__.py', "
            "submodule_search_locations=[sys.argv[1]]); own = importlib.util.module_from_spec(spec); "
            "sys.modules[spec.name] = own; import bpy; spec.loader.exec_module(own); own.register(); "
            "import sunfleck.command; from sunfleck import export; print(sunfleck.command.__name__, export is own.export); "
            "own.unregister(); print('sunfleck' in sys.modules)"
        )
        run = [sys.executable, "-W", "ignore", "-c", text, str(Path(sunfleck.__file__).parent)]
        done = subprocess.run(run, capture_output=True, text=True, cwd="/", env={**os.environ, "PYTHONPATH": ""})
        self.assertEqual(done.stdout.splitlines()[-2:], ["bl_ext.sunfleck.command True", "False"], done.stderr)


class Returned(Case):
    def test_colours_are_smoothed_as_they_are_stored_after_a_way_out_and_back(self):
        scene = kinds.stage()
        kinds.surfaces.coarse_picture(scene)
        found = []
        for name, way in (("scene", None), ("again", "scene")):
            path = self.folder / f"{name}.glb"
            if way is None:
                export.export(scene, path)
            else:
                subprocess.run([PROGRAM, "export", self.folder / f"{way}.glb", path], check=True, capture_output=True)
            self.assertIn("encoded_filtering", str(document(path)["materials"]))
            picture = path.with_suffix(".exr")
            command = [PROGRAM, "render", path, "--samples", "4", "--bounces", "0", "--size", "64x36", "--passes", "none"]
            subprocess.run([*command, "--frames", "1", "--out", picture], check=True, capture_output=True)
            found.append(beside.pixels_of(picture))
        self.assertLess(numpy.abs(found[0] - found[1]).max(), 1e-6)


class Heard(Case):
    def test_the_program_s_warnings_are_reported(self):
        run = mock.Mock(complaints=["scene.glb: warning[dark-frame]: frames are next to black\n", "frame 1\n"])
        run.process.poll.return_value = 0
        self.assertEqual(render.Run.warnings(run), ["warning[dark-frame]: frames are next to black"])
        run.process.poll.return_value = 3
        self.assertEqual(render.Run.warnings(run), [])


def blocks(picture):
    """Means of 8 by 6 blocks."""
    rows, columns = picture.shape[0] // 6, picture.shape[1] // 8
    return picture[: 6 * rows, : 8 * columns].reshape(6, rows, 8, columns, 3).mean(axis=(1, 3))


if __name__ == "__main__":
    unittest.main()
