#!/usr/bin/env bash
# Cycles blurs what moves, but never its lamps: they light the place where they are at the frame.
#
# Expected: with *Motion Blur* the light of a lamp that goes 2 m within the shutter is a streak on the floor, as that of
# a glowing panel is, and a lamp that comes on within the shutter has a share of its light. What happens: Cycles of
# Blender 5.3.0 has lamps where, and as bright as, they are at the frame. The light of a point lamp above a floor has a
# standard deviation of 0.532 m at rest and under way, that of a panel 0.402 and 0.687 m. A lamp that goes from 0 W at
# the frame to 100 W when the shutter closes is black. Nothing is said.
# Remedy: a glowing mesh for a lamp that moves; or the mean of frames of short shutters.
# Versions: bpy 5.3.0 with numpy 2.5.5; bpy 5.0.1 has the same (PyPI). Source: measured here.
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 numpy==2.5.5
cat >lamps.py <<'END'
import os

import bpy
import numpy as np


def shader(kind, strength=1):
    material = bpy.data.materials.new(kind)
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    shader, output = nodes.new(kind), nodes.new("ShaderNodeOutputMaterial")
    shader.inputs["Color"].default_value = (1, 1, 1, 1)
    if kind == "ShaderNodeEmission":
        shader.inputs["Strength"].default_value = strength
    material.node_tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return material


def key(thing, path, values):
    """Values at the begin, the middle and the end of the shutter."""
    for frame, value in enumerate(values):
        setattr(thing, path, value)
        thing.keyframe_insert(path, frame=frame)


def light_of_floor(add_light):
    """Radiance of 64 columns of a white floor of 4 m, which a camera from above sees beside a light at 0.1 m."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_plane_add(size=8)
    bpy.context.object.data.materials.append(shader("ShaderNodeBsdfDiffuse"))
    add_light(scene)
    scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.camera.data.type, scene.camera.data.ortho_scale, scene.camera.location = "ORTHO", 4, (0, 0.5, 9)
    scene.collection.objects.link(scene.camera)
    scene.render.engine, scene.cycles.samples, scene.cycles.device = "CYCLES", 256, "CPU"
    scene.cycles.max_bounces, scene.cycles.use_denoising = 0, False
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 2
    scene.render.resolution_x, scene.render.resolution_y = 64, 4
    scene.view_settings.view_transform = "Raw"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = os.path.abspath("floor.exr")
    scene.frame_set(1)
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath, check_existing=False)
    return np.array(image.pixels[:]).reshape(4, 64, 4)[..., 1].mean(axis=0)


def lamp(scene, xs, watts=(10, 10, 10)):
    data = bpy.data.lights.new("lamp", "POINT")
    data.shadow_soft_size = 0.05
    placed = bpy.data.objects.new("lamp", data)
    scene.collection.objects.link(placed)
    key(data, "energy", watts)
    key(placed, "location", [(x, 0, 0.1) for x in xs])


def panel(scene, xs):
    bpy.ops.mesh.primitive_plane_add(size=0.1)
    bpy.context.object.data.materials.append(shader("ShaderNodeEmission", 300))
    key(bpy.context.object, "location", [(x, 0, 0.1) for x in xs])


def width_m(light):
    """Standard deviation, in metres, of where the light is."""
    x = (np.arange(64) + 0.5) / 16 - 2
    middle = (x * light).sum() / light.sum()
    return (((x - middle) ** 2 * light).sum() / light.sum()) ** 0.5


for name, light, wanted in [
    ("lamp at rest", lambda scene: lamp(scene, (0, 0, 0)), 0.532),
    ("lamp that goes 2 m", lambda scene: lamp(scene, (-1, 0, 1)), 0.532),
    ("panel at rest", lambda scene: panel(scene, (0, 0, 0)), 0.402),
    ("panel that goes 2 m", lambda scene: panel(scene, (-1, 0, 1)), 0.687),
]:
    found = width_m(light_of_floor(light))
    print("bpy", bpy.app.version_string, name, "lights %.3f m" % found, flush=True)
    if abs(found - wanted) > 0.01:
        raise SystemExit("this has changed")
brightest = light_of_floor(lambda scene: lamp(scene, (0, 0, 0), (0, 0, 100))).max()
print("bpy", bpy.app.version_string, "lamp from 0 W at the frame to 100 W gives", brightest, flush=True)
if brightest != 0:
    raise SystemExit("this has changed")
END
venv/bin/python lamps.py 2>&1 | grep "^bpy\|changed"
