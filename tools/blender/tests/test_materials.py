"""Materials of every kind: what is exact, what is baked, and what is said.

Run with the other tests here (test_addon.py says how).
"""

import os
import tempfile
import unittest
from unittest import mock

import bpy
import leaf_scenes
import numpy
import scenes
import stages
from sunfleck import export
from sunfleck.evaluated.readback import File
from sunfleck.materials import library
from test_addon import document, inspect
from test_evaluated import Case


class Tree:
    """A material's nodes, in few words."""

    def __init__(self, name="shade"):
        self.material = bpy.data.materials.new(name)
        self.material.use_nodes = True
        self.nodes, self.links = self.material.node_tree.nodes, self.material.node_tree.links
        self.shader = self.nodes["Principled BSDF"]
        self.output = self.nodes["Material Output"]

    def node(self, kind, **values):
        made = self.nodes.new(f"ShaderNode{kind}")
        for name, value in values.items():
            setattr(made, name, value)
        return made

    def link(self, output, socket):
        self.links.new(output, socket)
        return self

    def mixed(self, share, a, b):
        """A mixture of two shaders as the surface."""
        mix = self.node("MixShader")
        if hasattr(share, "node"):
            self.link(share, mix.inputs[0])
        else:
            mix.inputs[0].default_value = share
        self.link(a.outputs[0], mix.inputs[1]).link(b.outputs[0], mix.inputs[2]).link(
            mix.outputs[0], self.output.inputs["Surface"]
        )


