#!/usr/bin/env bash
# A sky whose black half has been cropped away lights from below in Blender and Mitsuba: the rest is drawn over all of it.
#
# Expected: the display window of an OpenEXR file is the picture, the data window the part of it that is stored; what is
# not stored is black. `oiiotool --trim` crops files so, as autocrop of compositors does. A sky of 64 x 32 pixels with
# the upper half alone in its data window lights nothing from below. What happens: Blender 5.3.0 and Mitsuba 3.9.1 take
# the data window for the picture, 64 x 16 pixels, and stretch it over the sphere: the underside of a white plate has
# 1.0, where it has 0.0 by the same sky in one piece. Horizon and sun are elsewhere too. Neither says anything.
# Remedy: `oiiotool sky.exr --croptofull -o whole.exr`.
# Versions: bpy 5.3.0, Mitsuba 3.9.1, OpenImageIO 3.2.2.0, numpy 2.5.5; bpy 5.0.1 is as 5.3.0 (PyPI). Source: measured
# here; https://openexr.com/en/latest/TechnicalIntroduction.html (Overview: image windows)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 mitsuba==3.9.1 OpenImageIO==3.2.2.0 numpy==2.5.5
cat >write.py <<'END'
import numpy as np
import OpenImageIO as oiio

whole = np.zeros((32, 64, 3), np.float32)
whole[:16] = 1
sky = oiio.ImageBuf(whole)
sky.write("whole.exr")
END
cat >in_mitsuba.py <<'END'
import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
TO = mi.ScalarTransform4f
for name, wanted in (("whole", 0), ("trimmed", 1), ("mended", 0)):
    found = np.array(mi.render(mi.load_dict({
        "type": "scene", "integrator": {"type": "path", "max_depth": 2},
        "sky": {"type": "envmap", "filename": name + ".exr"},
        "plate": {"type": "rectangle", "to_world": TO().rotate([1, 0, 0], 90), "bsdf": {
            "type": "twosided", "nested": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 1.0}}}},
        "sensor": {"type": "orthographic", "film": {"type": "hdrfilm", "width": 4, "height": 4},
                   "to_world": TO().look_at([0, -3, 0], [0, 0, 0], [0, 0, 1]) @ TO().scale([0.1, 0.1, 1])},
    }), spp=1024)).mean()
    print("Mitsuba", mi.__version__, name, "underside %.2f" % found, flush=True)
    if abs(found - wanted) > 0.03:
        raise SystemExit("this has changed")
END
cat >in_blender.py <<'END'
import math
import os

import bpy
import numpy as np

for name, height, wanted in (("whole", 32, 0), ("trimmed", 16, 1), ("mended", 32, 0)):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("sky")
    scene.world.use_nodes = True
    tree = scene.world.node_tree
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = bpy.data.images.load(os.path.abspath(name + ".exr"))
    tree.links.new(texture.outputs[0], tree.nodes["Background"].inputs["Color"])
    bpy.ops.mesh.primitive_plane_add(size=4)
    white = bpy.data.materials.new("white")
    white.use_nodes = True
    white.node_tree.nodes.clear()
    diffuse = white.node_tree.nodes.new("ShaderNodeBsdfDiffuse")
    output = white.node_tree.nodes.new("ShaderNodeOutputMaterial")
    diffuse.inputs["Color"].default_value = (1, 1, 1, 1)
    white.node_tree.links.new(diffuse.outputs[0], output.inputs["Surface"])
    bpy.context.object.data.materials.append(white)
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", 1
    camera.location, camera.rotation_euler = (0, 0, -3), (math.pi, 0, 0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.engine, scene.cycles.samples, scene.cycles.device = "CYCLES", 64, "CPU"
    scene.cycles.max_bounces, scene.cycles.use_denoising = 1, False
    scene.render.resolution_x = scene.render.resolution_y = 16
    scene.view_settings.view_transform = "Raw"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = os.path.abspath("underside.exr")
    bpy.ops.render.render(write_still=True)
    underside = bpy.data.images.load(scene.render.filepath, check_existing=False)
    found = np.array(underside.pixels[:]).reshape(-1, 4)[:, 1].mean()
    print("bpy", bpy.app.version_string, name, *texture.image.size, "underside %.2f" % found, flush=True)
    if texture.image.size[1] != height or abs(found - wanted) > 0.03:
        raise SystemExit("this has changed")
END
venv/bin/python write.py
venv/bin/oiiotool whole.exr --trim -o trimmed.exr
venv/bin/oiiotool trimmed.exr --croptofull -o mended.exr
venv/bin/python in_mitsuba.py 2>&1 | grep "^Mitsuba\|changed"
venv/bin/python in_blender.py 2>&1 | grep "^bpy\|changed"
