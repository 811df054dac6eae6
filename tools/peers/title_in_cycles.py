#!/usr/bin/env python3
"""A sequence's frame in Cycles and here, at equal error: how much longer it takes there.

    python3.11 -m venv .venv && .venv/bin/pip install '.[cycles]'
    .venv/bin/python tools/peers/title_in_cycles.py --sunfleck target/release/sunfleck

What the two do not share is taken out of both: shine, the sky behind the picture and the sun's own disc
in it. Leaves that shade unseen are seen in both. Trees, leaves with the light through them, fog, the sun's
extent and the lens stay. Cycles has no bounces, which is direct light and single scattering. Errors are of
one picture against a reference of many samples made here; that of Cycles also as two seeds differ, which no
difference between the pictures themselves can raise. So many samples as Cycles needs for our error are
extrapolated from those it was given, by the root. Its errors fall a little faster (the power 0.55 from 16 to
96 samples), so give it nearly enough: from 16 samples the ratio at 640x360 was a quarter too large.
Processor seconds, without what reading and building take.
"""

import math
import os
import subprocess
import sys
import tempfile
from copy import deepcopy
from pathlib import Path

import bpy
import numpy

from common import colors, pair, parser, rendered

from sunfleck_tools.peers import cycles
from sunfleck_tools.peers.scene import read_scene
from sunfleck_tools.peers.suns import changed


def without_what_differs(document):
    """Removes gloss, sky, a sun that the camera sees and flags of leaves that it does not."""
    document["scenes"][0]["extras"].pop("sunfleck_env", None)
    for material in document["materials"]:
        material.setdefault("extensions", {})["KHR_materials_specular"] = {"specularFactor": 0.0}
    for node in document["nodes"]:
        extras = node.get("extras", {})
        extras.get("sunfleck_light", {}).pop("visible_to_camera", None)
        extras.pop("sunfleck_object", None)


def scene_of(bare, frame, size):
    """Blender scene of a file: that of other renderers, with transmission of leaves and the lens."""
    whole = {}

    def without_lens(document):
        whole.update(deepcopy(document))
        for camera in document["cameras"]:
            camera["extras"]["sunfleck_camera"].pop("fstop")

    read = read_scene(changed(bare, bare.with_name("pinhole.glb"), without_lens), frame)
    read.size = size
    made = cycles.build(read)
    for number, surface in enumerate(read.surfaces):
        mesh = bpy.data.objects[f"surface_{number}"].data
        mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
        ours = whole["materials"][surface.material].get("extras", {}).get("sunfleck_material", {})
        let_light_through(mesh.materials[0], ours.get("transmission", [0.0] * 3))
    set_lens(made.camera.data, whole["cameras"][0])
    return made


def let_light_through(material, color):
    """Adds Lambert transmission: a colour times the picture of the reflection."""
    nodes, links = material.node_tree.nodes, material.node_tree.links
    out = next(node for node in nodes if node.type == "OUTPUT_MATERIAL")
    through, both = nodes.new("ShaderNodeBsdfTranslucent"), nodes.new("ShaderNodeAddShader")
    through.inputs["Color"].default_value = (*color, 1.0)
    for picture in [node for node in nodes if node.type == "TEX_IMAGE"]:
        links.new(cycles.scaled(nodes, links, picture.outputs["Color"], color), through.inputs["Color"])
    for slot, shader in enumerate((out.inputs["Surface"].links[0].from_socket, through.outputs[0])):
        links.new(shader, both.inputs[slot])
    links.new(both.outputs[0], out.inputs["Surface"])


def set_lens(data, described):
    """Sets angle and aperture from a file's description."""
    perspective, ours = described["perspective"], described["extras"]["sunfleck_camera"]
    half = math.tan(perspective["yfov"] / 2.0) * perspective["aspectRatio"]
    data.sensor_fit, data.sensor_width = "HORIZONTAL", ours.get("sensor_width_mm", 36.0)
    data.angle_x, data.dof.use_dof = 2.0 * math.atan(half), True
    data.dof.focus_distance, data.dof.aperture_fstop = ours["focus_distance"], ours["fstop"]
    data.dof.aperture_blades = ours["blades"]


def main():
    command = parser(__doc__)
    command.add_argument("input", nargs="?", default="sequences/title.ron")
    command.add_argument("--sunfleck", type=Path, default=Path("target/release/sunfleck"))
    command.add_argument("--frame", type=int, default=24)
    command.add_argument("--size", default="240x135")
    command.add_argument("--samples", type=int, default=16, help="of sunfleck, a pixel")
    command.add_argument("--reference-samples", type=int, default=256)
    command.add_argument("--cycles-samples", type=int, default=64)
    arguments = command.parse_args()
    os.environ["SUNFLECK"] = str(arguments.sunfleck)
    frames = f"{arguments.frame}-{arguments.frame}"
    with tempfile.TemporaryDirectory() as folder:
        exported = Path(folder, "scene.glb")
        export = [arguments.sunfleck, "export", arguments.input, exported, "--frames", frames]
        subprocess.run(export, check=True, capture_output=True)
        bare = changed(exported, exported.with_name("bare.glb"), without_what_differs)

        def ours(samples, seed, at=arguments.size):
            flags = ["--samples", samples, "--seed", seed, "--bounces", "0", "--passes", "none"]
            channels, seconds, _ = rendered(bare, at, flags, frames)
            return colors(channels), seconds

        theirs = cycles.renders(scene_of(bare, arguments.frame, pair(arguments.size)))
        reference, _ = ours(arguments.reference_samples, 7)
        mean = reference.mean()

        def rms(a, b):
            return float(numpy.sqrt(numpy.mean((a - b) ** 2)) / mean)

        _, reading = ours(1, 0, "16x9")
        mine, my_time = ours(arguments.samples, 1)
        my_time -= reading
        (one, time_one), (two, time_two) = (theirs(arguments.cycles_samples, seed) for seed in (1, 2))
        their_time, noise = (time_one + time_two) / 2.0, rms(one, two) / math.sqrt(2.0)
    print(
        f"{arguments.input}, frame {arguments.frame}, {arguments.size}; mean by Cycles over mean here: "
        f"{(one + two).mean() / 2.0 / mean:.4f}"
    )
    print(
        f"sunfleck  {arguments.samples:5} samples: relative RMSE {rms(mine, reference):.4f}, {my_time:.2f} "
        "CPU s"
    )
    print(
        f"Cycles    {arguments.cycles_samples:5} samples: relative RMSE {rms(one, reference):.4f} "
        f"({noise:.4f} by two seeds), {their_time:.2f} CPU s"
    )
    factor = (noise / rms(mine, reference)) ** 2
    print(
        f"at our error Cycles takes {arguments.cycles_samples * factor:.0f} samples, "
        f"{their_time * factor:.1f} CPU s (extrapolated)"
    )
    print(f"ratio: {their_time * factor / my_time:.1f}")


if __name__ == "__main__":
    sys.exit(main())
