#!/usr/bin/env python3
"""How bright spheres in fog are here, against Mitsuba.

    python3 -m venv .venv && .venv/bin/pip install '.[mitsuba]'
    SUNFLECK=target/release/sunfleck .venv/bin/python tools/peers/sphere_in_fog.py

A sphere of one radiance is points within it here, and gets back what fog takes of their light within it
(docs/decisions/lights.md).
"""

import os
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from sunfleck_tools.exr.decode import decode
from sunfleck_tools.peers import mitsuba
from sunfleck_tools.peers.scene import read_scene

SCENE = """Scene(
    version: 1,
    meshes: {{ "leaf": Leaf(length_m: 0.9, width_m: 0.6, curl_deg: 30), "ground": Quad(size_m: 5) }},
    objects: {{ "leaf": (mesh: "leaf", translation_m: (0.1, 0.7, 0.1), rotation_deg: (60, 30, 0)), "ground": (mesh: "ground") }},
    cameras: {{ "main": (position_m: (0, 1.2, 3.6), look_at_m: (0, 0.6, 0), fov_deg: 40) }},
    lights: {{ "lamp": Point(position_m: (0.8, 2, 1.2), intensity_w_per_sr: 2, radius_m: {radius}) }},
    fog: {{ "haze": (min_m: (-3, 0, -3), max_m: (3, 3, 3), density_per_m: {extinction}, anisotropy: 0.4) }},
)"""
SIZE, SAMPLES, SEEDS = (48, 27), 512, 4


def measured(radius: float, extinction: float, program: str) -> tuple[float, float]:
    """The ratio of mean pictures, and Mitsuba's own noise in it."""
    with tempfile.TemporaryDirectory() as folder:
        scene, frame = Path(folder, "scene.ron"), Path(folder, "frame.exr")
        scene.write_text(SCENE.format(radius=radius, extinction=extinction))
        size = ["--size", f"{SIZE[0]}x{SIZE[1]}", "--samples", "256", "--bounces", "0", "--progress", "none"]
        subprocess.run([program, "render", scene, *size, "--out", frame], check=True, capture_output=True)
        channels = decode(frame)
        ours = np.mean([channels[letter].astype(float).mean() for letter in "RGB"])
        peer = read_scene(scene, None, program)
    peer.size = SIZE
    render = mitsuba.prepare(peer, "scalar_rgb")
    theirs = [render(SAMPLES, seed)[0].mean() for seed in range(1, SEEDS + 1)]
    return ours / np.mean(theirs), np.std(theirs) / np.mean(theirs) / SEEDS**0.5


def main() -> None:
    """Prints a table."""
    print("| radius | extinction | sunfleck / Mitsuba |\n|---|---|---|")
    for radius, extinction in ((0.15, 0.12), (0.3, 0.12), (0.3, 0.4)):
        ratio, noise = measured(radius, extinction, os.environ.get("SUNFLECK", "sunfleck"))
        print(f"| {radius} m | {extinction} /m | {ratio:.4f} +- {noise:.4f} |", flush=True)


if __name__ == "__main__":
    main()
