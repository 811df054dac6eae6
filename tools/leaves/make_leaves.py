#!/usr/bin/env python3
"""Makes the meshes and textures of scenes/falling_leaves: nothing in, OBJ and PNG files out.

    python3 tools/leaves/make_leaves.py [FOLDER]

Needs Python 3.10 or later and no packages. The same version of these files makes the same bytes
every time. `--meshes` leaves the textures, which take most of the time, as they are.
"""

import argparse
from pathlib import Path

from leaf import CANOPY, FAR, NEAR, Pose, make_leaf
from mesh import write_obj
from outlines import SPECIES
from paint import PALETTES, leaf_maps, paint_bark, paint_leaf, paint_litter
from plants import make_bough, make_clump, make_ground, make_tree
from png import write_png

POSES = {
    "maple": Pose(fold_rad=0.28, curl_rad=0.75, cup=0.55, ripple=0.020),
    "birch": Pose(fold_rad=0.38, curl_rad=0.60, cup=0.30, ripple=0.012),
    "oak": Pose(fold_rad=0.22, curl_rad=0.95, cup=0.45, ripple=0.022),
    "beech": Pose(fold_rad=0.42, curl_rad=0.70, cup=0.35, ripple=0.016),
}
# How far an outline may err, in blade lengths: fine teeth vanish in the distance, lobes must not. Every
# triangle between the camera's rays and the sun costs time, so the canopy is as coarse as looks allow.
TOLERANCES = {
    NEAR: {"maple": 0.0015, "birch": 0.0015, "oak": 0.0015, "beech": 0.0015},
    FAR: {"maple": 0.020, "birch": 0.045, "oak": 0.020, "beech": 0.012},
    CANOPY: {"maple": 0.180, "birch": 0.080, "oak": 0.080, "beech": 0.060},
}
COLORS = {
    "maple": ["green_yellow", "yellow", "orange_red", "brown"],
    "birch": ["green_yellow", "yellow", "brown"],
    "oak": ["green_yellow", "orange_red", "brown"],
    "beech": ["yellow", "orange_red", "brown"],
}


def make_meshes(folder: Path) -> None:
    """Writes every OBJ file."""
    folder.mkdir(parents=True, exist_ok=True)
    blades = {blade.name: blade for blade in (species() for species in SPECIES)}
    meshes = {}
    for name, blade in blades.items():
        for detail, tolerances in TOLERANCES.items():
            leaf = make_leaf(blade, detail, tolerances[name], POSES[name])
            meshes[f"{name}_{detail.suffix}"] = (leaf, detail.smooth)
    silhouette, _ = meshes["maple_canopy"]
    meshes["bough"] = (make_bough(silhouette, "bough 1", 3.2, 4, 20, 0.68), False)
    meshes["clump"] = (make_clump("clump 1", 11), False)
    meshes["tree_a"] = (make_tree("tree 1", 15.0, 0.34, 5), True)
    meshes["tree_b"] = (make_tree("tree 2", 13.0, 0.24, 5), True)
    meshes["ground"] = (make_ground(30.0, 16.0, -44.0, 20, 20, 2.6), True)
    for name, (mesh, smooth) in meshes.items():
        write_obj(folder / f"{name}.obj", name, mesh, smooth)
        print(f"{name}.obj: {mesh.triangle_count()} triangles", flush=True)


def make_textures(folder: Path) -> None:
    """Writes every PNG file."""
    folder.mkdir(parents=True, exist_ok=True)
    blades = [species() for species in SPECIES]
    for blade in blades:
        maps = leaf_maps(blade, 512)
        for palette in PALETTES:
            if palette.name in COLORS[blade.name]:
                write_png(folder / f"{blade.name}_{palette.name}.png", paint_leaf(maps, palette))
                print(f"{blade.name}_{palette.name}.png")
    write_png(folder / "litter.png", paint_litter(blades, 512))
    write_png(folder / "bark.png", paint_bark(256, 512))
    print("litter.png, bark.png")


def main() -> None:
    """Reads the command line."""
    scene = Path(__file__).resolve().parents[2] / "scenes" / "falling_leaves"
    parser = argparse.ArgumentParser(description="Makes the meshes and textures of scenes/falling_leaves.")
    parser.add_argument("folder", nargs="?", type=Path, default=scene, help="where meshes/ and textures/ go (default: %(default)s)")
    parser.add_argument("--meshes", action="store_true", help="meshes only")
    arguments = parser.parse_args()
    make_meshes(arguments.folder / "meshes")
    if not arguments.meshes:
        make_textures(arguments.folder / "textures")


if __name__ == "__main__":
    main()