def checks(size=8, alpha=False, name="checks"):
    image = bpy.data.images.new(name, size, size, alpha=alpha)
    pixels = numpy.ones((size, size, 4), "f4")
    pixels[::2, ::2, :3] = (0.2, 0.4, 0.6)
    if alpha:
        pixels[: size // 2, :, 3] = 0.0
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    return image


class Materials(Case):
    def setUp(self):
        super().setUp()
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        os.environ["SUNFLECK_BAKES"] = folder.name
        self.addCleanup(os.environ.pop, "SUNFLECK_BAKES")
        self.scene = stages.stage((1, 1))

    def said(self, material, name="shade"):
        """The file's material, and the findings."""
        thing = scenes.quad(self.scene, "quad", 2.0, material)
        uv = thing.data.uv_layers.new(name="UVMap")
        uv.uv.foreach_set("vector", numpy.array([0, 0, 1, 0, 1, 1, 0, 1], "f4"))
        thing.data.color_attributes.new("tint", "FLOAT_COLOR", "POINT").data.foreach_set(
            "color", [0.5, 0.25, 1.0, 1.0] * 4
        )
        told = export.exported(self.scene, self.path)
        self.file = document(self.path)
        return next(one for one in self.file["materials"] if one["name"] == name), {
            finding.id: finding for finding in told.findings
        }

    def test_numbers_of_a_principled_bsdf_are_exact(self):
        tree = Tree()
        for name, value in {
            "Base Color": (0.1, 0.2, 0.3, 1.0), "Metallic": 0.25, "Roughness": 0.75, "IOR": 1.4, "Specular IOR Level": 0.25,
            "Coat Weight": 0.5, "Coat Roughness": 0.125, "Sheen Weight": 0.5, "Sheen Roughness": 0.5, "Transmission Weight": 0.25,
            "Emission Color": (1.0, 0.5, 0.25, 1.0), "Emission Strength": 4.0, "Alpha": 0.5,
        }.items():
            tree.shader.inputs[name].default_value = value
        said, findings = self.said(tree.material)
        pbr, extensions = said["pbrMetallicRoughness"], said["extensions"]
        numpy.testing.assert_allclose(pbr["baseColorFactor"], (0.1, 0.2, 0.3, 0.5), rtol=1e-6)
        self.assertEqual(
            (pbr["metallicFactor"], pbr["roughnessFactor"], said["alphaMode"]), (0.25, 0.75, "BLEND")
        )
        self.assertEqual(
            extensions["KHR_materials_clearcoat"], {"clearcoatFactor": 0.5, "clearcoatRoughnessFactor": 0.125}
        )
        self.assertEqual(extensions["KHR_materials_sheen"]["sheenColorFactor"], [0.5, 0.5, 0.5])
        self.assertEqual(extensions["KHR_materials_specular"], {"specularColorFactor": [0.5, 0.5, 0.5]})
        self.assertEqual(extensions["KHR_materials_emissive_strength"], {"emissiveStrength": 4.0})
        self.assertEqual(said["emissiveFactor"], [1.0, 0.5, 0.25])
        face = said["extras"]["sunfleck_material"]["thin_dielectric"]
        self.assertEqual((face["share"], face["one_face"]), (0.25, True))
        self.assertEqual(set(findings), {"material-glows", "material-lost"})
        self.assertEqual(findings["material-lost"].more, "sheen")

    def test_textures_with_their_coordinates_are_exact(self):
        tree = Tree()
        picture, mapping, uv = (
            tree.node("TexImage", image=checks(alpha=True)),
            tree.node("Mapping"),
            tree.node("UVMap", uv_map="UVMap"),
        )
        mapping.inputs["Scale"].default_value = (2.0, 3.0, 1.0)
        mapping.inputs["Rotation"].default_value[2] = 0.5
        tree.link(uv.outputs[0], mapping.inputs["Vector"]).link(mapping.outputs[0], picture.inputs["Vector"])
        cut = tree.node("Math", operation="GREATER_THAN")
        cut.inputs[1].default_value = 0.25
        tree.link(picture.outputs["Color"], tree.shader.inputs["Base Color"]).link(
            picture.outputs["Alpha"], cut.inputs[0]
        )
        tree.link(cut.outputs[0], tree.shader.inputs["Alpha"])
        said, findings = self.said(tree.material)
        info = said["pbrMetallicRoughness"]["baseColorTexture"]
        moved = info["extensions"]["KHR_texture_transform"]
        self.assertEqual((moved["scale"], moved["rotation"]), ([2.0, 3.0], 0.5))
        self.assertEqual((said["alphaMode"], said["alphaCutoff"]), ("MASK", 0.25))
        self.assertEqual(findings, {})
        self.assertEqual([loss["id"] for loss in inspect(self.path)["losses"]], [])

    def test_colour_attributes_multiply(self):
        tree = Tree()
        color, picture, mix = (
            tree.node("VertexColor", layer_name="tint"),
            tree.node("TexImage", image=checks()),
            tree.node("Mix"),
        )
        mix.data_type, mix.blend_type = "RGBA", "MULTIPLY"
        mix.inputs["Factor"].default_value = 1.0
        a, b = (next(one for one in mix.inputs if one.identifier == f"{name}_Color") for name in "AB")
        tree.link(color.outputs["Color"], a).link(picture.outputs["Color"], b)
        tree.link(
            next(one for one in mix.outputs if one.identifier == "Result_Color"),
            tree.shader.inputs["Base Color"],
        )
        said, findings = self.said(tree.material)
        self.assertEqual(findings, {})
        self.assertIn("COLOR_0", self.file["meshes"][0]["primitives"][0]["attributes"])

    def test_metallic_and_roughness_of_two_pictures_become_one(self):
        tree = Tree()
        for name, socket in (("rough", "Roughness"), ("metal", "Metallic")):
            picture = tree.node("TexImage", image=checks(name=name))
            picture.image.colorspace_settings.name = "Non-Color"
            tree.link(picture.outputs["Color"], tree.shader.inputs[socket])
        said, findings = self.said(tree.material)
        self.assertIn("metallicRoughnessTexture", said["pbrMetallicRoughness"])
        self.assertEqual(findings, {})

    def test_matte_mixtures_with_light_from_behind_are_exact(self):
        tree = Tree()
        front, back = tree.node("BsdfDiffuse"), tree.node("BsdfTranslucent")
        front.inputs["Color"].default_value, back.inputs["Color"].default_value = (
            (0.2, 0.4, 0.1, 1.0),
            (0.6, 0.8, 0.2, 1.0),
        )
        tree.mixed(0.25, front, back)
        said, findings = self.said(tree.material)
        through = said["extensions"]["KHR_materials_diffuse_transmission"]
        share = through["diffuseTransmissionFactor"]
        reflected = numpy.array(said["pbrMetallicRoughness"]["baseColorFactor"][:3]) * (1.0 - share)
        numpy.testing.assert_allclose(reflected, numpy.array((0.2, 0.4, 0.1)) * 0.75, rtol=1e-6)
        numpy.testing.assert_allclose(
            share * numpy.array(through["diffuseTransmissionColorFactor"]),
            numpy.array((0.6, 0.8, 0.2)) * 0.25,
            rtol=1e-6,
        )
        self.assertEqual(findings, {})

    def test_transparent_mixtures_are_coverage(self):
        tree = Tree()
        picture, clear = tree.node("TexImage", image=checks(64, alpha=True)), tree.node("BsdfTransparent")
        tree.link(picture.outputs["Color"], tree.shader.inputs["Base Color"])
        tree.mixed(picture.outputs["Alpha"], clear, tree.shader)
        said, findings = self.said(tree.material)
        self.assertEqual(said["alphaMode"], "BLEND")
        self.assertEqual(findings, {})

    def test_other_trees_are_baked(self):
        tree = Tree()
        noise, ramp = tree.node("TexNoise"), tree.node("ValToRGB")
        ramp.color_ramp.elements[0].color = (0.8, 0.1, 0.0, 1.0)
        ramp.color_ramp.elements[1].color = (0.1, 0.8, 0.0, 1.0)
        tree.link(noise.outputs["Fac"], ramp.inputs[0]).link(
            ramp.outputs[0], tree.shader.inputs["Base Color"]
        )
        said, findings = self.said(tree.material)
        self.assertIn("baseColorTexture", said["pbrMetallicRoughness"])
        self.assertEqual(findings["material-baked"].more, "at 256 x 256 texels, for its node `Noise Texture`")
        self.assertEqual(set(findings), {"material-baked"})
        # And kept: the second time there is the same picture, without Cycles.
        first, kept = self.path.read_bytes(), os.listdir(os.environ["SUNFLECK_BAKES"])
        self.assertEqual(len(kept), 1)
        export.exported(self.scene, self.path)
        self.assertEqual(self.path.read_bytes(), first)

    def test_groups_and_mixtures_are_baked(self):
        tree = Tree()
        group = bpy.data.node_groups.new("leaf", "ShaderNodeTree")
        group.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
        inner = {
            name: group.nodes.new(name)
            for name in ("ShaderNodeBsdfDiffuse", "ShaderNodeTexChecker", "NodeGroupOutput")
        }
        group.links.new(inner["ShaderNodeTexChecker"].outputs[0], inner["ShaderNodeBsdfDiffuse"].inputs[0])
        group.links.new(inner["ShaderNodeBsdfDiffuse"].outputs[0], inner["NodeGroupOutput"].inputs[0])
        node, back, noise = tree.node("Group"), tree.node("BsdfTranslucent"), tree.node("TexNoise")
        node.node_tree = group
        tree.mixed(noise.outputs["Fac"], node, back)
        said, findings = self.said(tree.material)
        self.assertIn("KHR_materials_diffuse_transmission", said["extensions"])
        self.assertEqual(set(findings), {"material-baked"})
        self.assertEqual([group.name for group in bpy.data.node_groups], ["leaf"])
        self.assertEqual([loss["id"] for loss in inspect(self.path)["losses"]], [])

    def test_a_group_keeps_its_shine(self):
        tree = Tree()
        group = bpy.data.node_groups.new("shiny", "ShaderNodeTree")
        group.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
        inner, end = group.nodes.new("ShaderNodeBsdfPrincipled"), group.nodes.new("NodeGroupOutput")
        inner.inputs["Specular IOR Level"].default_value = 0.25
        group.links.new(inner.outputs[0], end.inputs[0])
        node = tree.node("Group")
        node.node_tree = group
        tree.link(node.outputs[0], tree.output.inputs["Surface"])
        said, findings = self.said(tree.material)
        self.assertEqual(said["extensions"]["KHR_materials_specular"], {"specularColorFactor": [0.5] * 3})
        self.assertTrue(said["extras"]["sunfleck_material"]["principled"])
        self.assertEqual(set(findings), set())

    def test_hair_has_the_colours_of_its_roots(self):
        tree = Tree()
        tree.link(tree.node("TexImage", image=checks()).outputs["Color"], tree.shader.inputs["Base Color"])
        emitter = scenes.quad(self.scene, "emitter", 2.0, tree.material)
        emitter.data.uv_layers.new(name="UVMap").uv.foreach_set(
            "vector", numpy.array([0, 0, 1, 0, 1, 1, 0, 1], "f4")
        )
        settings = emitter.modifiers.new("hair", "PARTICLE_SYSTEM").particle_system.settings
        settings.type, settings.count, settings.hair_length = "HAIR", 20, 0.5
        emitter.show_instancer_for_render = False
        export.exported(self.scene, self.path)
        file = File(self.path)
        mesh = next(
            mesh for mesh in file.said["meshes"] if "TEXCOORD_0" in mesh["primitives"][0]["attributes"]
        )
        primitive = mesh["primitives"][0]
        indices = file.accessor(primitive["indices"]).ravel()
        places, uvs = (
            file.accessor(primitive["attributes"][name])[indices] for name in ("POSITION", "TEXCOORD_0")
        )
        # Roots are the lowest corners; the square is two metres wide, and v goes down in glTF as z
        # does towards the camera.
        roots = places[:, 1] < 1e-3
        self.assertGreaterEqual(int(roots.sum()), 20)
        expected = numpy.stack([0.5 + 0.5 * places[roots, 0], 0.5 + 0.5 * places[roots, 2]], axis=1)
        numpy.testing.assert_allclose(uvs[roots], expected, atol=0.02)

    def test_bumps_become_normal_maps(self):
        tree = Tree()
        noise, bump = tree.node("TexNoise"), tree.node("Bump")
        tree.link(noise.outputs["Fac"], bump.inputs["Height"]).link(
            bump.outputs[0], tree.shader.inputs["Normal"]
        )
        said, findings = self.said(tree.material)
        self.assertIn("normalTexture", said)
        self.assertEqual(set(findings), {"material-baked"})

    def test_a_second_colour_attribute_is_baked(self):
        tree = Tree()
        color = tree.node("VertexColor", layer_name="tint")
        tree.link(color.outputs["Color"], tree.shader.inputs["Roughness"])
        said, findings = self.said(tree.material)
        # The mean of what it is at all corners: it is the same at each.
        self.assertAlmostEqual(
            said["pbrMetallicRoughness"]["roughnessFactor"], 0.2126 * 0.5 + 0.7152 * 0.25 + 0.0722, 3
        )
        self.assertEqual(set(findings), {"material-baked"})

    def test_leaves_of_the_panel_stay_leaves_among_instances(self):
        tree = Tree()
        tree.material.sunfleck_settings.is_leaf = True
        collection = bpy.data.collections.new("leaves")
        thing = scenes.quad(self.scene, "leaf", 1.0, tree.material)
        self.scene.collection.objects.unlink(thing)
        collection.objects.link(thing)
        empty = scenes.add(self.scene, "group", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
        export.exported(self.scene, self.path)
        self.assertEqual(
            document(self.path)["materials"][0]["extras"]["sunfleck_leaf"], {"translucency": 0.5}
        )

    def test_meshes_that_change_all_the_time_are_not_baked_without_end(self):
        tree = Tree()
        tree.link(tree.node("TexNoise").outputs["Color"], tree.shader.inputs["Base Color"])
        row = scenes.quad(self.scene, "row", 0.2, tree.material)
        self.scene.frame_end = 4
        stages.key(row.modifiers.new("array", "ARRAY"), "count", (1, 4), frames=(1, 4))
        with mock.patch.object(library, "MOST_MESHES", 2):
            told = export.exported(self.scene, self.path)
        self.assertEqual(
            {finding.id: finding.more for finding in told.findings}["material-lost"], "mean-colours"
        )
        textured = [
            "baseColorTexture" in one["pbrMetallicRoughness"] for one in document(self.path)["materials"]
        ]
        self.assertEqual(sorted(textured), [False, False, True, True])

    def randomly(self):
        """A colour by Cycles' random number."""
        tree = Tree()
        info, ramp = tree.node("ObjectInfo"), tree.node("ValToRGB")
        tree.link(info.outputs["Random"], ramp.inputs[0]).link(
            ramp.outputs[0], tree.shader.inputs["Base Color"]
        )
        return tree

    def test_random_colours_are_those_of_cycles(self):
        tree = self.randomly()
        scenes.quad(self.scene, "some leaf", 1.0, tree.material, (2.0, 0.0, 0.0))
        _, findings = self.said(tree.material, "shade 1")
        self.assertEqual(findings, {})
        of_mesh = {node["name"]: node["mesh"] for node in self.file["nodes"] if "mesh" in node}
        numbers = {
            name: self.file["meshes"][mesh]["primitives"][0]["material"] for name, mesh in of_mesh.items()
        }
        colors = {
            name: self.file["materials"][number]["pbrMetallicRoughness"]["baseColorFactor"][0]
            for name, number in numbers.items()
        }
        # Measured in Cycles.
        self.assertAlmostEqual(colors["some leaf"], 0.948119, 5)
        self.assertNotAlmostEqual(colors["quad"], colors["some leaf"], 2)
        self.assertEqual([material.name for material in bpy.data.materials], ["shade"])

    def test_attributes_of_instances_are_kept(self):
        """Sixty leaves with a colour each."""
        scene = leaf_scenes.build("nodes")
        scene.frame_end = 2
        tree = Tree()
        asked = tree.node("Attribute", attribute_type="INSTANCER", attribute_name="tint")
        tree.link(asked.outputs["Color"], tree.shader.inputs["Base Color"])
        bpy.data.objects["leaf"].data.materials[0] = tree.material
        group = bpy.data.node_groups["fall"]
        store, index = (
            group.nodes.new("GeometryNodeStoreNamedAttribute"),
            group.nodes.new("GeometryNodeInputIndex"),
        )
        store.data_type, store.domain = "FLOAT_COLOR", "INSTANCE"
        store.inputs["Name"].default_value = "tint"
        divide = group.nodes.new("ShaderNodeMath")
        divide.operation = "DIVIDE"
        divide.inputs[1].default_value = 60.0
        end = next(node for node in group.nodes if node.type == "GROUP_OUTPUT")
        group.links.new(index.outputs[0], divide.inputs[0])
        value = next(socket for socket in store.inputs if socket.name == "Value" and socket.enabled)
        group.links.new(divide.outputs[0], value)
        group.links.new(end.inputs[0].links[0].from_socket, store.inputs["Geometry"])
        group.links.new(store.outputs[0], end.inputs[0])
        told = export.exported(scene, self.path)
        self.assertEqual([finding.id for finding in told.findings], [])
        shades = [one for one in document(self.path)["materials"] if one["name"].startswith("shade")]
        colors = sorted(one["pbrMetallicRoughness"]["baseColorFactor"][0] for one in shades)
        # And the pattern itself, which has none.
        numpy.testing.assert_allclose(colors, sorted([0.0, *(at / 60.0 for at in range(60))]), atol=1e-6)

    def test_what_cannot_be_baked_is_said(self):
        tree = Tree()
        tree.link(tree.node("Holdout").outputs[0], tree.output.inputs["Surface"])
        said, findings = self.said(tree.material)
        self.assertEqual(set(findings), {"material-not-honoured"})

    def test_lost_parts_are_said(self):
        tree = Tree()
        tree.shader.inputs["Subsurface Weight"].default_value = 0.5
        tree.shader.inputs["Anisotropic"].default_value = 0.5
        _, findings = self.said(tree.material)
        self.assertEqual(findings["material-lost"].more, "anisotropy, subsurface")


if __name__ == "__main__":
    unittest.main()
