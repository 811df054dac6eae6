"""A frame of the program's as pixels of Blender's Render Result."""

import bpy
import numpy

from . import passes
from .exporting import NotRendered


class Picture:
    """A frame: rows from the top, columns, channels by their names."""

    def __init__(self, names, pixels):
        self.numbers, self.pixels = {name: number for number, name in enumerate(names)}, pixels

    def of(self, channels):
        """As Blender has it, rows from the bottom; None if the frame lacks a channel."""
        if not channels or not set(channels) <= self.numbers.keys():
            return None
        found = self.pixels[::-1, :, [self.numbers[channel] for channel in channels]]
        return numpy.ascontiguousarray(found, "f4").ravel()


def read(path):
    """By the library that Blender itself reads frames with."""
    bpy.utils.expose_bundled_modules()
    import OpenImageIO

    file = OpenImageIO.ImageInput.open(str(path))
    if file is None:
        raise NotRendered(f"{path} cannot be read: {OpenImageIO.geterror()}")
    try:
        pixels = file.read_image(OpenImageIO.FLOAT)
        if pixels is None:
            raise NotRendered(f"{path} cannot be read: {file.geterror()}")
        return Picture(file.spec().channelnames, pixels)
    finally:
        file.close()


def hand_over(engine, layer, picture):
    rows, columns = picture.pixels.shape[:2]
    result = engine.begin_result(0, 0, columns, rows, layer=layer)
    for one in result.layers[0].passes:
        found = picture.of(passes.channels_of(one.name, one.channels))
        if found is not None:
            if found.size != len(one.rect) * one.channels:
                engine.end_result(result, cancel=True)
                raise NotRendered(f"the picture has {columns} x {rows} pixels, and Blender's has {len(one.rect)}")
            one.rect.foreach_set(found)
    engine.end_result(result)
