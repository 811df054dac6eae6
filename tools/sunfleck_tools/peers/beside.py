"""One frame of a scene in Blender, by sunfleck and by Cycles; the add-on `sunfleck` is registered."""

import subprocess
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy

from .cycles import pixels_of, settings


@dataclass
class Wish:
    """Parameters of a rendering."""

    program: Path
    frame: int
    size: tuple
    samples: int = 64
    cycles_samples: int = 256
    bounces: int = 0


def pictures(scene, wish: Wish, folder: Path):
    """Both pictures, rows from the top, and the export's findings. The export comes first, as it runs the
    simulations that Cycles then reads."""
    findings = exported(scene, wish, folder)
    return ours(scene, wish, folder), theirs(scene, wish, folder), findings


def exported(scene, wish: Wish, folder: Path):
    """Exports the file; returns the findings."""
    from sunfleck import export

    scene.sunfleck_settings.use_world, scene.sunfleck_settings.sky_lights = True, "surfaces_and_fog"
    settings(scene, wish.size, wish.bounces)
    # The add-on's package of that name, not this one.
    findings = export.exported(scene, folder / "scene.glb").findings  # type: ignore[attr-defined]  # as above
    scene.frame_set(wish.frame)
    return findings


def ours(scene, wish: Wish, folder: Path, volume: str = "auto"):
    """Sunfleck's picture of the file, by a method of `--volume`."""
    from sunfleck import render

    frame = render.flags(scene, False)  # type: ignore[attr-defined]  # the add-on's `render`, too
    out = folder / "ours.exr"
    command = [wish.program, "render", folder / "scene.glb", *frame, "--volume", volume, "--passes", "none"]
    command += ["--samples", wish.samples, "--bounces", wish.bounces, "--out", out]
    subprocess.run([str(one) for one in command], check=True, capture_output=True)
    return pixels_of(out)


def theirs(scene, wish: Wish, folder: Path):
    """Cycles' picture."""
    settings(scene, wish.size, wish.bounces)
    scene.cycles.samples, scene.render.filepath = wish.cycles_samples, str(folder / "cycles.exr")
    bpy.ops.render.render(write_still=True)
    return pixels_of(folder / "cycles.exr")


def ratios_of_blocks(ours, theirs, across: int, down: int, darkest: float):
    """Ratios of block means, ascending, without blocks darker than a fraction of the mean."""
    found = []
    for rows, others in zip(numpy.array_split(ours, down), numpy.array_split(theirs, down)):
        for block, other in zip(*(numpy.array_split(part, across, axis=1) for part in (rows, others))):
            if other.mean() > darkest * theirs.mean():
                found.append(block.mean() / other.mean())
    return sorted(found)


def side_by_side(pictures, white: float) -> bytes:
    """PNG of pictures in a row, with `white` as the white level."""
    from sunfleck.materials.images import png, srgb  # type: ignore[import-not-found]  # the add-on's

    return png(srgb(numpy.concatenate(pictures, axis=1)[::-1] / max(1e-9, white)), False)
