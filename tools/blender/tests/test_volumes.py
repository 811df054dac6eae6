"""Volumes: files, those that nodes make, sequences; beside Cycles, and what is said of them.

Run with the other tests here (test_addon.py says how).
"""

import math
import os
import subprocess
import sys
from pathlib import Path
from unittest import mock

import bpy
import numpy
import scenes
from leaf_scenes import Tree as Nodes
from sunfleck import check, export
from test_addon import PROGRAM, Case, document, inspect
from test_kinds import blocks

sys.path.append(str(Path(__file__).parents[2]))

from sunfleck_tools.peers import beside

bpy.utils.expose_bundled_modules()
import openvdb

SIZE = (16, 16, 16)


def write_grid(path, values, edge=0.1, name="density"):
    """Voxels about the origin."""
    return write_grids(path, {name: values}, edge)


def write_grids(path, by_name, edge=0.1):
    """Numbers or colours, of names."""
    made = []
    for name, values in by_name.items():
        grid = openvdb.FloatGrid() if values.ndim == 3 else openvdb.Vec3SGrid()
        grid.name, grid.gridClass = name, openvdb.GridClass.FOG_VOLUME
        grid.copyFromArray(numpy.ascontiguousarray(values, "f4"))
        low = [-0.5 * edge * (side - 1) for side in values.shape[:3]]
        grid.transform = openvdb.createLinearTransform([[edge, 0, 0, 0], [0, edge, 0, 0], [0, 0, edge, 0], [*low, 1]])
        made.append(grid)
    openvdb.write(str(path), made)
    return path


def even(value=1.0):
    return numpy.full(SIZE, value)


def rimmed(values):
    """Nothing at the rim: Cycles cuts a grid off where its blocks of 8 voxels end, in the midst of the slope."""
    values[[0, -1]] = values[:, [0, -1]] = values[:, :, [0, -1]] = 0.0
    return values


def uneven():
    return numpy.random.default_rng(7).uniform(0.0, 2.0, SIZE)


def flame():
    """Hottest in the middle."""
    apart = numpy.linspace(-1.0, 1.0, SIZE[0])
    squares = sum(axis**2 for axis in numpy.meshgrid(apart, apart, apart, indexing="ij"))
    return rimmed(numpy.maximum(0.0, 1.0 - squares))


