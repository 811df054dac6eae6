#!/usr/bin/env bash
# Ground fog of Blender's world vanishes in Cycles where its density keeps growing below the ground that nobody sees.
#
# Expected: fog of the world whose density falls with height as exp(-z / scale), a few nodes, is as thick along a ray as
# the integral of that density along it, whatever the density is elsewhere. A ray that should keep exp(-0.7) = 0.497 of
# the light does so. What happens: Cycles' fog as it is by default since Blender 5.0, with *Biased* off, minds how dense
# the fog is deep below the ground, where no ray goes. From 20 m above the ground down to 3 m within 100 m a scale of 5
# m is right; one of 4 m lets 0.948 of the light through, one of 3 m all of it. From 200 m down to 26 m within 1 km one
# of 10 m lets 0.973 through. More *Max Steps* and more samples change nothing. A box of 300 m with the same nodes is
# right, so that a test with a box shows nothing. Nothing is said.
# Remedy: a node *Maximum* of z and 0 before the exponent; or *Biased* at *Volumes*, the steps of old, which is right
# here.
# Versions: bpy 5.3.0 with numpy 2.5.5, bpy 5.0.1 has the same (PyPI). Source: measured here;
# https://docs.blender.org/manual/en/latest/render/cycles/render_settings/volumes.html (Biased)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 numpy==2.5.5
cat >fog.py <<'END'
import math
import os

import bpy
import numpy as np

DEPTH = 0.7
DOWN = math.radians(10)


def math_node(nodes, operation, first, second=None):
    """What a node makes of two sockets or numbers."""
    node = nodes.new("ShaderNodeMath")
    node.operation = operation
    for socket, value in zip(node.inputs, (first, second)):
        if isinstance(value, (int, float)):
            socket.default_value = value
        elif value is not None:
            node.id_data.links.new(value, socket)
    return node.outputs[0]


def fog(tree, output, density, scale, ground):
    """Fog that takes light and gives none, of `density` times exp(-z / scale)."""
    nodes, links = tree.nodes, tree.links
    place, parts = nodes.new("ShaderNodeNewGeometry"), nodes.new("ShaderNodeSeparateXYZ")
    links.new(place.outputs["Position"], parts.inputs[0])
    height = parts.outputs["Z"] if ground is None else math_node(nodes, "MAXIMUM", parts.outputs["Z"], ground)
    falls = math_node(nodes, "EXPONENT", math_node(nodes, "DIVIDE", height, -scale))
    absorption = nodes.new("ShaderNodeVolumeAbsorption")
    absorption.inputs["Color"].default_value = (0, 0, 0, 1)
    links.new(math_node(nodes, "MULTIPLY", falls, density), absorption.inputs["Density"])
    links.new(absorption.outputs[0], output.inputs["Volume"])


def through(scale, top=20.0, length=100.0, ground=None, biased=False, box=None, steps=1024):
    """Share of a panel's light that comes through, along a ray from the height `top` on, 10 degrees downwards."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    end = top - length * math.sin(DOWN)
    path = scale / math.sin(DOWN) * (math.exp(-end / scale) - math.exp(-top / scale))
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0, 0, 0, 1)
    tree = scene.world.node_tree
    if box:
        bpy.ops.mesh.primitive_cube_add(size=2 * box)
        material = bpy.data.materials.new("fog")
        material.use_nodes = True
        tree = material.node_tree
        tree.nodes.clear()
        tree.nodes.new("ShaderNodeOutputMaterial")
        bpy.context.object.data.materials.append(material)
    output = next(node for node in tree.nodes if node.type.startswith("OUTPUT"))
    fog(tree, output, DEPTH / path, scale, ground)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", 0.01
    camera.data.clip_start, camera.data.clip_end = 1e-4, 1e4
    camera.location, camera.rotation_euler = (3.3, 0, top), (math.pi / 2 - DOWN, 0, 0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    bpy.ops.mesh.primitive_plane_add(size=50, location=(3.3, length * math.cos(DOWN), end),
                                     rotation=camera.rotation_euler)
    panel = bpy.data.materials.new("panel")
    panel.use_nodes = True
    nodes = panel.node_tree.nodes
    nodes.clear()
    panel.node_tree.links.new(nodes.new("ShaderNodeEmission").outputs[0],
                              nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    bpy.context.object.data.materials.append(panel)
    scene.render.engine, scene.cycles.samples, scene.cycles.device = "CYCLES", 128, "CPU"
    scene.cycles.use_denoising, scene.cycles.use_adaptive_sampling = False, False
    scene.cycles.volume_biased, scene.cycles.volume_max_steps = biased, steps
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.view_settings.view_transform = "Raw"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = os.path.abspath("fog.exr")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath, check_existing=False)
    return np.array(image.pixels[:]).reshape(-1, 4)[:, 1].mean()


TRUE = math.exp(-DEPTH)
for name, found, wanted in [
    ("a scale of 5 m", through(5.0), TRUE),
    ("a scale of 4 m", through(4.0), 0.948),
    ("a scale of 4 m, 65536 steps at most", through(4.0, steps=65536), 0.948),
    ("a scale of 3 m", through(3.0), 1),
    ("a scale of 3 m, even below the ground", through(3.0, ground=0.0), TRUE),
    ("a scale of 3 m, biased", through(3.0, biased=True), TRUE),
    ("a scale of 4 m, in a box of 300 m", through(4.0, box=150.0), TRUE),
    ("a scale of 10 m, from 200 m above and 1 km away", through(10.0, 200.0, 1000.0), 0.973),
    ("the same, even below the ground", through(10.0, 200.0, 1000.0, ground=0.0), TRUE),
]:
    print("bpy", bpy.app.version_string, name + ": %.3f of the light" % found, flush=True)
    if abs(found - wanted) > 0.02:
        raise SystemExit("this has changed")
END
venv/bin/python fog.py 2>&1 | grep "^bpy\|changed"
