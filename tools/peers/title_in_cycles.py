#!/usr/bin/env python3
"""A sequence's frame in Cycles and here, at equal error: how much longer it takes there.

    python3.11 -m venv .venv && .venv/bin/pip install '.[cycles]'
    .venv/bin/python tools/peers/title_in_cycles.py --sunfleck target/release/sunfleck

What the two do not share is taken out of both: shine, the sky behind the picture and the sun's own disc
in it. Trees, leaves with the light through them, fog, the sun's extent and the lens stay. Cycles has no
bounces, which is direct light and single scattering. Errors are of one picture against a reference of
many samples made here; that of Cycles also as two seeds differ, which no difference between the pictures
themselves can raise. So many samples as Cycles needs for our error are extrapolated from those it was
given, by the root. Its errors fall a little faster (the power 0.55 from 16 to 96 samples), so give it
nearly enough: from 16 samples the ratio at 640x360 was a quarter too large. Processor seconds, without
what reading and building take.
"""

import json
import math
import resource
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

import bpy
import mathutils
import numpy

from common import parser

from sunfleck_tools.gltf.lights import LightSource
from sunfleck_tools.gltf.load import load
from sunfleck_tools.gltf.meshes import Meshes
from sunfleck_tools.peers import cycles
from sunfleck_tools.peers.beside import pixels_of
from sunfleck_tools.peers.lamps import Sun, read_light
from sunfleck_tools.peers.scene import FOG_GROWTH, Fog


def without_what_differs(glb: Path) -> Path:
    """The same file without shine, sky, and a sun that the camera sees."""
    data = glb.read_bytes()
    length = struct.unpack_from("<I", data, 12)[0]
    document, rest = json.loads(data[20 : 20 + length]), data[20 + length :]
    document["scenes"][0]["extras"].pop("sunfleck_env", None)
    for material in document["materials"]:
        material.setdefault("extensions", {})["KHR_materials_specular"] = {"specularFactor": 0.0}
    for node in document["nodes"]:
        node.get("extras", {}).get("sunfleck_light", {}).pop("visible_to_camera", None)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    made = glb.with_name("bare.glb")
    made.write_bytes(
        struct.pack("<4sIIII", b"glTF", 2, 20 + len(text) + len(rest), len(text), 0x4E4F534A) + text + rest
    )
    return made


def image_of(gltf, texture, folder):
    """A picture of the file as Blender's."""
    textures, images = gltf.document.items("textures"), gltf.document.items("images")
    number = textures[texture.need("index").index(textures, "texture")].need("source").index(images, "image")
    path = folder / f"image_{number}"
    if not path.exists():
        data, start, size, _ = gltf.container.view(images[number].need("bufferView"))
        path.write_bytes(data[start : start + size])
    return bpy.data.images.load(str(path), check_existing=True)


def material_of(gltf, source, folder):
    """Lambert reflection and transmission, each its colour times the base colour's picture."""
    material, nodes, links = cycles.nodes_of(source.text_at("name", "material"))
    shading, ours = source.group("pbrMetallicRoughness"), source.group("extras").group("sunfleck_material")
    texture = shading.member("baseColorTexture")
    picture = None
    if texture is not None:
        picture = nodes.new("ShaderNodeTexImage")
        picture.image = image_of(gltf, texture, folder)
    both, out = nodes.new("ShaderNodeAddShader"), nodes.new("ShaderNodeOutputMaterial")
    colors = {
        "ShaderNodeBsdfDiffuse": shading.need("baseColorFactor").numbers(4)[:3],
        "ShaderNodeBsdfTranslucent": ours.numbers_at("transmission", 0.0, 0.0, 0.0),
    }
    for slot, (kind, color) in enumerate(colors.items()):
        scattering = nodes.new(kind)
        scattering.inputs["Color"].default_value = (*color, 1.0)
        if picture is not None:
            product = nodes.new("ShaderNodeVectorMath")
            product.operation = "MULTIPLY"
            links.new(picture.outputs["Color"], product.inputs[0])
            product.inputs[1].default_value = color
            links.new(product.outputs[0], scattering.inputs["Color"])
        links.new(scattering.outputs[0], both.inputs[slot])
    links.new(both.outputs[0], out.inputs["Surface"])
    return material


