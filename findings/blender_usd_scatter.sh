#!/usr/bin/env bash
# Scattered leaves are elsewhere, upright and never mirrored once Blender has exported them to USD as instances.
#
# Expected: with *Instancing* leaves that Geometry Nodes put on points are a `PointInstancer`, and each is where Blender
# draws it. What happens: Blender 5.3.0 writes the transforms of *Instance on Points* alone. What *Collection Info* adds,
# so the place, rotation and scale of an object in its collection, and what *Relative* space adds, is overridden by an
# identity in the prototype. Scales are written without their sign, so what a negative one mirrors, as every other leaf
# of a twig, lies on the other side. Without *Instancing* all of these are right. Nothing is said.
# Remedy: export without *Instancing*; or scatter by *Object Info* with *As Instance*, and mirror by a second mesh.
# Versions: bpy 5.3.0, usd-core 26.11; bpy 5.0.1 has the same (PyPI). Source: measured here;
# https://docs.blender.org/manual/en/latest/modeling/geometry_nodes/input/scene/collection_info.html;
# https://openusd.org/release/api/class_usd_geom_point_instancer.html (Computing an Instance Transform)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet bpy==5.3.0
python3.13 -m venv pixar
pixar/bin/pip install --quiet usd-core==26.11
cat >export.py <<'END'
import json
import os

import bpy


def mesh(name, points, faces, collection):
    data = bpy.data.meshes.new(name)
    data.from_pydata(points, [], faces)
    made = bpy.data.objects.new(name, data)
    collection.objects.link(made)
    return made


def scatter(source, space, place, turn, scale):
    """Two leaves on the points of a twig. Returns where Blender draws their corners."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.frame_end = 1
    leaves = bpy.data.collections.new("leaves")
    scene.collection.children.link(leaves)
    leaf = mesh("leaf", [(0, 0, 0), (1, 0, 0), (0, 0.5, 0)], [(0, 1, 2)], leaves)
    leaf.location, leaf.rotation_euler = place, turn
    twig = mesh("twig", [(0, 0, 0), (5, 0, 0)], [], scene.collection)
    twig.location = (0, 0, 2)
    group = bpy.data.node_groups.new("scatter", "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        group.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    points, out, on_points, info = map(group.nodes.new, (
        "NodeGroupInput", "NodeGroupOutput", "GeometryNodeInstanceOnPoints", f"GeometryNode{source}Info"))
    info.transform_space = space
    info.inputs[source].default_value = leaves if source == "Collection" else leaf
    info.inputs["Separate Children" if source == "Collection" else "As Instance"].default_value = True
    on_points.inputs["Scale"].default_value = scale
    group.links.new(points.outputs[0], on_points.inputs["Points"])
    group.links.new(info.outputs["Instances" if source == "Collection" else "Geometry"], on_points.inputs["Instance"])
    group.links.new(on_points.outputs[0], out.inputs[0])
    twig.modifiers.new("scatter", "NODES").node_group = group
    return [[list(one.matrix_world @ vertex.co) for vertex in one.object.data.vertices]
            for one in bpy.context.evaluated_depsgraph_get().object_instances if one.is_instance]


ORIGIN, ONE = (0, 0, 0), (1, 1, 1)
CASES = {
    "as it is": ("Collection", "ORIGINAL", ORIGIN, ORIGIN, ONE),
    "3 m away in its collection": ("Collection", "ORIGINAL", (0, 3, 0), ORIGIN, ONE),
    "turned in its collection": ("Collection", "ORIGINAL", ORIGIN, (0, 0, 3.14159265), ONE),
    "relative collection": ("Collection", "RELATIVE", ORIGIN, ORIGIN, ONE),
    "3 m away, by Object Info": ("Object", "RELATIVE", (0, 3, 0), ORIGIN, ONE),
    "mirrored": ("Collection", "ORIGINAL", ORIGIN, ORIGIN, (-1, 1, 1)),
}
for name, case in CASES.items():
    with open(f"{name}.json", "w") as file:
        json.dump(scatter(*case), file)
    for instancing in (True, False):
        bpy.ops.wm.usd_export(filepath=os.path.abspath(f"{name} {instancing}.usda"), use_instancing=instancing)
END
cat >read.py <<'END'
import json

from pxr import Gf, Usd, UsdGeom


def leaf_of(prim):
    return next(found for found in Usd.PrimRange(prim, Usd.PrimAllPrimsPredicate) if found.IsA(UsdGeom.Mesh))


def corners(path, instancing):
    """Where the leaves of a stage have their corners."""
    stage, cache = Usd.Stage.Open(path), UsdGeom.XformCache(1)
    world, found = cache.GetLocalToWorldTransform, []
    for prim in stage.Traverse():
        if instancing and prim.IsA(UsdGeom.PointInstancer):
            instancer = UsdGeom.PointInstancer(prim)
            root = stage.GetPrimAtPath(instancer.GetPrototypesRel().GetTargets()[0])
            leaf = leaf_of(root)
            below = world(leaf) * world(root).GetInverse()
            found += [(leaf, below * matrix * world(prim)) for matrix in instancer.ComputeInstanceTransformsAtTime(1, 1)]
        elif not instancing and prim.IsA(UsdGeom.Mesh) and "/twig/leaf" in str(prim.GetPath()):
            found.append((prim, world(prim)))
    return [[list(matrix.Transform(Gf.Vec3d(point))) for point in UsdGeom.Mesh(leaf).GetPointsAttr().Get(1)]
            for leaf, matrix in found]


def furthest(some, others):
    return max(abs(a - b) for one, other in zip(sorted(some), sorted(others)) for p, q in zip(one, other)
               for a, b in zip(p, q))


for name, wanted in [("as it is", 0), ("3 m away in its collection", 3), ("turned in its collection", 2),
                     ("relative collection", 2), ("3 m away, by Object Info", 0), ("mirrored", 2)]:
    with open(f"{name}.json") as file:
        drawn = json.load(file)
    off = [furthest(corners(f"{name} {instancing}.usda", instancing), drawn) for instancing in (True, False)]
    print("bpy 5.3.0", name, "off by %.2f m with instancing, by %.2f m without" % tuple(off))
    if len(drawn) != 2 or abs(off[0] - wanted) > 0.01 or off[1] > 0.01:
        raise SystemExit("this has changed")
END
venv/bin/python export.py >export.log 2>&1 || { cat export.log; exit 1; }
pixar/bin/python read.py
