#!/usr/bin/env python3
"""Measures other renderers on a still glTF scene, for `sunfleck bench --peers`.

    python3.11 -m venv .venv && .venv/bin/pip install -r tools/peers/requirements.txt
    .venv/bin/python tools/peers/measure_peers.py tests/data/leaves500/leaves500.glb \
        tests/data/leaves500/box.exr --reference-noise 0.00143 --out benches/peers/leaves500.csv

Time is that of all processors together, after scene and kernels are built. RMSE is over all pixels and colours, the
reference's own noise taken out.
"""

import argparse
import csv
import datetime
import platform
from pathlib import Path

import numpy

import gltf_scene

COLUMNS = ["renderer", "version", "spp", "cpu_s", "rmse", "date", "machine"]


def machine() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor()
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return f"{len(names)} x {names[0]}" if names else platform.processor()


def read_exr(path: Path) -> numpy.ndarray:
    import mitsuba

    mitsuba.set_variant("scalar_rgb")
    picture = mitsuba.Bitmap(str(path)).convert(mitsuba.Bitmap.PixelFormat.RGB, mitsuba.Struct.Type.Float32, False)
    return numpy.array(picture).astype(float)


def renderers(scene, wanted):
    """Names, versions and what renders them, one after another."""
    for name, variant in [("mitsuba-llvm", "llvm_ad_rgb"), ("mitsuba-scalar", "scalar_rgb")]:
        if name in wanted:
            import mitsuba_peer

            yield name.replace("mitsuba-", "Mitsuba "), mitsuba_peer.version(), mitsuba_peer.prepare(scene, variant)
    if "cycles" in wanted:
        import cycles_peer

        yield "Cycles", cycles_peer.version(), cycles_peer.prepare(scene)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=Path)
    parser.add_argument("reference", type=Path)
    parser.add_argument("--reference-noise", type=float, default=0.0)
    parser.add_argument("--samples", default="1,4,16,64")
    parser.add_argument("--renderers", default="mitsuba-llvm,mitsuba-scalar,cycles")
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()

    scene = gltf_scene.load(arguments.scene)
    reference = read_exr(arguments.reference)
    scene.size = (reference.shape[1], reference.shape[0])
    rows = []
    for name, version, render in renderers(scene, arguments.renderers.split(",")):
        for samples in map(int, arguments.samples.split(",")):
            picture, seconds = render(samples, samples)
            square = float(numpy.mean((picture - reference) ** 2))
            rmse = max(square - arguments.reference_noise**2, 0.0) ** 0.5
            ratio = float(picture.mean() / reference.mean())
            print(f"{name} {version}: {samples} spp, {seconds:.3f} CPU s, RMSE {rmse:.4f}, mean ratio {ratio:.4f}")
            today = datetime.date.today().isoformat()
            rows.append([name, version, samples, f"{seconds:.4g}", f"{rmse:.4g}", today, machine()])
    with arguments.out.open("w", newline="") as file:
        file.write(f"# {arguments.scene.name} at {scene.size[0]} x {scene.size[1]}, by tools/peers/measure_peers.py\n")
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(rows)


if __name__ == "__main__":
    main()