def add_surfaces(made, gltf, time_s, folder):
    """One mesh a material, in the world."""
    meshes, parts, placed = Meshes(gltf, []), {}, {}
    for node in gltf.nodes:  # Parents come before their children.
        own = node.parent_from_node(time_s)[0]
        placed[node.index] = own if node.parent is None else placed[node.parent.index] @ own
        found = meshes.of(node)
        if found is not None:
            for primitive in found[1].primitives:
                parts.setdefault(primitive.material, []).append(
                    (primitive, cycles.BLENDER_FROM_GLTF @ placed[node.index])
                )
    sources = gltf.document.items("materials")
    for number, pieces in parts.items():
        points = numpy.concatenate([p.positions @ m[:3, :3].T + m[:3, 3] for p, m in pieces])
        firsts = numpy.cumsum([0] + [len(p.positions) for p, _ in pieces])
        triangles = numpy.concatenate(
            [p.triangles.astype(numpy.int64) + first for (p, _), first in zip(pieces, firsts)]
        )
        uvs = numpy.concatenate(
            [p.uvs[0] if 0 in p.uvs else numpy.zeros((len(p.positions), 2)) for p, _ in pieces]
        )
        mesh = bpy.data.meshes.new(f"surface {number}")
        mesh.vertices.add(len(points))
        mesh.vertices.foreach_set("co", points.astype(numpy.float32).ravel())
        mesh.loops.add(3 * len(triangles))
        mesh.loops.foreach_set("vertex_index", triangles.astype(numpy.int32).ravel())
        mesh.polygons.add(len(triangles))
        mesh.polygons.foreach_set("loop_start", numpy.arange(0, 3 * len(triangles), 3, dtype=numpy.int32))
        corners = uvs[triangles.ravel()].astype(numpy.float32)
        corners[:, 1] = 1.0 - corners[:, 1]
        mesh.uv_layers.new(name="uv").data.foreach_set("uv", corners.ravel())
        mesh.update()
        mesh.polygons.foreach_set("use_smooth", [True] * len(triangles))
        mesh.materials.append(material_of(gltf, sources[number], folder))
        made.collection.objects.link(bpy.data.objects.new(f"surface {number}", mesh))
    return [(node, placed[node.index]) for node in gltf.nodes]


def add_rest(made, gltf, placed, time_s):
    """Lights, fog and camera."""
    for node, world in placed:
        source = LightSource(node, gltf)
        if source.kind is not None:
            light = read_light(source, world, time_s)
            (cycles.add_sun if isinstance(light, Sun) else cycles.add_lamp)(made, light)
        if (fog := node.extras.member("sunfleck_fog_volume")) is not None:
            cycles.add_fog(
                made,
                Fog(
                    world @ FOG_GROWTH,
                    fog.need("density").channels(),
                    fog.need("albedo").channels(),
                    fog.number_at("anisotropy", 0.0),
                ),
            )
        if node.source.member("camera") is not None:
            described = gltf.document.items("cameras")[0]
            perspective, ours = (
                described.need("perspective"),
                described.group("extras").group("sunfleck_camera"),
            )
            data = bpy.data.cameras.new("camera")
            half = (
                math.tan(perspective.need("yfov").number() / 2.0) * perspective.need("aspectRatio").number()
            )
            data.sensor_fit, data.sensor_width, data.angle_x = (
                "HORIZONTAL",
                ours.number_at("sensor_width_mm", 36.0),
                2.0 * math.atan(half),
            )
            data.clip_start, data.clip_end = cycles.NEAR_M, 1e6
            data.dof.use_dof = True
            data.dof.focus_distance, data.dof.aperture_fstop = (
                ours.need("focus_distance").number(),
                ours.need("fstop").number(),
            )
            data.dof.aperture_blades = ours.need("blades").whole()
            made.camera = bpy.data.objects.new("camera", data)
            made.camera.matrix_world = mathutils.Matrix((cycles.BLENDER_FROM_GLTF @ world).tolist())
            made.collection.objects.link(made.camera)


def seconds_of(who):
    used = resource.getrusage(who)
    return used.ru_utime + used.ru_stime


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
    size = tuple(map(int, arguments.size.split("x")))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        exported = folder / "scene.glb"
        frames = f"{arguments.frame}-{arguments.frame}"
        subprocess.run(
            [arguments.sunfleck, "export", arguments.input, exported, "--frames", frames],
            check=True,
            capture_output=True,
        )
        bare = without_what_differs(exported)

        def ours(samples, seed, at=arguments.size):
            target, before = folder / "ours.exr", seconds_of(resource.RUSAGE_CHILDREN)
            command = [arguments.sunfleck, "render", bare, "--frames", frames, "--size", at, "--samples", samples, "--seed", seed, "--bounces", "0"]
            subprocess.run(
                [*map(str, command), "--passes", "none", "--out", str(target)],
                check=True,
                capture_output=True,
            )
            return pixels_of(target), seconds_of(resource.RUSAGE_CHILDREN) - before

        gltf = load(bare, str(arguments.sunfleck))
        bpy.ops.wm.read_factory_settings(use_empty=True)
        made = bpy.context.scene
        time_s = gltf.settings.seconds(numpy.array([arguments.frame]))
        add_rest(made, gltf, add_surfaces(made, gltf, time_s, folder), time_s)
        cycles.settings(made, size)

        def theirs(samples, seed):
            made.cycles.samples, made.cycles.seed = samples, seed
            made.render.filepath = str(folder / "cycles.exr")
            before = seconds_of(resource.RUSAGE_SELF)
            bpy.ops.render.render(write_still=True)
            return pixels_of(folder / "cycles.exr"), seconds_of(resource.RUSAGE_SELF) - before

        reference, _ = ours(arguments.reference_samples, 7)
        mean = reference.mean()

        def rms(a, b):
            return float(numpy.sqrt(numpy.mean((a - b) ** 2)) / mean)

        _, reading = ours(1, 0, "16x9")
        mine, my_time = ours(arguments.samples, 1)
        my_time -= reading
        theirs(1, 99)  # Builds the tree, which is kept.
        (one, time_one), (two, time_two) = (
            theirs(arguments.cycles_samples, 1),
            theirs(arguments.cycles_samples, 2),
        )
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
