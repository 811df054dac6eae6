#!/usr/bin/env bash
# A mirrored `to_world` turns shapes of Mitsuba inside out: drops of glass are bubbles. Smooth meshes and instances stay.
#
# Expected: what is mirrored keeps its outside, as glTF has it; every other leaf and drop of a twig is a mirrored one. A
# ball of glass shows what is behind it the other way round, mirrored or not. What happens: with a negative determinant
# of `to_world` Mitsuba 3.9.1 exchanges inside and outside of a `sphere`, and of `ply` and `obj` without normals. The ball
# is a bubble of air in glass, and shows what is behind it the right way round; a leaf of triangles with a BSDF of one
# side is black. The same file with normals is right, and so is each of them as an `instance`. A `rectangle` whose x is
# mirrored is right as well, so that leaves of both kinds no longer fit. Nothing is said.
# Remedy: `"flip_normals": True` exactly where a `sphere` or a mesh without normals is mirrored; or instances.
# Versions: Mitsuba 3.9.1 with numpy 2.5.5 (PyPI). Source: measured here;
# https://mitsuba.readthedocs.io/en/stable/src/generated/plugins_shapes.html (flip_normals);
# https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html (3.7.4, Instantiation: determinant)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet mitsuba==3.9.1 numpy==2.5.5
cat >mirror.py <<'END'
import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
TO = mi.ScalarTransform4f
ROWS = 48


def write_ball(name, normals):
    """A ball of triangles, counter-clockwise from without."""
    across, around = np.meshgrid(np.pi * np.arange(ROWS + 1) / ROWS, 2 * np.pi * np.arange(ROWS) / ROWS, indexing="ij")
    points = np.stack([np.sin(across) * np.cos(around), np.sin(across) * np.sin(around), np.cos(across)], -1)
    faces = []
    for row in range(ROWS):
        for column in range(ROWS):
            a, b = row * ROWS + column, row * ROWS + (column + 1) % ROWS
            faces += [(a, a + ROWS, b + ROWS), (a, b + ROWS, b)]
    mesh = mi.Mesh("ball", points.size // 3, len(faces), has_vertex_normals=normals)
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = points.ravel().astype(np.float32)
    parameters["faces"] = np.ravel(faces).astype(np.uint32)
    if normals:
        parameters["vertex_normals"] = points.ravel().astype(np.float32)
    parameters.update()
    mesh.write_ply(name)


def seen(shapes):
    """What is seen through the right half of the ball: 1 is the lit half on the right, 0 the dark one on the left."""
    scene = {
        "type": "scene", "integrator": {"type": "path"}, **shapes,
        "lit": {"type": "rectangle", "to_world": TO().translate([100, 0, -20]) @ TO().scale(100), "emitter": {
            "type": "area", "radiance": 1.0}},
        "sensor": {
            "type": "orthographic", "to_world": TO().look_at([0.3, 0, 5], [0.3, 0, 0], [0, 1, 0]) @ TO().scale([0.01, 0.01, 1]),
            "film": {"type": "hdrfilm", "width": 1, "height": 1, "rfilter": {"type": "box"}}},
    }
    return float(np.array(mi.render(mi.load_dict(scene), spp=256)).ravel()[0])


def lit_leaf(shape):
    """A leaf of one side in x and y, with the sun behind the camera: its albedo of 0.5, or black."""
    return float(np.array(mi.render(mi.load_dict({
        "type": "scene", "integrator": {"type": "path"}, "leaf": {**shape, "to_world": TO().scale([-1, 1, 1])},
        "sun": {"type": "directional", "direction": [0, 0, -1], "irradiance": np.pi},
        "sensor": {
            "type": "orthographic", "to_world": TO().look_at([0.1, 0.1, 5], [0.1, 0.1, 0], [0, 1, 0]) @ TO().scale([0.01, 0.01, 1]),
            "film": {"type": "hdrfilm", "width": 1, "height": 1, "rfilter": {"type": "box"}}},
    }), spp=16)).ravel()[0])


write_ball("facets.ply", False)
write_ball("smooth.ply", True)
GLASS = {"bsdf": {"type": "dielectric", "int_ior": 1.5}}
for name, shape, wanted in [
    ("sphere", {"type": "sphere", **GLASS}, "a bubble"),
    ("mesh of facets", {"type": "ply", "filename": "facets.ply", **GLASS}, "a bubble"),
    ("mesh of facets, flip_normals", {"type": "ply", "filename": "facets.ply", "flip_normals": True, **GLASS}, "glass"),
    ("mesh with normals", {"type": "ply", "filename": "smooth.ply", **GLASS}, "glass"),
]:
    for scale in [(1, -1, 1)] if "flip_normals" in shape else [(1, 1, 1), (1, -1, 1)]:
        matrix = TO().scale(scale)
        as_it_is = seen({"ball": {**shape, "to_world": matrix}})
        instance = seen({"group": {"type": "shapegroup", "ball": shape}, "ball": {
            "type": "instance", "to_world": matrix, "group": {"type": "ref", "id": "group"}}})
        found = ["a bubble" if value > 0.5 else "glass" for value in (as_it_is, instance)]
        print("Mitsuba", mi.__version__, name, "scale", scale, "is", found[0] + ", as an instance", found[1])
        if found != [wanted if scale[1] < 0 else "glass", "a bubble" if "flip_normals" in shape else "glass"]:
            raise SystemExit("this has changed")
with open("leaf.obj", "w") as leaf:
    leaf.write("v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n")
found = [round(lit_leaf(shape), 3) for shape in ({"type": "rectangle"}, {"type": "obj", "filename": "leaf.obj"})]
print("Mitsuba", mi.__version__, "a mirrored leaf by rectangle and by obj:", *found)
if found != [0.5, 0]:
    raise SystemExit("this has changed")
END
venv/bin/python mirror.py
