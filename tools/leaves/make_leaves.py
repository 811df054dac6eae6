#!/usr/bin/env python3
"""Makes the meshes and textures of scenes/woods: nothing in, OBJ and PNG files out.

    python3 tools/leaves/make_leaves.py [FOLDER]

Needs Python 3.10 or later and no packages. The same version of these files makes the same bytes
every time. `--meshes` leaves the textures, which take minutes, as they are; `--only NAME` makes the textures
whose names start so.
"""

import argparse
from pathlib import Path

from bark import FURROWS_M, Bark, paint_bark, paint_bark_normals
from floor import CELL_M, TILE_M, make_drifts, make_fern, make_ground
from leaf import CANOPY, FAR, NEAR, Detail, Pose, make_leaf
from maps import blemished, leaf_maps
from mesh import Mesh, write_obj
from outlines import SPECIES, Blade, beech, maple, oak
from paint import EVEN, FLOORS, paint_floor, paint_leaf, paint_light_through, paint_normals
from palettes import RAMPS
from png import write_png
from trees import HABITS, make_tree

POSES = {
    "maple": Pose(fold_rad=0.28, curl_rad=0.75, cup=0.55, ripple=0.020),
    "birch": Pose(fold_rad=0.38, curl_rad=0.60, cup=0.30, ripple=0.012),
    "oak": Pose(fold_rad=0.22, curl_rad=0.95, cup=0.45, ripple=0.022),
    "beech": Pose(fold_rad=0.42, curl_rad=0.70, cup=0.35, ripple=0.016),
    "ginkgo": Pose(fold_rad=0.20, curl_rad=0.55, cup=0.25, ripple=0.016),
    "aspen": Pose(fold_rad=0.30, curl_rad=0.45, cup=0.30, ripple=0.018),
    "willow": Pose(fold_rad=0.55, curl_rad=1.10, cup=0.0, ripple=0.006),
}
# How far an outline may err, in blade lengths: fine teeth vanish in the distance, lobes must not. Every
# triangle between the camera's rays and the sun costs time, so the canopy is as coarse as looks allow.
TOLERANCES = {
    NEAR: {"maple": 0.0015, "birch": 0.0015, "oak": 0.0015, "beech": 0.0015, "ginkgo": 0.002, "aspen": 0.002, "willow": 0.001},
    FAR: {"maple": 0.020, "birch": 0.045, "oak": 0.020, "beech": 0.012, "ginkgo": 0.020, "aspen": 0.020, "willow": 0.008},
    CANOPY: {"maple": 0.17, "birch": 0.080, "oak": 0.080, "beech": 0.060, "ginkgo": 0.10, "aspen": 0.060, "willow": 0.020},
}  # fmt: skip
# Other individuals, cut and bent otherwise: a crown, or what falls from it, shall not be one leaf many times.
MORE_MAPLES = {
    "b": Pose(fold_rad=0.12, curl_rad=0.35, cup=0.85, ripple=0.030),
    "c": Pose(fold_rad=0.45, curl_rad=0.95, cup=0.20, ripple=0.028),
    "d": Pose(fold_rad=0.70, curl_rad=0.50, cup=0.10, ripple=0.020, width=0.88),
    "e": Pose(fold_rad=0.05, curl_rad=0.95, cup=0.35, ripple=0.035, width=1.10),
    "f": Pose(fold_rad=0.35, curl_rad=-0.45, cup=0.60, ripple=0.025, width=0.95),
}
NEAR_MAPLES = ("b", "c")
MORE_OAKS = {
    "b": Pose(fold_rad=0.50, curl_rad=0.55, cup=0.20, ripple=0.030, width=0.85),
    "c": Pose(fold_rad=0.05, curl_rad=1.20, cup=0.80, ripple=0.020, width=1.12),
    "d": Pose(fold_rad=0.35, curl_rad=-0.35, cup=0.60, ripple=0.028, width=0.95),
    "e": Pose(fold_rad=0.75, curl_rad=1.00, cup=0.10, ripple=0.024),
}
MORE_BEECHES = {
    "b": Pose(fold_rad=0.15, curl_rad=0.40, cup=0.60, ripple=0.020),
    "c": Pose(fold_rad=0.70, curl_rad=0.95, cup=0.15, ripple=0.016),
    "d": Pose(fold_rad=0.30, curl_rad=-0.40, cup=0.50, ripple=0.024, width=0.88),
    "e": Pose(fold_rad=0.55, curl_rad=0.25, cup=0.85, ripple=0.012, width=1.10),
}
# Ages of the pictures of each species, on its ramp of colours.
AGES = {
    "maple": {"green": 0.12, "lime": 0.28, "yellow": 0.42, "amber": 0.56, "red": 0.78, "brown": 0.96, "turning": 0.46, "flaming": 0.60},
    "birch": {"lime": 0.28, "yellow": 0.48, "brown": 0.92},
    "oak": {"olive": 0.26, "russet": 0.56, "brown": 0.84},
    "beech": {"yellow": 0.32, "copper": 0.56, "brown": 0.84},
    "ginkgo": {"lime": 0.30, "yellow": 0.54},
    "aspen": {"yellow": 0.44, "gold": 0.66},
    "willow": {"lime": 0.30, "yellow": 0.55},
}
# What grows in a wood.
WOODLAND = ("maple", "oak", "beech", "birch")
# Leaves that turn from patch to patch.
PATCHINESS = {"maple turning": 0.85, "maple flaming": 0.62}
# What hangs close to the camera against the light has a picture of the light through it, too.
LIT_THROUGH = {
    "maple": ["lime", "yellow", "amber", "red", "turning", "flaming"],
    "oak": ["russet"],
    "ginkgo": ["yellow"],
    "beech": ["copper"],
}


