"""What fog by voxels takes beside even fog: processor time of a frame, and memory.

    SUNFLECK=../target/release/sunfleck python -m tests.voxel_cost          (in tools/)

200 leaves in a box of 4 m, whose mist has 256 voxels along each side. The sun's strength changes, so that each frame
has all of its light to find. A frame counts as half of what two more frames take: voxels and depths to the sun are
made once.
"""

import argparse
import sys
import tempfile
from pathlib import Path

from .command import NO_PROGRAM, PROGRAM
from .indirect_cost import used

SCENE = """Scene(
    version: 1,
    meshes: {{ "leaf": Leaf(length_m: 0.25, width_m: 0.15), "ground": Quad(size_m: 16.0) }},
    materials: {{ "leaf": (base_color: (0.42, 0.26, 0.06), transmission: (0.38, 0.24, 0.04)) }},
    objects: {{ "ground": (mesh: "ground") }},
    leaves: {{ "crown": (
        count: 200, seed: 1, meshes: ["leaf"], materials: ["leaf"], min_m: (-2.0, 0.5, -2.0), max_m: (2.0, 3.5, 2.0),
    ) }},
    cameras: {{ "main": (position_m: (0.4, 1.5, 7.5), look_at_m: (0.0, 1.5, 0.0)) }},
    lights: {{ "sun": Sun(
        to_sun: (0.33, 0.57, -0.75),
        irradiance_w_per_m2: Keyed(keys: [(at_s: 0.0, value: 8.0), (at_s: 1.0, value: 9.0)]),
    ) }},
    sky: Constant(radiance_w_per_m2_sr: (0.05, 0.07, 0.11)),
    fog: {{ "fog": (min_m: (-2.0, 0.0, -2.0), max_m: (2.0, 4.0, 2.0), anisotropy: 0.5, {fog}) }},
)
"""
FOGS = {
    "even": "density_per_m: 0.25",
    "by voxels": "density_per_m: 0.8, mist: (size_m: 1.0, cover: 0.6, edge_m: 0.2, voxel_m: 0.0157)",
}


def a_frame(file: Path, folder: Path, bounces: str) -> tuple[float, float]:
    """Processor seconds, and megabytes of the process."""
    (one, megabytes), (three, _) = (used(file, bounces, folder, frames=frames, samples=4) for frames in ("1", "1-3"))
    return 0.5 * (three - one), megabytes


def main() -> int:
    """Prints it for single scattering and for all light."""
    plain = argparse.RawDescriptionHelpFormatter
    argparse.ArgumentParser(description=__doc__, formatter_class=plain).parse_args()
    if PROGRAM is None:
        print(f"error: {NO_PROGRAM}", file=sys.stderr)
        return 2
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for bounces, light in (("0", "single scattering"), ("all", "all light")):
            found = {}
            for fog, fields in FOGS.items():
                file = folder / f"{fog}.ron"
                file.write_text(SCENE.format(fog=fields), encoding="utf-8")
                found[fog] = a_frame(file, folder, bounces)
            (even, even_megabytes), (voxels, megabytes) = found.values()
            print(
                f"{light}: even {even:.2f} CPU s and {even_megabytes:.0f} MB, by voxels {voxels:.2f} CPU s and "
                f"{megabytes:.0f} MB, {voxels / even:.1f} times the time",
                flush=True,
            )
    return 0


if __name__ == "__main__":
    sys.exit(main())
