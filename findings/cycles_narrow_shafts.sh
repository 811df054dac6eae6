#!/usr/bin/env bash
# Narrow shafts of light in deep fog lose most of their light in Cycles by its default *Noise Threshold*, without noise.
#
# Expected: adaptive sampling stops where a pixel has little noise, so that a picture has its light, and noise up to the
# threshold. What happens: a path samples the fog on its way in one place, so a shaft of 2 mm in fog of 10 m, or of 2 cm
# in 100 m, is met by one path in 5000. A pixel whose first paths all miss it is black, has no noise, and is given up, for
# good. Across such a shaft Cycles of Blender 5.3.0 has 0.17 of the light at 1024 samples and 0.63 at 4096, its default,
# with *Noise Threshold* on at 0.01, its default as well; off, all of it but for noise. A shaft of 1 cm has 0.975, one of
# 10 cm is right. What is lost is darkness without grain, which looks like a result. Sunlight through gaps between leaves
# is of this kind: the deeper the fog and the smaller the gaps, the darker it is. Nothing is said.
# Remedy: *Noise Threshold* off, or *Min Samples* of several times depth / width of the shafts; compare means.
# Versions: bpy 5.3.0 with numpy 2.5.5 (PyPI). Source: measured here, with single scattering in closed form for the truth;
# https://docs.blender.org/manual/en/latest/render/cycles/render_settings/sampling.html (Noise Threshold, Min Samples);
# Kirk and Arvo 1991, Unbiased sampling techniques for image synthesis
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0 numpy==2.5.5
cat >shafts.py <<'END'
import math
import os

import bpy
import numpy as np

DENSITY, ABOVE_M, SUN_W_M2 = 0.05, 1.0, 1e4


def material(kind, output, **inputs):
    """A material of one node of that kind."""
    made = bpy.data.materials.new(kind)
    made.use_nodes = True
    nodes = made.node_tree.nodes
    nodes.clear()
    node = nodes.new(kind)
    for name, value in inputs.items():
        node.inputs[name].default_value = value
    made.node_tree.links.new(node.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs[output])
    return made


def share(gap_m, samples, is_adaptive):
    """Light that is seen along 10 m of fog below a roof with a gap, as a share of single scattering in closed form."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    if not scene.cycles.use_adaptive_sampling or abs(scene.cycles.adaptive_threshold - 0.01) > 1e-6:
        raise SystemExit("this has changed")
    bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 0, 1))
    bpy.context.object.scale = (10, 10, 2)
    bpy.context.object.data.materials.append(material(
        "ShaderNodeVolumeScatter", "Volume", Density=DENSITY, Color=(1, 1, 1, 1), Anisotropy=0))
    half = gap_m / 2
    mesh = bpy.data.meshes.new("roof")
    corners = [(x, y, 3) for near, far in ((-60, -half), (half, 60)) for x, y in
               ((near, -60), (far, -60), (far, 60), (near, 60))]
    mesh.from_pydata(corners, [], [(0, 1, 2, 3), (4, 5, 6, 7)])
    mesh.materials.append(material("ShaderNodeBsdfDiffuse", "Surface", Color=(0, 0, 0, 1)))
    camera, sun = bpy.data.cameras.new("camera"), bpy.data.lights.new("sun", "SUN")
    camera.type, camera.ortho_scale, sun.energy, sun.angle = "ORTHO", 0.5, SUN_W_M2, 0
    for name, data in (("roof", mesh), ("camera", camera), ("sun", sun)):
        scene.collection.objects.link(bpy.data.objects.new(name, data))
    scene.camera = bpy.data.objects["camera"]
    scene.camera.location, scene.camera.rotation_euler = (-20, 0, ABOVE_M), (math.pi / 2, 0, -math.pi / 2)
    scene.render.engine, scene.cycles.device, scene.cycles.samples = "CYCLES", "CPU", samples
    scene.cycles.max_bounces, scene.cycles.use_denoising = 0, False
    scene.cycles.use_adaptive_sampling = is_adaptive
    scene.render.resolution_x = scene.render.resolution_y = 48
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = os.path.abspath("shaft.exr")
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath, check_existing=False)
    image.colorspace_settings.name = "Non-Color"
    found = np.array(image.pixels[:]).reshape(-1, 4)[:, :3].mean()
    near, far = 5 - half, 5 + half
    truth = SUN_W_M2 / (4 * math.pi) * math.exp(-DENSITY * (2 - ABOVE_M))
    return found / (truth * (math.exp(-DENSITY * near) - math.exp(-DENSITY * far)))


for gap_m, samples, is_adaptive, low, high in [
    (0.1, 1024, True, 0.98, 1.02), (0.01, 1024, True, 0.95, 0.99),
    (0.002, 1024, True, 0.1, 0.3), (0.002, 1024, False, 0.93, 1.07), (0.002, 4096, True, 0.5, 0.75),
]:
    found = share(gap_m, samples, is_adaptive)
    print("bpy", bpy.app.version_string, f"a gap of {gap_m} m, {samples} samples, noise threshold",
          "on:" if is_adaptive else "off:", "%.3f of the light" % found, flush=True)
    if not low < found < high:
        raise SystemExit("this has changed")
END
venv/bin/python shafts.py 2>&1 | grep "^bpy\|changed"