def principled(name="mist", **inputs):
    """A material; names of inputs have an underscore for a space."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    volume, out = tree.nodes.new("ShaderNodeVolumePrincipled"), tree.nodes.new("ShaderNodeOutputMaterial")
    for name, value in inputs.items():
        volume.inputs[name.replace("_", " ")].default_value = value
    tree.links.new(volume.outputs[0], out.inputs["Volume"])
    return made


def volume(scene, path, material=None, location=(0.0, 0.0, 1.0)):
    data = bpy.data.volumes.new("mist")
    data.filepath, data.render.precision = str(path), "FULL"
    if material:
        data.materials.append(material)
    return scenes.add(scene, "mist", data, location)


def by_steps(scene):
    """Cycles marches in steps of half its usual length: what it bounds its random steps by takes 3 to 5 CPU s a picture."""
    scene.cycles.volume_biased, scene.cycles.volume_step_rate = True, 0.5


class Volumes(Case):
    def export(self, name="scene.glb"):
        told = export.exported(self.scene, self.folder / name)
        found = [node for node in document(self.folder / name)["nodes"] if "sunfleck_fog_volume" in node.get("extras", {})]
        return told, found

    def said(self, told):
        return [(finding.id, finding.more) for finding in told.findings if finding.id.startswith("volume")]

    def stage(self, path, **inputs):
        scenes.camera(self.scene)
        scenes.sun(self.scene)
        return volume(self.scene, path, principled(**inputs))

    def test_a_file_is_named_where_it_lies(self):
        (self.folder / "my grids").mkdir()
        path = write_grid(self.folder / "my grids" / "a.vdb", even())
        thing = self.stage(path, Density=0.5, Color=(1.0, 0.5, 0.25, 1.0), Anisotropy=0.3)
        thing.scale = (2.0, 2.0, 2.0)
        thing.rotation_euler = (0.0, 0.0, 0.5)
        told, (node,) = self.export()
        self.assertEqual(self.said(told), [])
        fog = node["extras"]["sunfleck_fog_volume"]
        self.assertEqual((fog["vdb"], fog["grid"]), ("my%20grids/a.vdb", "density"))
        # What is not scattered is absorbed, and what is twice as large is half as dense.
        numpy.testing.assert_allclose(fog["density"], [0.25] * 3, rtol=1e-6)
        numpy.testing.assert_allclose(fog["albedo"], [1.0, 0.5, 0.25], rtol=1e-6)
        self.assertAlmostEqual(fog["anisotropy"], 0.3, places=6)
        thing.data.render.space = "WORLD"
        numpy.testing.assert_allclose(self.export()[1][0]["extras"]["sunfleck_fog_volume"]["density"], [0.5] * 3)

    def test_mist_is_that_of_a_scene_file(self):
        """Turned by the object, and blown for a second; both draw the same noise."""
        scenes.camera(self.scene, (0.0, -12.0, 0.0), (0.0, 0.0, 0.0))
        scenes.sun(self.scene)
        box = scenes.fog_box(self.scene, (-3.0, -2.0, -1.0), (3.0, 2.0, 1.0), density=0.8)
        own = box.sunfleck_settings
        own.use_mist, own.mist_size, own.mist_octaves, own.mist_cover, own.mist_seed = True, 1.5, 2, 0.6, 3
        own.mist_wind, own.mist_evolution_turns, own.mist_shape = (1.0, 0.5, 0.25), 0.3, "ellipsoid"
        own.anisotropy, own.thins_out, own.scale_height = 0.0, True, 2.0
        box.rotation_euler.z = math.radians(30.0)
        self.scene.frame_start = self.scene.frame_end = 24
        glb, ron = self.folder / "mist.glb", self.folder / "mist.ron"
        self.assertEqual(export.export(self.scene, glb), [])
        angle = math.degrees(2.0 * math.atan(math.tan(math.radians(22.5)) * 36.0 / 64.0))
        ron.write_text(f"""Scene(version: 1,
            meshes: {{ "none": Quad(size_m: 0.001) }}, materials: {{ "none": () }},
            objects: {{ "turned": (mesh: "none", material: "none", rotation_deg: (0.0, 30.0, 0.0)) }},
            cameras: {{ "main": (position_m: (0.0, 0.0, 12.0), look_at_m: (0.0, 0.0, 0.0), fov_deg: {angle}) }},
            lights: {{ "sun": Sun(to_sun: (-0.3, 1.0, 0.4), irradiance_w_per_m2: (3.0, 3.0, 3.0)) }},
            fog: {{ "mist": (parent: "turned", min_m: (-3.0, -1.0, -2.0), max_m: (3.0, 1.0, 2.0),
                scale_height_m: 2.0, density_per_m: {own.density}, mist: (size_m: 1.5, octaves: 2, cover: {own.mist_cover},
                wind_m_per_s: (1.0, 0.25, -0.5), evolution_turns: {own.mist_evolution_turns}, shape: Ellipsoid, seed: 3)) }})""")
        sequence = self.folder / "sequence.ron"
        sequence.write_text('Sequence(version: 1, scene: "mist.ron", frames: (24, 24), frame_rate: 24, size: (64, 36), samples: 4)')
        found = []
        for file in (glb, sequence):
            run = [PROGRAM, "render", file, "--frames", "24", "--samples", "4", "--bounces", "0", "--passes", "none"]
            subprocess.run([*run, "--out", self.folder / "out.exr", "--skip", "none"], check=True, capture_output=True)
            found.append(beside.pixels_of(self.folder / "out.exr"))
        ours, theirs = found
        self.assertGreater(theirs.std(), 0.1 * theirs.mean())
        numpy.testing.assert_allclose(ours, theirs, atol=2e-3 * theirs.max())

    def test_mist_that_changes_is_carried(self):
        scenes.camera(self.scene)
        scenes.sun(self.scene)
        own = scenes.fog_box(self.scene).sunfleck_settings
        own.use_mist, self.scene.frame_end = True, 5
        for frame, cover, wind in ((1, 0.2, (0.0, 0.0, 0.0)), (5, 0.8, (1.0, 2.0, 0.5))):
            own.mist_cover, own.mist_wind = cover, wind
            for name in ("mist_cover", "mist_wind"):
                own.keyframe_insert(name, frame=frame)
        self.export()
        carried = {
            node["extras"]["sunfleck_ctl"]["target"].rpartition(".")[2]
            for node in document(self.folder / "scene.glb")["nodes"] if "sunfleck_ctl" in node.get("extras", {})
        }
        self.assertEqual(carried, {"mist_cover", "mist_wind"})
        self.assertEqual(inspect(self.folder / "scene.glb")["remarks"], [])

    def test_densities_that_change_are_carried(self):
        thing = self.stage(write_grid(self.folder / "a.vdb", even()))
        self.scene.frame_end = 5
        socket = thing.data.materials[0].node_tree.nodes["Principled Volume"].inputs["Density"]
        for frame, value in ((1, 1.0), (5, 3.0)):
            socket.default_value = value
            socket.keyframe_insert("default_value", frame=frame)
        told, _ = self.export()
        self.assertEqual(self.said(told), [])
        nodes = document(self.folder / "scene.glb")["nodes"]
        targets = [node["extras"]["sunfleck_ctl"]["target"] for node in nodes if "sunfleck_ctl" in node.get("extras", {})]
        self.assertEqual(targets, ["mist.sunfleck_fog_volume.density"])

    def test_what_modifiers_and_nodes_make_is_written_beside(self):
        scenes.camera(self.scene)
        tree = Nodes(scenes.quad(self.scene, "cloud of nodes", 1.0, scenes.material("shade", (1.0, 1.0, 1.0))))
        cube, put = tree.node("GeometryNodeVolumeCube"), tree.node("GeometryNodeSetMaterial")
        for axis in "XYZ":
            cube.inputs[f"Resolution {axis}"].default_value = 8
        put.inputs["Material"].default_value = principled()
        tree.link(cube.outputs["Volume"], put.inputs["Geometry"])
        tree.link(put.outputs["Geometry"], tree.target.inputs["Geometry"])
        self.scene.frame_end = 3
        told, (node,) = self.export()
        self.assertEqual(self.said(told), [])
        self.assertEqual(node["extras"]["sunfleck_fog_volume"]["vdb"], "scene.glb.cloud_of_nodes.vdb")
        self.assertEqual([path.name for path in self.folder.glob("*.vdb")], ["scene.glb.cloud_of_nodes.vdb"])
        # And as it changes: a file a frame, none of an earlier export.
        (self.folder / "scene.glb.cloud_of_nodes.0009.vdb").touch()
        for frame in (1, 3):
            cube.inputs["Density"].default_value = float(frame)
            cube.inputs["Density"].keyframe_insert("default_value", frame=frame)
        self.assertEqual(self.export()[1][0]["extras"]["sunfleck_fog_volume"]["vdb"], "scene.glb.cloud_of_nodes.%23%23%23%23.vdb")
        self.assertEqual(len(list(self.folder.glob("scene.glb.cloud_of_nodes.0*.vdb"))), 3)
        inspect(self.folder / "scene.glb")

    def sequence(self, offset):
        for number in (1, 2, 3):
            write_grid(self.folder / f"a.{number:04d}.vdb", even(number))
        thing = self.stage(self.folder / "a.0001.vdb")
        data = thing.data
        data.is_sequence, data.frame_duration, data.frame_start = True, 3, 1 + offset
        self.scene.frame_start, self.scene.frame_end = 1 + offset, 3 + offset
        return self.export()

    def test_a_sequence_by_frames_is_named_where_it_lies(self):
        told, (node,) = self.sequence(0)
        self.assertEqual(node["extras"]["sunfleck_fog_volume"]["vdb"], "a.%23%23%23%23.vdb")
        self.assertEqual(self.said(told), [])

    def test_another_is_laid_beside_by_frames(self):
        _, (node,) = self.sequence(10)
        self.assertEqual(node["extras"]["sunfleck_fog_volume"]["vdb"], "scene.glb.mist.%23%23%23%23.vdb")
        for frame in (1, 2, 3):
            laid = self.folder / f"scene.glb.mist.{frame + 10:04d}.vdb"
            self.assertEqual(laid.read_bytes(), (self.folder / f"a.{frame:04d}.vdb").read_bytes())

    def test_densities_by_attributes(self):
        """The nodes of older scenes."""
        thing = self.stage("")
        for kind, name in (("ShaderNodeAttribute", "smoke"), ("ShaderNodeVolumeInfo", "density")):
            thing.data.filepath = str(write_grid(self.folder / f"{name}.vdb", even(), name=name))
            material = principled(name)
            tree = material.node_tree
            tree.nodes.remove(tree.nodes["Principled Volume"])
            scatter, source, times = (tree.nodes.new(each) for each in ("ShaderNodeVolumeScatter", kind, "ShaderNodeMath"))
            times.operation, times.inputs[1].default_value = "MULTIPLY", 0.25
            if kind == "ShaderNodeAttribute":
                source.attribute_name = name
            output = next(one for one in source.outputs if one.name in {"Fac", "Factor", "Density"})
            scatter.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
            tree.links.new(output, times.inputs[0])
            tree.links.new(times.outputs[0], scatter.inputs["Density"])
            tree.links.new(scatter.outputs[0], tree.nodes["Material Output"].inputs["Volume"])
            thing.data.materials[0] = material
            told, (node,) = self.export()
            fog = node["extras"]["sunfleck_fog_volume"]
            self.assertEqual((self.said(told), fog["grid"]), ([], name))
            numpy.testing.assert_allclose(fog["density"], [0.25] * 3)

    def test_what_is_lost_is_said(self):
        path = write_grid(self.folder / "a.vdb", even())
        thing = self.stage(path, Color_Attribute="Cd", Blackbody_Intensity=1.0, Density_Attribute="density")
        told, found = self.export()
        self.assertEqual((self.said(told), len(found)), ([("volume-lost", "the light that it gives off")], 1))
        material = thing.data.materials[0]
        node = material.node_tree.nodes["Principled Volume"]
        node.inputs["Blackbody Intensity"].default_value = 0.0
        thing.data.render.clipping = 0.5
        self.assertEqual(self.said(self.export()[0]), [("volume-lost", "its clipping: thin voxels are not empty")])
        thing.data.render.clipping = 0.001
        node.inputs["Color Attribute"].default_value = "density"
        self.assertEqual(self.said(self.export()[0]), [("volume-lost", "its colours by the grid `density`")])
        node.inputs["Density Attribute"].default_value = "smoke"
        told, found = self.export()
        self.assertEqual((self.said(told), found), ([("volume", "it has no grid of floats `smoke`")], []))
        noise = material.node_tree.nodes.new("ShaderNodeTexNoise")
        material.node_tree.links.new(noise.outputs[0], node.inputs["Density"])
        ids = [finding.id for finding in check.check(self.scene)]
        self.assertIn("volume", ids)
        thing.data.filepath = str(self.folder / "nowhere.vdb")
        self.assertIn("volume", [id for id, _ in self.said(self.export()[0])])

    def test_optical_depths_are_those_of_cycles(self):
        """Before a wall that shines, in fog that only absorbs."""
        for name, values in (("even", even()), ("uneven", uneven())):
            self.scene = scenes.empty()
            path = write_grid(self.folder / f"{name}.vdb", rimmed(values))
            wall = scenes.quad(self.scene, "wall", 20.0, scenes.material("wall", (0.0, 0.0, 0.0)), (0.0, 3.0, 1.0))
            wall.rotation_euler = (math.radians(90.0), 0.0, 0.0)
            shader = wall.data.materials[0].node_tree.nodes["Principled BSDF"]
            shader.inputs["Emission Color"].default_value = (1.0, 1.0, 1.0, 1.0)
            shader.inputs["Emission Strength"].default_value = 1.0
            scenes.camera(self.scene, (0.0, -4.0, 1.0), (0.0, 0.0, 1.0), 20.0)
            thing = volume(self.scene, path, principled(Density=0.8, Color=(0.0, 0.0, 0.0, 1.0)))
            thing.rotation_euler = (0.3, 0.2, 0.5)
            thing.scale = (1.5, 1.0, 0.8)
            wish = beside.Wish(PROGRAM, 1, (64, 48), 64, 64)
            by_steps(self.scene)
            with mock.patch.dict(os.environ, {"SUNFLECK_BAKES": str(self.folder)}):
                ours, theirs, findings = beside.pictures(self.scene, wish, self.folder)
            depths = [-numpy.log(blocks(picture)) for picture in (ours, theirs)]
            deep = depths[1] > 0.3
            self.assertGreater(int(deep.sum()), 12, name)
            off = numpy.abs(depths[0][deep] / depths[1][deep] - 1.0)
            mean = depths[0][deep].mean() / depths[1][deep].mean()
            print(f"{name}: depth {depths[1].max():.4f} at most, mean {mean:.5f}, blocks off {off.max():.5f}, {off.mean():.5f}")
            self.assertLess(abs(mean - 1.0), 0.01, name)

    def beside_cycles(self, bounces=0):
        """Means, and what the export found."""
        wish = beside.Wish(PROGRAM, 1, (48, 36), 64, 256, bounces)
        by_steps(self.scene)
        with mock.patch.dict(os.environ, {"SUNFLECK_BAKES": str(self.folder)}):
            ours, theirs, findings = beside.pictures(self.scene, wish, self.folder)
        self.assertEqual([finding for finding in findings if finding.id.startswith("volume")], [])
        ratio = ours.mean(axis=(0, 1)) / theirs.mean(axis=(0, 1))
        print(f"mean {theirs.mean():.5f}, ratio {ours.mean() / theirs.mean():.5f}, by channel {ratio.round(4)}")
        return ratio

    def test_fire_is_that_of_cycles(self):
        """It scatters nothing: Cycles sees some of that light without bounces."""
        path = write_grids(self.folder / "a.vdb", {"density": flame(), "flame": flame()})
        material = principled("fire", Density=0.5, Color=(0.0, 0.0, 0.0, 1.0), Emission_Color=(1.0, 0.4, 0.1, 1.0))
        nodes, links = material.node_tree.nodes, material.node_tree.links
        source, times = nodes.new("ShaderNodeAttribute"), nodes.new("ShaderNodeMath")
        source.attribute_name, times.operation, times.inputs[1].default_value = "flame", "MULTIPLY", 3.0
        links.new(next(one for one in source.outputs if one.name in {"Fac", "Factor"}), times.inputs[0])
        links.new(times.outputs[0], nodes["Principled Volume"].inputs["Emission Strength"])
        scenes.camera(self.scene, (0.0, -4.0, 1.0), (0.0, 0.0, 1.0), 30.0)
        volume(self.scene, path, material)
        self.assertLess(numpy.abs(self.beside_cycles() - 1.0).max(), 0.005)

    def test_colours_by_a_grid_are_those_of_cycles(self):
        colors = numpy.stack([flame(), 0.5 * flame(), 0.2 * flame()], axis=-1)
        path = write_grids(self.folder / "a.vdb", {"density": rimmed(uneven()), "Cd": colors})
        scenes.camera(self.scene, (0.0, -4.0, 1.0), (0.0, 0.0, 1.0), 30.0)
        scenes.sun(self.scene)
        volume(self.scene, path, principled(Density=1.0, Color=(1.0, 1.0, 1.0, 1.0), Color_Attribute="Cd"))
        self.assertLess(numpy.abs(self.beside_cycles() - 1.0).max(), 0.02)

    def test_the_engine_shows_it(self):
        self.stage(write_grid(self.folder / "a.vdb", even()), Density=2.0, Color=(1.0, 1.0, 1.0, 1.0))
        render, own = self.scene.render, self.scene.sunfleck_settings
        render.engine, render.filepath = "SUNFLECK", str(self.folder / "out_")
        render.resolution_x, render.resolution_y = 32, 18
        render.image_settings.file_format = "OPEN_EXR"
        own.use_samples, own.samples, own.all_bounces, own.bounces = True, 4, False, 0
        self.assertEqual(bpy.ops.render.render(write_still=True), {"FINISHED"})
        picture = beside.pixels_of(self.folder / "out_.exr")
        self.assertGreater(picture[9, 16].mean(), 10.0 * picture[0, 0].mean() + 1e-3)


if __name__ == "__main__":
    import unittest

    unittest.main()
