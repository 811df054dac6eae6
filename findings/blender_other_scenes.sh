#!/usr/bin/env bash
# A still of another scene is rendered at the frame of the window's scene: every cut of a file shows the same moment.
#
# Expected: `bpy.ops.render.render(scene="cut")` renders the scene *cut* at its own current frame, as it takes its
# camera, size, engine and folder. A script may so render the cuts of a file, each at a frame set by `frame_set`. What
# happens: Blender 5.3.0 takes the frame of the scene in the window. With that at 1, 6 and 11, a lamp, a sky and a
# material that are keyed from 0 to 1 over frames 1 to 11 have 0, 0.5 and 1, at whatever frame *cut* is. A leaf is where
# it is at that frame as well. By `animation=True` the frames are those of *cut*. The picture has the name
# that it was asked for, and nothing is said.
# Remedy: `with bpy.context.temp_override(scene=cut)` about it, `bpy.context.window.scene = cut` before, or
# `animation=True` with `frame_start` and `frame_end` at the frame.
# Versions: bpy 5.3.0 with numpy 2.5.5; bpy 5.0.1 has the same (PyPI). Source: measured here;
# https://docs.blender.org/api/current/bpy.ops.render.html (render: scene to render, if not specified current scene)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 numpy==2.5.5
cat >cuts.py <<'END'
import math
import os

import bpy
import numpy as np

bpy.ops.wm.read_factory_settings(use_empty=True)
FRAMES = (1, 6, 11)


def keyed(owner, name, values):
    for frame, value in zip(FRAMES, values):
        setattr(owner, name, value)
        owner.keyframe_insert(name, frame=frame)


def cut(kind):
    """A camera 1 m above a white leaf, and what is keyed: the sun, the sky, what the leaf emits, or where it lies."""
    scene = bpy.data.scenes.new(kind)
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising = 4, False
    scene.render.resolution_x = scene.render.resolution_y = 4
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.camera.location.z = 1
    scene.collection.objects.link(scene.camera)
    scene.world = bpy.data.worlds.new(kind)
    scene.world.use_nodes = True
    background = scene.world.node_tree.nodes["Background"].inputs
    background["Color"].default_value = (1, 1, 1, 1)
    background["Strength"].default_value = 0
    if kind == "sky":
        keyed(background["Strength"], "default_value", (0, 0.5, 1))
        return scene
    mesh = bpy.data.meshes.new(kind)
    mesh.from_pydata([(-3, -3, 0), (3, -3, 0), (3, 3, 0), (-3, 3, 0)], [], [(0, 1, 2, 3)])
    leaf = bpy.data.objects.new(kind, mesh)
    scene.collection.objects.link(leaf)
    mesh.materials.append(bpy.data.materials.new(kind))
    mesh.materials[0].use_nodes = True
    principled = mesh.materials[0].node_tree.nodes["Principled BSDF"].inputs
    principled["Specular IOR Level"].default_value = 0
    principled["Emission Color"].default_value = (1, 1, 1, 1)
    principled["Base Color"].default_value = (1, 1, 1, 1)
    principled["Roughness"].default_value = 1
    if kind == "lamp":
        sun = bpy.data.lights.new(kind, "SUN")
        scene.collection.objects.link(bpy.data.objects.new(kind, sun))
        keyed(sun, "energy", (0, math.pi / 2, math.pi))
        return scene
    keyed(principled["Emission Strength"], "default_value", (0, 0.5, 1) if kind == "emission" else (1, 1, 1))
    if kind == "place":
        keyed(leaf, "location", ((9, 0, 0), (9, 0, 0), (0, 0, 0)))
    return scene


def light(scene, name):
    """The mean light of a picture that was written."""
    image = bpy.data.images.load(os.path.abspath(name))
    image.colorspace_settings.name = "Non-Color"
    pixels = np.array(image.pixels[:]).reshape(-1, 4)
    bpy.data.images.remove(image)
    return float(pixels[:, 0].mean())


def still(scene):
    scene.render.filepath = os.path.abspath("still.exr")
    bpy.ops.render.render(write_still=True, scene=scene.name)
    return light(scene, "still.exr")


def animation(scene, frame):
    scene.frame_start = scene.frame_end = frame
    scene.render.filepath = os.path.abspath("frame####.exr")
    bpy.ops.render.render(animation=True, scene=scene.name)
    return light(scene, f"frame{frame:04}.exr")


first = bpy.context.window.scene
is_same = True
for kind, right in (("lamp", (0, 0.5, 1)), ("sky", (0, 0.5, 1)), ("emission", (0, 0.5, 1)), ("place", (0, 0, 1))):
    scene = cut(kind)
    for index, window in enumerate(FRAMES):
        first.frame_set(window)
        stills = []
        for frame in FRAMES:
            scene.frame_set(frame)
            stills.append(still(scene))
        frames = [animation(scene, frame) for frame in FRAMES]
        told = ", ".join(f"{value:.2f}" for value in stills)
        print(f"{kind} at frames 1, 6, 11, the window's scene at {window}: stills {told}; "
              f"by animation {', '.join(f'{value:.2f}' for value in frames)}", flush=True)
        is_same &= np.allclose(stills, right[index], atol=0.02) and np.allclose(frames, right, atol=0.02)
    bpy.context.window.scene = scene
    shown = []
    for frame in FRAMES:
        scene.frame_set(frame)
        shown.append(still(scene))
    bpy.context.window.scene = first
    is_same &= np.allclose(shown, right, atol=0.02)
    print(f"{kind} in the window: stills {', '.join(f'{value:.2f}' for value in shown)}", flush=True)
if not is_same:
    raise SystemExit("this has changed")
END
venv/bin/python cuts.py | grep -E "^(lamp|sky|emission|place) "
