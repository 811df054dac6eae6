#!/usr/bin/env bash
# trimesh with Embree counts fewer leaves under a ray the larger the scene is: by its extent, not by the leaves.
#
# Expected: a ray that asks for all hits (`multiple_hits=True`) meets each of ten level leaves; installing embreex makes
# that faster and no more. What happens: trimesh 5.2.0 with embreex 4.4.0 steps past each hit by an offset that follows
# from the size of the whole mesh, and skips what lies within it. Of ten leaves 1 mm apart a ray finds all in a scene of
# 200 m and 4 of 10 in one of 2 km; 0.1 mm apart, 4 of 10 in one of 200 m. The scene is larger by one far triangle.
# trimesh's own `ray_triangle`, used where embreex is not installed, finds all of them. Nothing is said. So leaf area by
# rays, or the depth of a stack of fallen leaves, depends on what else is in the mesh.
# Remedy: `trimesh.ray.ray_triangle.RayMeshIntersector(mesh)`, or rays into pieces of the scene.
# Versions: trimesh 5.2.0, embreex 4.4.0, numpy 2.5.5, scipy 1.16.3, rtree 1.4.1 (PyPI). Source: measured here;
# https://trimesh.org/trimesh.ray.ray_pyembree.html (intersects_id: multiple_hits)
# Needs python3.13 with venv. Ends with 1 if it has changed.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3.13 -m venv venv
venv/bin/pip install --quiet trimesh==5.2.0 embreex==4.4.0 numpy==2.5.5 scipy==1.16.3 rtree==1.4.1
cat >leaves.py <<'END'
import numpy as np
import trimesh
from trimesh.ray.ray_pyembree import RayMeshIntersector as Embree
from trimesh.ray.ray_triangle import RayMeshIntersector as Own


def leaves(gap_m, extent_m):
    """Ten level leaves of 2 m, one above the other, and a small triangle that far away."""
    vertices, faces = [], []
    for index in range(10):
        height, first = index * gap_m, len(vertices)
        vertices += [(-1, -1, height), (1, -1, height), (1, 1, height), (-1, 1, height)]
        faces += [(first, first + 1, first + 2), (first, first + 2, first + 3)]
    first = len(vertices)
    vertices += [(extent_m, extent_m, -1), (extent_m + 1, extent_m, -1), (extent_m, extent_m + 1, -1)]
    faces.append((first, first + 1, first + 2))
    return trimesh.Trimesh(np.array(vertices, float), faces, process=False)


WANTED = {(20, 0.001): (10, 10), (200, 0.001): (10, 10), (2000, 0.001): (4, 10), (200, 0.0001): (4, 10)}
is_same = True
for (extent_m, gap_m), wanted in WANTED.items():
    mesh = leaves(gap_m, extent_m)
    found = tuple(
        len(way(mesh).intersects_id([[0.3, 0.2, 5]], [[0, 0, -1]], multiple_hits=True)[0]) for way in (Embree, Own))
    print("trimesh", trimesh.__version__, f"leaves {gap_m * 1000} mm apart, extent {extent_m} m:",
          "%d by Embree, %d by its own code" % found, flush=True)
    is_same &= found == wanted
if not is_same:
    raise SystemExit("this has changed")
END
venv/bin/python leaves.py
