#!/usr/bin/env bash
# What bends has the wrong motion blur in Blender 5.3 once it comes from Alembic: a whole frame long, and to one side.
#
# Expected: an Alembic file has a mesh for every frame, and half a frame later it is half way. A leaf whose corners move by
# 1 m a frame is blurred over 0.5 m with a shutter of half a frame, as one that moves as a whole. What happens: Blender
# 5.3.0 imports with *Vertex Interpolation* off, which its documentation has as on by default, and Blender 5.0.1 has on. It
# holds the mesh of a frame until the next, so that at the steps of the shutter, frames 4.75, 5 and 5.25, Cycles finds the
# meshes of frames 4, 5 and 5. An edge that should be soft from 3.75 to 4.25 m is so from 3.06 to 4 m. What moves as a
# whole, as objects and cameras do, is right, so that the two do not fit; slow motion stutters. The import has no option
# for it. Nothing is said.
# Remedy: after import `use_vertex_interpolation = True` for each modifier of type MESH_SEQUENCE_CACHE.
# Versions: bpy 5.3.0 with numpy 2.5.5; bpy 5.0.1 is right (PyPI). Source: measured here;
# https://docs.blender.org/api/current/bpy.types.MeshSequenceCacheModifier.html (use_vertex_interpolation, default True)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 numpy==2.5.5
cat >blur.py <<'END'
import bpy
import numpy as np

WIDTH = 128


def scene():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    made = bpy.context.scene
    made.frame_start, made.frame_end, made.render.fps = 1, 10, 24
    return made


def leaf(within, bends):
    """A card from x = 0 to 1 that goes 1 m to the right a frame: by its corners, or as an object."""
    mesh = bpy.data.meshes.new("Leaf")
    mesh.from_pydata([(0, -1, 0), (1, -1, 0), (1, 1, 0), (0, 1, 0)], [], [(0, 1, 2, 3)])
    card = bpy.data.objects.new("Leaf", mesh)
    within.collection.objects.link(card)
    if bends:
        card.shape_key_add(name="Basis")
        key = card.shape_key_add(name="Gone")
        for corner in key.data:
            corner.co.x += 9
    for frame, share in [(1, 0.0), (10, 1.0)]:
        if bends:
            key.value = share
            key.keyframe_insert("value", frame=frame)
        else:
            card.location.x = 9 * share
            card.keyframe_insert("location", frame=frame)
    animated = mesh.shape_keys.animation_data if bends else card.animation_data
    for curve in animated.action.layers[0].strips[0].channelbags[0].fcurves:
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"


def left_edge(within):
    """From where to where the left edge is soft in frame 5, in metres."""
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.data.type, camera.data.ortho_scale, camera.location = "ORTHO", 4, (4.5, 0, 5)
    within.collection.objects.link(camera)
    within.camera, within.render.engine = camera, "CYCLES"
    within.cycles.samples, within.cycles.use_adaptive_sampling, within.cycles.use_denoising = 1024, False, False
    within.cycles.pixel_filter_type = "BOX"
    render = within.render
    render.resolution_x, render.resolution_y, render.film_transparent = WIDTH, 1, True
    render.use_motion_blur, render.motion_blur_shutter = True, 0.5
    render.image_settings.file_format, render.image_settings.color_mode = "OPEN_EXR", "RGBA"
    render.filepath = bpy.app.tempdir + "leaf.exr"
    within.frame_set(5)
    bpy.ops.render.render(write_still=True)
    alpha = np.array(bpy.data.images.load(render.filepath).pixels[:]).reshape(-1, 4)[:, 3]
    opaque = int(np.argmax(alpha))
    soft = [at for at in range(opaque) if 0.02 < alpha[at] < 0.98]
    return 2.5 + soft[0] * 4 / WIDTH, 2.5 + (soft[-1] + 1) * 4 / WIDTH


for bends, by, wanted in [
    (False, "as it is", (3.75, 4.25)), (True, "as it is", (3.75, 4.25)),
    (False, "Alembic", (3.75, 4.25)), (True, "Alembic", (3.03, 4.0)), (True, "Alembic, interpolated", (3.75, 4.25)),
]:
    within = scene()
    leaf(within, bends)
    if by != "as it is":
        bpy.ops.wm.alembic_export(filepath="leaf.abc", as_background_job=False, start=1, end=10)
        within = scene()
        bpy.ops.wm.alembic_import(filepath="leaf.abc", as_background_job=False)
    if by == "Alembic, interpolated":
        for card in within.objects:
            card.modifiers[0].use_vertex_interpolation = True
    found = left_edge(within)
    moves = "its corners move" if bends else "it moves as a whole"
    print("Blender", bpy.app.version_string, by + ",", moves + ": soft from %.2f to %.2f m" % found, flush=True)
    if max(abs(one - other) for one, other in zip(found, wanted)) > 0.07:
        raise SystemExit("this has changed")
END
venv/bin/python blur.py 2>&1 | grep "^Blender\|changed"