def leaves() -> dict[str, tuple[Mesh, Detail]]:
    """Every leaf, named after species, detail and variant."""
    meshes = {}

    def grow(blade: Blade, detail: Detail, pose: Pose, variant: str = "", hangs: bool = False) -> None:
        name = f"{blade.name}_{detail.suffix}{'_hanging' * hangs}{variant}"
        meshes[name] = make_leaf(blade, detail, TOLERANCES[detail][blade.name], pose, hangs), detail

    for blade in (species() for species in SPECIES):
        for detail in TOLERANCES:
            grow(blade, detail, POSES[blade.name])
        for detail in (FAR, CANOPY):
            grow(blade, detail, POSES[blade.name], hangs=True)
    for species, poses in ((maple, MORE_MAPLES), (oak, MORE_OAKS), (beech, MORE_BEECHES)):
        for name, pose in poses.items():
            grow(species(name), CANOPY, pose, f"_{name}", hangs=True)
    for name, pose in MORE_MAPLES.items():
        for detail in (NEAR, FAR) if name in NEAR_MAPLES else (FAR,):
            grow(maple(name), detail, pose, f"_{name}")
    return meshes


def make_meshes(folder: Path) -> None:
    """Writes every OBJ file."""
    folder.mkdir(parents=True, exist_ok=True)
    meshes = {name: (mesh, detail.smooth) for name, (mesh, detail) in leaves().items()}
    for name, habit in HABITS.items():
        tree = make_tree(f"{name} 1", habit)
        meshes[f"{name}_wood"], meshes[f"{name}_twigs"] = (tree.wood, True), (tree.twigs, False)
    # A clearing, where litter lies leaf by leaf, and what is around it.
    meshes["ground_clearing"] = (make_ground(-9.0, 9.0, 9.0, -12.0, CELL_M, TILE_M), True)
    meshes["ground_left"] = (make_ground(-45.0, -9.0, 9.0, -12.0, CELL_M, TILE_M), True)
    meshes["ground_right"] = (make_ground(9.0, 45.0, 9.0, -12.0, CELL_M, TILE_M), True)
    meshes["ground_beyond"] = (make_ground(-45.0, 45.0, -12.0, -72.0, CELL_M, TILE_M), True)
    # Leaves that the wind has heaped, finer where they are near.
    meshes["drifts"] = (make_drifts(-9.0, 9.0, 9.0, -12.0, 0.5), True)
    meshes["drifts_beyond"] = (make_drifts(-30.0, 30.0, -12.0, -48.0, 1.5), True)
    meshes["fern"] = (make_fern("fern 1", 9, 0.75, 15), False)
    for name, (mesh, smooth) in meshes.items():
        write_obj(folder / f"{name}.obj", name, mesh, smooth)
        print(f"{name}.obj: {mesh.triangle_count()} triangles", flush=True)


def make_textures(folder: Path, only: str) -> None:
    """Writes every PNG file whose name starts with `only`."""
    folder.mkdir(parents=True, exist_ok=True)
    blades = [species() for species in SPECIES]
    for blade in (blade for blade in blades if blade.name.startswith(only)):
        shared = leaf_maps(blade, 512 if blade.name == "maple" else 384)
        write_png(folder / f"{blade.name}_relief.png", paint_normals(shared), is_color=False)
        print(f"{blade.name}_relief.png", flush=True)
        for name, age in AGES[blade.name].items():
            maps = blemished(shared, f"{blade.name} {name}")
            patchiness = PATCHINESS.get(f"{blade.name} {name}", EVEN)
            write_png(
                folder / f"{blade.name}_{name}.png", paint_leaf(maps, RAMPS[blade.name], age, patchiness)
            )
            if name in LIT_THROUGH.get(blade.name, []):
                write_png(
                    folder / f"{blade.name}_{name}_through.png",
                    paint_light_through(maps, RAMPS[blade.name], age, patchiness),
                )
            print(f"{blade.name}_{name}.png", flush=True)
    for kind in (kind for kind in FLOORS if kind.startswith(only)):
        grown = blades if kind == "litter" else [blade for blade in blades if blade.name in WOODLAND]
        write_png(folder / f"{kind}.png", paint_floor(kind, grown, 640))
        print(f"{kind}.png", flush=True)
    for kind in (kind for kind in FURROWS_M if f"bark_{kind}".startswith(only)):
        bark = Bark.grown(kind, 256, 512)
        write_png(folder / f"bark_{kind}.png", paint_bark(bark))
        write_png(folder / f"bark_{kind}_relief.png", paint_bark_normals(bark), is_color=False)
        print(f"bark_{kind}.png", flush=True)


def main() -> None:
    """Reads the command line."""
    scene = Path(__file__).resolve().parents[2] / "scenes" / "woods"
    parser = argparse.ArgumentParser(description="Makes the meshes and textures of scenes/woods.")
    where = "where meshes/ and textures/ go (default: %(default)s)"
    parser.add_argument("folder", nargs="?", type=Path, default=scene, help=where)
    parser.add_argument("--meshes", action="store_true", help="meshes only")
    parser.add_argument("--only", default="", metavar="NAME", help="textures whose names start so")
    arguments = parser.parse_args()
    make_meshes(arguments.folder / "meshes")
    if not arguments.meshes:
        make_textures(arguments.folder / "textures", arguments.only)


if __name__ == "__main__":
    main()
