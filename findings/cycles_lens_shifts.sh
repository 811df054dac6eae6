#!/usr/bin/env bash
# Cycles does not blur what a lens shift or an orthographic zoom moves, and its Vector pass says that it stands still.
#
# Expected: *Motion Blur* smears what moves in the picture while the shutter is open, whether things or the camera move
# it. At 100 pixels a lens whose *Shift X* goes from 0.1 to -0.1 within two frames moves the picture by 10 pixels a
# frame: with a shutter of a frame an edge at 75 is soft from 70 to 80, and the *Vector* pass has 10 pixels. What
# happens: Cycles of Blender 5.3.0 has an edge as sharp as without motion, and vectors of 0, for shifts of perspective
# and orthographic lenses and for the scale of orthographic ones. Zooms by focal length or sensor of a perspective
# camera, and cameras that move, are right. So shake, pans of a still and rises of a facade that are made by shifts are
# sharp, in Cycles as in a compositor that blurs by vectors. Nothing is said.
# Remedy: the mean of renders at times within the shutter; or move the camera, where its view is orthographic.
# Versions: bpy 5.3.0 with numpy 2.5.5, bpy 5.0.1 has the same blur (PyPI). Source: measured here;
# https://docs.blender.org/manual/en/latest/render/cycles/render_settings/motion_blur.html;
# https://docs.blender.org/manual/en/latest/render/layers/passes.html (Vector)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 numpy==2.5.5
cat >shifts.py <<'END'
import glob
import os
import sys

import bpy

sys.path += glob.glob(sys.prefix + "/lib/python*/site-packages/bpy/*/python/lib/python*/site-packages")
import numpy as np
import OpenImageIO as oiio

SIDE = 100


def scene_of(orthographic, path, values):
    """A wall that glows to the left of x = 1 m, 5 m before a camera that changes from frame 4 to 6. By pixels: 75."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("black")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0, 0, 0, 1)
    data = bpy.data.cameras.new("camera")
    data.sensor_width, data.lens, data.ortho_scale = 40, 50, 4
    data.type = "ORTHO" if orthographic else "PERSP"
    camera = bpy.data.objects.new("camera", data)
    camera.location = (0, 0, 5)
    scene.collection.objects.link(camera)
    scene.camera = camera
    keyed = camera if path == "location" else data
    for frame, value in zip((4, 5, 6), values):
        setattr(keyed, path, value)
        keyed.keyframe_insert(path, frame=frame)
    for curve in keyed.animation_data.action.layers[0].strips[0].channelbags[0].fcurves:
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"
    bpy.ops.mesh.primitive_plane_add(size=20, location=(-9, 0, 0))
    glow = bpy.data.materials.new("glow")
    glow.use_nodes = True
    nodes = glow.node_tree.nodes
    nodes.clear()
    glow.node_tree.links.new(nodes.new("ShaderNodeEmission").outputs[0],
                             nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    bpy.context.object.data.materials.append(glow)
    scene.render.engine, scene.cycles.samples, scene.cycles.device = "CYCLES", 256, "CPU"
    scene.cycles.use_denoising, scene.cycles.use_adaptive_sampling = False, False
    scene.cycles.pixel_filter_type = "BOX"
    scene.render.resolution_x = scene.render.resolution_y = SIDE
    scene.render.motion_blur_shutter = 1.0
    scene.render.image_settings.media_type = "MULTI_LAYER_IMAGE"
    scene.render.image_settings.file_format = "OPEN_EXR_MULTILAYER"
    scene.render.image_settings.color_depth = "32"
    scene.view_layers[0].use_pass_vector = True
    scene.render.filepath = os.path.abspath("wall.exr")
    return scene


def row(scene, frame, blurred, end):
    """Of the middle row of pixels the channel of which the name ends so."""
    scene.render.use_motion_blur = blurred
    scene.frame_set(frame)
    bpy.ops.render.render(write_still=True)
    file, part = oiio.ImageInput.open(scene.render.filepath), 0
    while file.seek_subimage(part, 0):
        names = file.spec().channelnames
        for channel, name in enumerate(names):
            if name.endswith(end):
                return np.array(file.read_image(part, 0, 0, len(names), "float"))[SIDE // 2, :, channel]
        part += 1


def width(edge):
    """How wide an edge is that goes evenly from 1 to 0: the mean of (1 - v) v is a sixth there."""
    return 6 * np.sum(edge * (1 - edge))


SHIFTS, SCALES = (0.1, 0, -0.1), (4.4, 4, 3.6)
for name, orthographic, path, values, softness, vector in [
    ("camera that moves", False, "location", [(x, 0, 5) for x in (0.2, 0, -0.2)], 5, 5),
    ("focal length", False, "lens", (45, 50, 55), 2.5, 2.5),
    ("lens shift", False, "shift_x", SHIFTS, 0, 0),
    ("lens shift, orthographic", True, "shift_x", SHIFTS, 0, 0),
    ("orthographic scale", True, "ortho_scale", SCALES, 0, 0),
]:
    scene = scene_of(orthographic, path, values)
    moved = row(scene, 6, False, "Combined.G").sum() - row(scene, 4, False, "Combined.G").sum()
    soft = width(row(scene, 5, True, "Combined.G"))
    # Vectors are those of the way from the frame before; of the pixel to the left of the edge.
    found = abs(row(scene, 5, False, "Vector.X")[SIDE * 3 // 4 - 1])
    print("bpy", bpy.app.version_string, name + ": the edge moves by %.1f px a frame, is soft over %.1f, vector %.1f"
          % (moved / 2, soft, found), flush=True)
    if abs(soft - softness) > 0.5 or abs(found - vector) > 0.5 or moved < 4.5:
        raise SystemExit("this has changed")
END
venv/bin/python shifts.py 2>&1 | grep "^bpy\|changed\|Error"
