"""Rendered frames in Blender's compositor: every pass by its name, with its values, frame by frame.

The truth is what OpenEXR reads, in the process of the tools: Blender brings an OpenEXR of its own.
"""

import json
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

import bpy
import numpy as np
import scenes
from sunfleck import frames
from test_review import DATA, PROGRAM, TOOLS, run

WIDTH, HEIGHT = 32, 18
PASSES = "shafts,transmittance,depth,normal,position,albedo,leaf-id,motion,cryptomatte"
# Blender's name, and the file's channels.
NAMES = {
    "Combined": "RGBA", "Depth": "Z", "Normal": "Normal", "Position": "Position", "albedo": "albedo", "leaf_id": "leaf_id",
    "shafts": "shafts", "transmittance": "transmittance", "Vector": "Vector",
}  # fmt: skip
READ = """
import sys, numpy, OpenEXR
channels = OpenEXR.File(sys.argv[1]).channels()
split = lambda name: [channels[f"{name}.{axis}"].pixels for axis in "XYZW" if f"{name}.{axis}" in channels]
found = {name: channels[name].pixels if name in channels else numpy.stack(split(name), axis=-1) for name in sys.argv[3:]}
# Ranks of an id and its coverage; ids as the manifest has them.
ranks = numpy.concatenate([channels[f"CryptoObject0{layer}"].pixels for layer in range(3)], axis=-1)
header = OpenEXR.File(sys.argv[1]).header()
found |= {"coverages": ranks[..., 1::2]}
ids = numpy.ascontiguousarray(ranks[..., 0::2]).view(numpy.uint32)
manifest = next(value for name, value in header.items() if name.endswith("/manifest"))
numpy.savez(sys.argv[2], ids=ids, manifest=manifest, **{name: numpy.float32(values).reshape(*values.shape[:2], -1) for name, values in found.items()})
"""


@unittest.skipUnless(shutil.which(TOOLS), "sunfleck-tools is not installed: SUNFLECK_TOOLS names it")
class Compositor(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = Path(folder.name)
        glb, size = cls.folder / "review.glb", f"{WIDTH}x{HEIGHT}"
        run(PROGRAM, "export", DATA / "review.ron", glb, "--frames", "1-3")
        run(PROGRAM, "render", glb, "--size", size, "--samples", 4, "--bounces", 0, "--passes", PASSES, "--out", cls.folder / "frames")

    def setUp(self):
        self.scene = scenes.empty(frames=(1, 3), size=(WIDTH, HEIGHT))
        self.scene.render.engine, self.scene.cycles.samples = "CYCLES", 1
        self.scene.view_settings.view_transform = "Raw"
        scenes.camera(self.scene)
        self.load()

    def load(self):
        """Puts the sequence into a compositor whose output is `self.output`."""
        self.files = sorted((self.folder / "frames").glob("*.exr"))
        image, first, last = frames.load(self.files[0])
        self.assertEqual((first, last), (1, 3))
        self.tree = bpy.data.node_groups.new("look", "CompositorNodeTree")
        self.image = self.tree.nodes.new("CompositorNodeImage")
        self.image.image = image
        self.image.frame_start, self.image.frame_duration = first, last
        self.tree.interface.new_socket(name="Image", in_out="OUTPUT", socket_type="NodeSocketColor")
        self.output = self.tree.nodes.new("NodeGroupOutput").inputs[0]
        self.scene.compositing_node_group = self.tree

    def truth(self, frame):
        """Every pass of a file, rows from the top."""
        python, values = Path(shutil.which(TOOLS)).with_name("python"), self.folder / "values.npz"
        command = [python, "-c", READ, self.files[frame - 1], values, *NAMES.values()]
        subprocess.run([str(part) for part in command], check=True)
        return np.load(values)

    def composited(self, socket, frame):
        """What the compositor makes of a socket at a frame."""
        for link in list(self.tree.links):
            if link.to_socket == self.output:
                self.tree.links.remove(link)
        self.tree.links.new(socket, self.output)
        settings = self.scene.render.image_settings
        settings.file_format, settings.color_mode, settings.color_depth = "OPEN_EXR", "RGBA", "32"
        path = self.folder / f"composited_{len(list(self.folder.iterdir()))}.exr"
        self.scene.render.filepath = str(path)
        self.scene.frame_set(frame)
        bpy.ops.render.render(write_still=True)
        shown = bpy.data.images.load(str(path))
        return np.array(shown.pixels[:]).reshape(HEIGHT, WIDTH, 4)[::-1]

    def test_every_pass_has_its_name_and_its_values(self):
        shown = {output.name for output in self.image.outputs if output.enabled}
        self.assertLessEqual(set(NAMES), shown)
        truth = self.truth(2)
        for name, channels in NAMES.items():
            expected = truth[channels]
            found = self.composited(self.image.outputs[name], 2)[..., : expected.shape[2]]
            np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-6, err_msg=name)
            self.assertGreater(np.ptp(expected), 0, name)

    def test_frames_follow_each_other(self):
        found = [self.composited(self.image.outputs["Position"], frame)[..., :3] for frame in (1, 3)]
        for frame, values in zip((1, 3), found):
            np.testing.assert_allclose(values, self.truth(frame)["Position"], rtol=1e-6, atol=1e-6)
        self.assertFalse(np.array_equal(*found))

    def test_a_leaf_is_picked_by_its_number(self):
        ids = self.truth(2)["leaf_id"][..., 0]
        # Any that falls; 1 and 2 hang and lie.
        chosen = int(ids[ids > 2][0])
        mask = self.tree.nodes.new("CompositorNodeIDMask")
        mask.inputs["Index"].default_value = chosen
        self.tree.links.new(self.image.outputs["leaf_id"], mask.inputs[0])
        found = self.composited(mask.outputs[0], 2)[..., 0]
        np.testing.assert_array_equal(found > 0.5, ids == chosen)

    def test_a_leaf_is_picked_by_its_name(self):
        truth = self.truth(2)
        manifest = {name: int(number, 16) for name, number in json.loads(str(truth["manifest"])).items()}
        self.assertIn("ground", manifest)
        node = self.tree.nodes.new("CompositorNodeCryptomatteV2")
        node.source, node.image, node.layer_name = "IMAGE", self.image.image, "CryptoObject"
        node.frame_start, node.frame_duration = self.image.frame_start, self.image.frame_duration
        shares = {
            name: np.where(truth["ids"] == number, truth["coverages"], 0).sum(axis=-1)
            for name, number in manifest.items()
        }
        leaf = max(
            (name for name in shares if name.startswith("falling.")), key=lambda name: shares[name].sum()
        )
        for name in (leaf, "hanging leaf", "ground"):
            node.matte_id = name
            found = self.composited(node.outputs["Matte"], 2)[..., 0]
            np.testing.assert_allclose(found, shares[name], atol=1e-6, err_msg=name)
            self.assertTrue(((found > 0) & (found < 1)).any(), f"{name} has no edge")
        # What the pixel's middle shows has a share in it: the numbers and the names speak of the same leaf.
        numbers = truth["leaf_id"][..., 0]
        seen = {number for number in numbers[shares[leaf] == shares[leaf].max()] if number}
        self.assertEqual(len(seen), 1)
        self.assertTrue((shares[leaf][numbers == seen.pop()] > 0).all())


if __name__ == "__main__":
    unittest.main()
