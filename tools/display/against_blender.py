#!/usr/bin/env python3
"""How far the AgX of our previews is from Blender's, in steps of 8 bits.

    python tools/display/against_blender.py --sunfleck target/release/sunfleck

Needs Python with bpy, OpenEXR and numpy. Every colour fills a place of 8 by 8 pixels of an EXR file. The
program makes a preview of that, as of a frame that is kept; its ordered dither averages to the value over
such a place. Blender saves the same colours through its own view transform with 16 bits.
"""

import argparse
import pathlib
import subprocess
import tempfile

import bpy
import numpy as np
import OpenEXR

PLACE = 8
COLUMNS = 64

KNOWN = [
    [0, 0, 0], [0.18, 0.18, 0.18], [1, 1, 1], [16, 16, 16], [1, 0, 0], [0, 1, 0],
    [0.4, 0.15, 0.02], [8, 3, 0.2], [0.8, 0.5, 0.05],
]

SCENE = (
    'Scene(version: 1, meshes: {"m": Quad(size_m: 1.0)}, materials: {"a": ()}, objects: {"o": (mesh: "m", material: "a")}, \
cameras: {"c": (position_m: (0.0, 1.0, 1.0), look_at_m: (0.0, 0.0, 0.0))}, \
lights: {"s": Sun(to_sun: (0.0, 1.0, 0.0), irradiance_w_per_m2: 1.0)})'
)


def in_blender(colors, folder):
    """What Blender's AgX makes of scene-linear Rec. 709, as sRGB values."""
    image = bpy.data.images.new("colors", len(colors), 1, float_buffer=True)
    image.colorspace_settings.name = "Linear Rec.709"
    image.pixels.foreach_set(np.c_[colors, np.ones(len(colors))].astype(np.float32).ravel())
    scene = bpy.context.scene
    scene.display_settings.display_device = "sRGB"
    scene.view_settings.view_transform, scene.view_settings.look = "AgX", "None"
    settings = scene.render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth = "PNG", "RGB", "16"
    path = str(folder / "blender.png")
    image.save_render(path, scene=scene)
    return pixels(path).reshape(-1, 4)[:, :3]


def pixels(path):
    """A PNG's values from 0 to 1, from the bottom up."""
    image = bpy.data.images.load(path)
    image.colorspace_settings.name = "Non-Color"
    values = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(values)
    return values.reshape(image.size[1], image.size[0], 4)


def in_sunfleck(colors, folder, program):
    """What our preview makes of them."""
    rows = -(-len(colors) // COLUMNS)
    grid = np.zeros((rows * COLUMNS, 3), np.float32)
    grid[: len(colors)] = colors
    grid = grid.reshape(rows, COLUMNS, 3).repeat(PLACE, 0).repeat(PLACE, 1)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {"RGB": np.ascontiguousarray(grid)}).write(str(folder / "colors.exr"))
    (folder / "colors.ron").write_text(SCENE)
    flags = ["--frames", "1", "--out", folder / "colors.exr", "--skip", "exists", "--preview", "png"]
    subprocess.run([program, "render", folder / "colors.ron", *flags], check=True, capture_output=True)
    shown = pixels(str(folder / "colors.png"))[::-1, :, :3]
    return shown.reshape(rows, PLACE, COLUMNS, PLACE, 3).mean((1, 3)).reshape(-1, 3)[: len(colors)]


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sunfleck", default="target/release/sunfleck", help="the program")
    program = parser.parse_args().sunfleck
    random = np.random.default_rng(0)
    stops = lambda count: 2.0 ** random.uniform(-8, 6, (count, 1))
    brighter = 2.0 ** np.linspace(-8, 6, 512)[:, None]
    sets = {
        "greys, 14 stops": brighter * np.ones(3),
        "any colours, 14 stops": random.uniform(0, 1, (4096, 3)) * stops(4096),
        "saturated ones": random.uniform(0, 1, (4096, 3)) ** 4 * stops(4096),
        "a yellow leaf, 14 stops": brighter * [0.8, 0.5, 0.05],
        "an orange leaf, 14 stops": brighter * [0.8, 0.35, 0.05],
        "a red leaf, 14 stops": brighter * [0.6, 0.05, 0.02],
    }
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        for color, shown in zip(KNOWN, in_blender(np.array(KNOWN), folder)):
            print(color, "is", [round(float(value), 5) for value in shown], "in Blender")
        for name, colors in sets.items():
            steps = 255 * np.abs(in_sunfleck(colors, folder, program) - in_blender(colors, folder))
            mean, p99, most = steps.mean(), np.quantile(steps, 0.99), steps.max()
            print(f"{name}: mean {mean:.2f}, 99 % below {p99:.1f}, largest {most:.1f} steps of 8 bits")


if __name__ == "__main__":
    main()
