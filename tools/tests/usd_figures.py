"""The figures of docs/usd.md: `python -m tests.usd_figures` in tools/, with SUNFLECK.

2,000 leaves that fall for 240 frames, there and back: how long, how large, how far from where they were.
"""

import os
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np

from sunfleck_tools.usd import ExportOptions, export_usd, import_usd

from .test_usd_export import PROGRAM, inspect

SCENE = """Scene(
    version: 1,
    meshes: { "leaf": Leaf(length_m: 0.1, width_m: 0.07, curl_deg: 30.0), "ground": Quad(size_m: 20.0) },
    materials: { "gold": (base_color: (0.8, 0.5, 0.05)) },
    objects: { "ground": (mesh: "ground") },
    fall: { "falling": (
        count: 2000, seed: 1, species: [(meshes: ["leaf"], materials: ["gold"], length_m: 0.1)],
        emitter: Box(min_m: (-8.0, 2.0, -8.0), max_m: (8.0, 12.0, 8.0)),
    ) },
    cameras: { "main": (position_m: (0.0, 2.0, 12.0), look_at_m: (0.0, 2.0, 0.0)) },
    lights: { "sun": Sun(to_sun: (0.4, 1.0, -0.6), irradiance_w_per_m2: 8.0) },
)
"""
ROUTES = {
    "instances": ExportOptions(),
    "PointInstancer": ExportOptions(point_instancer=True),
    "PointInstancer for Blender": ExportOptions(point_instancer=True, for_blender=True),
}
FRAMES = [1.0, 17.0, 100.5, 240.0]


def main() -> None:
    """Prints a table."""
    print("| route | export | file | import | worst element of a leaf's matrix, there and back |")
    print("|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        scene, glb, back = folder / "leaves.ron", folder / "leaves.glb", folder / "back.glb"
        scene.write_text(SCENE)
        subprocess.run([PROGRAM, "export", scene, glb, "--frames", "1-240"], check=True, capture_output=True)
        truth = inspect(glb, FRAMES)
        for route, options in ROUTES.items():
            stage = folder / f"{route}.usdc"
            exporting = seconds(lambda: export_usd(glb, stage, options))
            importing = seconds(lambda: import_usd(stage, back))
            found = inspect(back, FRAMES)
            worst = max(
                float(np.abs(np.subtract(found[frame]["nodes"][key]["world"], node["world"])).max())
                for frame, expected in truth.items()
                for key, node in expected["nodes"].items()
                if key.startswith("falling")
            )
            size = os.path.getsize(stage) / 1e6
            print(f"| {route} | {exporting:.1f} s | {size:.1f} MB | {importing:.1f} s | {worst:.1e} |")


def seconds(work) -> float:
    """Processor time."""
    start = time.process_time()
    work()
    return time.process_time() - start


if __name__ == "__main__":
    main()
